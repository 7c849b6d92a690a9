#include "perception/estimators/wohlhart.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "perception/crop_methods/crop_lookup.h"
#include "perception/estimators/descriptor.h"
#include "perception/estimators/verified_estimator.h"
#include "perception/features/patch.h"
#include "perception/training/wohlhart_training.h"
#include "scenes/base/error.h"

namespace pickbed::perception {
namespace {

constexpr const char* kWohlhartName = "wohlhart";
constexpr uint64_t kTemplateSeed = 0;  // for the sensor noise on templates

// Settings text of a trained network.
struct Record {
  std::string objects;  // names, separated by commas
  std::string meshes;   // mesh hashes, separated by commas
  WohlhartBinOptions options;
  void Visit(SettingsVisitor& v) {
    v.RenamedKey("parts", "objects");
    v.Text("objects", objects, {}, "names of the objects that it was trained for");
    v.Text("meshes", meshes, {}, "hashes of their meshes");
    options.Visit(v);
  }
};

Record RecordOf(const ObjectSet& objects, const WohlhartBinOptions& options) {
  std::vector<std::string> names, hashes;
  for (const auto& object : objects) {
    names.push_back(object->name);
    hashes.push_back(fmt::format("{:016x}", object->mesh_hash));
  }
  return {fmt::format("{}", fmt::join(names, ",")), fmt::format("{}", fmt::join(hashes, ",")),
          options};
}

ObjectId IndexIn(const ObjectSet& all, const ObjectModel& object) {
  for (size_t i = 0; i < all.size(); ++i) {
    if (all[i]->name == object.name) return ObjectId(i);
  }
  throw InputError(fmt::format("no views of object '{}'", object.name));
}

// Templates of all objects with their search index.
struct Templates {
  std::vector<std::vector<Pose>> X_PO;  // by object and view
  std::unique_ptr<CropMethod> lookup;
};

Templates MakeTemplates(const ObjectSet& objects, LabelledViewSource& views, const Record& record,
                        std::shared_ptr<const WohlhartNetwork> network, int threads) {
  const std::string known = "," + record.objects + ",";
  CropTrainingSet training_set{objects, {}, {}};
  Templates templates;
  for (size_t index = 0; index < objects.size(); ++index) {
    const ObjectModel& object = *objects[index];
    CheckInput(known.find("," + object.name + ",") != std::string::npos,
               fmt::format("the network was trained for {} and not for object '{}'; train it again "
                           "with all of them",
                           record.objects, object.name));
    WholeTemplates made = MakeWholeTemplates(views, IndexIn(views.objects(), object),
                                             record.options.views.templates, kTemplateSeed);
    made.crops.object = ObjectId(index);
    training_set.templates.push_back(std::move(made.crops));
    templates.X_PO.push_back(std::move(made.X_PO));
  }
  const int length = network->length();
  templates.lookup = MakeCropLookup(
      std::make_shared<const CropTrainingSet>(std::move(training_set)),
      [network = std::move(network)](const CropSet& crops, int threads) {
        return network->Describe(crops, threads);
      },
      length, threads);
  return templates;
}

class WohlhartCandidates : public CandidateSource {
 public:
  WohlhartCandidates(const ObjectSet& objects, const WohlhartBinOptions& options,
                     Templates templates, const CandidateRefinementOptions& refinement, int threads)
      : objects_(objects),
        options_(options),
        templates_(std::move(templates)),
        candidate_refiner_(objects, refinement, threads),
        threads_(threads) {}

  std::vector<Candidate> Find(const OrganizedCloud& cloud, Rng&, StageSeconds& seconds,
                              EstimateTrace* trace = nullptr) const override {
    const std::vector<int> pixels = GridProposals(cloud, options_.grid_px);
    std::vector<Candidate> candidates;
    for (size_t index = 0; index < objects_.size(); ++index) {
      const std::vector<PoseVote> votes = Votes(ObjectId(index), cloud, pixels, seconds);
      if (votes.empty()) continue;
      const std::vector<Candidate> of_object = candidate_refiner_.RefineCandidates(
          cloud, ObjectId(index), votes, static_cast<int>(pixels.size()), {}, seconds, trace);
      candidates.insert(candidates.end(), of_object.begin(), of_object.end());
    }
    candidate_refiner_.Compare(candidates, seconds);
    return candidates;
  }

  const CandidateRefiner& candidate_refiner() const override { return candidate_refiner_; }

 private:
  // Casts votes from crops of this object's size. A neighbour of another object casts no vote.
  std::vector<PoseVote> Votes(ObjectId object, const OrganizedCloud& cloud,
                              const std::vector<int>& pixels, StageSeconds& seconds) const {
    CropSet crops;
    {
      const StageTimer timer(seconds, "crops");
      crops = CutWholeCrops(cloud, pixels, CropSide_m(*objects_[object], options_.views.templates));
    }
    const StageTimer timer(seconds, "network");
    const auto answers = templates_.lookup->Answer(crops, options_.neighbors, threads_);
    std::vector<PoseVote> votes;
    for (size_t i = 0; i < answers.size(); ++i) {
      const Pose X_CP = PatchFrame(crops.spots[i].center_C, 0);
      for (const CropAnswer& answer : answers[i]) {
        if (answer.object != object) continue;
        votes.push_back({X_CP * templates_.X_PO[object][answer.view], static_cast<int>(i)});
      }
    }
    return votes;
  }

  ObjectSet objects_;
  WohlhartBinOptions options_;
  Templates templates_;
  CandidateRefiner candidate_refiner_;
  int threads_;
};

class WohlhartTraining : public EstimatorTraining {
 public:
  explicit WohlhartTraining(const WohlhartBinOptions& options) : options_(options) {}

  TrainingKind kind() const override { return TrainingKind::kNetworkAndVerifiers; }
  std::filesystem::path ModelFile(const EstimatorSpec& spec) const override {
    return ModelFileOr(spec, kWohlhartName);
  }
  std::unique_ptr<CandidateSource> MakeCandidates(const CandidateSetup& setup) const override {
    return MakeWohlhartCandidates(setup.objects, setup.views, setup.network, AccurateCandidates());
  }
  void VisitNetworkOptions(SettingsVisitor& v) override { options_.Visit(v); }
  std::string NetworkSettings(const ObjectSet& objects) const override {
    Record record = RecordOf(objects, options_);
    return WriteSettingsKey([&](SettingsVisitor& v) { record.Visit(v); });
  }
  std::optional<LearnedNetwork> TrainNetwork(const NetworkTrainingJob& job) const override;

 private:
  WohlhartBinOptions options_;
};

std::optional<LearnedNetwork> WohlhartTraining::TrainNetwork(const NetworkTrainingJob& job) const {
  constexpr double kViewsShare = 0.2;  // approximate share of the time
  CheckInput(options_.network.input == "depth",
             "network.input: crops of bins have only depth; leave it at depth");
  bool go_on = true;
  const auto report = [&](double share) {
    return go_on = go_on && (!job.on_share || job.on_share(share));
  };
  const CropTrainingSet training_set =
      MakeWholeTrainingSet(job.views, options_.views, job.seed,
                           [&](double share) { return report(kViewsShare * share); });
  if (!go_on) return std::nullopt;
  const auto network = TrainWohlhart(
      {training_set, job.seed, job.checkpoint,
       [&](double share, double) { return report(kViewsShare + (1 - kViewsShare) * share); },
       job.threads},
      options_.network);
  if (network == nullptr) return std::nullopt;
  return LearnedNetwork{NetworkSettings(job.views.objects()), network->Weights()};
}

}  // namespace

void WohlhartBinOptions::Visit(SettingsVisitor& v) {
  v.Group(
      "views", [&](SettingsVisitor& g) { views.Visit(g); },
      "views of the templates and for training");
  v.Group(
      "network", [&](SettingsVisitor& g) { network.Visit(g); }, "the learned descriptor");
  v.Integer("grid_px", grid_px, {1, 100}, "distance between two proposals along x and y, px");
  v.Integer("neighbors", neighbors, {1, 100}, "number of nearest templates that vote for a crop");
}

std::unique_ptr<CandidateSource> MakeWohlhartCandidates(
    const ObjectSet& objects, LabelledViewSource& views, const LearnedNetwork& network,
    const CandidateRefinementOptions& refinement, int threads) {
  Record record;
  ReadSettingsText(network.settings, "settings of the network",
                   [&](SettingsVisitor& v) { record.Visit(v); });
  auto weighted = std::make_shared<WohlhartNetwork>(record.options.network, 0);
  weighted->SetWeights(network.weights);
  Templates templates = MakeTemplates(objects, views, record, std::move(weighted), threads);
  return std::make_unique<WohlhartCandidates>(objects, record.options, std::move(templates),
                                              refinement, threads);
}

std::unique_ptr<EstimatorTraining> MakeWohlhartTraining(const WohlhartBinOptions& options) {
  CheckSettings("WohlhartBinOptions", options);
  return std::make_unique<WohlhartTraining>(options);
}

std::unique_ptr<EstimatorTraining> MakeWohlhartTraining() { return MakeWohlhartTraining({}); }

std::unique_ptr<PoseEstimator> MakeWohlhartEstimator(const EstimatorSetup& setup) {
  CheckInput(setup.views, "the templates of estimator wohlhart need a renderer");
  const std::filesystem::path file = ModelFileOr(setup.spec, kWohlhartName);
  const VerifierFile trained = LoadVerifiers(file, kWohlhartName);
  VerifiedSetup made;
  made.verifiers = VerifiersOf(trained, setup.objects, file);
  made.source = MakeWohlhartCandidates(setup.objects, *setup.views, trained.network,
                                       OptionsForMode(setup.spec.mode).candidates, setup.threads);
  made.pose_selection.min_score = setup.spec.min_score;
  made.refiner = setup.refiner;
  made.threads = setup.threads;
  made.binning = SearchBinning(setup);
  return MakeVerifiedEstimator(std::move(made));
}

}  // namespace pickbed::perception
