#include "perception/estimators/descriptor.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "perception/cloud/search_cloud.h"
#include "perception/estimators/first_poses.h"
#include "perception/networks/model_file.h"
#include "perception/segment_poses/segment_poses.h"
#include "perception/verify/color_consistency.h"
#include "perception/verify/image_domain.h"
#include "scenes/base/cache_file.h"
#include "scenes/base/error.h"
#include "scenes/base/files.h"

namespace pickbed::perception {
namespace {

IsolatedOptions CodeViews(const EstimatorSetup& setup, const DescriptorOptions& options) {
  IsolatedOptions isolated;
  isolated.patches_per_view = options.code_patches_per_view;
  isolated.views = std::max(1, options.code_entries / options.code_patches_per_view);
  isolated.distance_m = setup.working_distance_m;
  isolated.distance_spread = options.code_distance_spread;
  isolated.focal_px = setup.intrinsics.fx() / SearchBinning(setup);
  return isolated;
}

// Hash of everything that the codebook entries of an object depend on.
uint64_t CodesKey(const DescriptorModel& model, const ObjectModel& object, double side_m,
                  IsolatedOptions isolated, uint64_t seed, const std::string& views) {
  std::string text = WriteSettingsKey([&](SettingsVisitor& v) { isolated.Visit(v); });
  text += fmt::format("{:016x} {:016x} {} {} {}", model.network_hash, object.mesh_hash, side_m,
                      seed, views);
  // network_hash does not depend on the channels.
  if (model.network.channels() == PatchChannels::kDepthColor) text += "rgbd";
  return HashBytes(text.data(), text.size());
}

void RequireKind(const std::string& kind, const LearnedModel& model) {
  CheckInput(model.kind.empty() || kind == model.kind,
             fmt::format("{}: holds a network of kind {}, but {} is needed; make one with {}",
                         model.file.string(), kind, model.kind, model.command));
}

class LearnedEstimator : public PoseEstimator {
 public:
  LearnedEstimator(const EstimatorSetup& setup, const DescriptorOptions& options,
                   const LearnedModel& model)
      : options_(options),
        refiner_(setup.refiner),
        threads_(setup.threads),
        binning_(SearchBinning(setup)),
        model_(LoadModel(model.file, model.command)) {
    RequireKind(model_.info.network.kind, model);
    options_.pose_selection.min_score = setup.spec.min_score;
    if (setup.spec.mode == kFirstMode) options_.first = setup.spec.first;
    trained_ = regressed_ =
        TrainedObjects(model_.info.objects, setup.objects, model.file, model.command);
    for (const int index : trained_) verifiers_.push_back(model_.verifiers[index]);
    PatchVoter voter = VoterOf(model_.network, threads_);
    if (!model.regression.empty()) AddRegression(setup, model.regression, voter);
    finder_ =
        std::make_unique<CandidateFinder>(CandidateObjects(setup), std::move(voter),
                                          options.candidates, setup.threads, ProposerOf(setup));
  }

  EstimateResult Estimate(const EstimatorInput& input, Rng& rng) override;

 private:
  void AddRegression(const EstimatorSetup& setup, const std::filesystem::path& file,
                     PatchVoter& voter);
  std::unique_ptr<PoseProposer> ProposerOf(const EstimatorSetup& setup) const;
  std::vector<CandidateObject> CandidateObjects(const EstimatorSetup& setup) const;
  ObjectCodes Codes(const EstimatorSetup& setup, ObjectId object, double side_m) const;
  void Trace(const OrganizedCloud& cloud, const std::vector<Candidate>& candidates,
             const std::vector<PoseHypothesis>& accepted, EstimateTrace& trace) const;

  DescriptorOptions options_;
  std::string refiner_;
  int threads_;
  int binning_;  // see perception/cloud/search_cloud.h
  DescriptorModel model_;
  std::optional<DescriptorModel> regression_;  // second model, which regresses poses
  std::vector<int> trained_;                   // by object: index into model_.info.objects
  std::vector<int> regressed_;                 // by object: index into the regressing model
  std::vector<Verifier> verifiers_;            // by object
  std::unique_ptr<CandidateFinder> finder_;
};

void LearnedEstimator::AddRegression(const EstimatorSetup& setup, const std::filesystem::path& file,
                                     PatchVoter& voter) {
  constexpr double kSameSide_m = 1e-6;
  constexpr const char* kCommand = "`pickbed train doumanoglou`";
  regression_.emplace(LoadModel(file, kCommand));
  regressed_ = TrainedObjects(regression_->info.objects, setup.objects, file, kCommand);
  CheckInput(regression_->network.channels() == model_.network.channels(),
             fmt::format("{}: its regression network was trained on {}, but the descriptor network "
                         "on {}; train both on the same input",
                         file.string(), NameOf(regression_->network.channels()),
                         NameOf(model_.network.channels())));
  for (size_t i = 0; i < regressed_.size(); ++i) {
    const double side_m = regression_->info.objects[regressed_[i]].side_m;
    const double wanted_m = model_.info.objects[trained_[i]].side_m;
    CheckInput(std::abs(side_m - wanted_m) < kSameSide_m,
               fmt::format("{}: its patches of object '{}' are {} m large, but the "
                           "descriptor model uses {} m; train it with the same patch_diameters",
                           file.string(), setup.objects[i]->name, side_m, wanted_m));
  }
  const PatchVoter regressing = VoterOf(regression_->network, threads_);
  voter.regress = regressing.regress;
  voter.object_count = regressing.object_count;
}

// Null without spec.completion.
std::unique_ptr<PoseProposer> LearnedEstimator::ProposerOf(const EstimatorSetup& setup) const {
  if (setup.spec.completion == kNoCompletion) return nullptr;
  CheckInput(setup.spec.mode != kFirstMode,
             "estimator.completion: mode first searches regions and completes no shapes; choose "
             "mode fast or accurate");
  CheckInput(setup.views, "estimator.completion: its codebooks need a renderer");
  SegmentPoseOptions options;
  options.completion.method = setup.spec.completion;
  options.completion.model = setup.spec.completion_model;
  options.book.distance_m = setup.working_distance_m;
  options.book.focal_px = setup.intrinsics.fx() / binning_;
  return std::make_unique<SegmentPoses>(
      SegmentPoseSetup{*setup.views, setup.cache_dir, setup.on_progress}, options);
}

std::vector<CandidateObject> LearnedEstimator::CandidateObjects(const EstimatorSetup& setup) const {
  std::vector<CandidateObject> candidate_objects;
  for (size_t i = 0; i < setup.objects.size(); ++i) {
    const double side_m = model_.info.objects[trained_[i]].side_m;
    ObjectCodes codes;
    if (options_.candidates.votes != "regressed") {
      codes = Codes(setup, ObjectId(i), side_m);
    }
    candidate_objects.push_back({setup.objects[i], side_m, std::move(codes), regressed_[i]});
  }
  return candidate_objects;
}

ObjectCodes LearnedEstimator::Codes(const EstimatorSetup& setup, ObjectId object,
                                    double side_m) const {
  const ObjectModel& object_model = *setup.objects[object];
  const IsolatedOptions isolated = CodeViews(setup, options_);
  CheckInput(setup.views,
             fmt::format("the codebook of object '{}' needs a renderer", object_model.name));
  const uint64_t key = CodesKey(model_, object_model, side_m, isolated, options_.code_seed,
                                setup.views->IsolatedSettings());
  const auto on_share = [&](double share) {
    if (setup.on_progress) setup.on_progress("codebook of " + object_model.name, share);
  };
  const auto make = [&] {
    return MakeObjectCodes(*setup.views, object, {side_m, model_.network.channels()},
                           model_.network.length(), VoterOf(model_.network, threads_).describe,
                           isolated, options_.code_seed, threads_, on_share);
  };
  if (setup.cache_dir.empty()) return make();
  return Cached(
      CodesFile(setup.cache_dir, object_model, key),
      [key](const std::string& content) { return CodesFromBytes(content, key); }, make,
      [key](const ObjectCodes& codes) { return CodesToBytes(codes, key); });
}

void LearnedEstimator::Trace(const OrganizedCloud& cloud, const std::vector<Candidate>& candidates,
                             const std::vector<PoseHypothesis>& accepted,
                             EstimateTrace& trace) const {
  trace.cloud = cloud;
  trace.neighbors = options_.candidates.neighbors;
  trace.min_score = options_.pose_selection.min_score;
  const std::vector<ModelPoints>& models = finder_->candidate_refiner().model_points();
  const CommonColors colors(cloud, models, accepted);
  PoseSelectionOptions all = options_.pose_selection;
  all.min_score = 0;
  const std::vector<double> scores = CandidateScores(
      cloud, models, finder_->candidate_refiner().distances(), verifiers_, candidates, all);
  for (size_t i = 0; i < candidates.size(); ++i) {
    PoseHypothesis scored = candidates[i].hypothesis;
    scored.score = scores[i];
    colors.LowerIfOdd(scored);
    trace.candidates.push_back({std::move(scored), candidates[i].features});
  }
  trace.accepted = accepted;
}

EstimateResult LearnedEstimator::Estimate(const EstimatorInput& input, Rng& rng) {
  EstimateResult result;
  OrganizedCloud cloud;
  {
    const StageTimer timer(result.seconds, "cloud");
    cloud = SearchCloud(input.frame, input.background, binning_, input.region,
                        input.fits_background, threads_);
  }
  result.has_background = input.background.has_value() || !cloud.planes.empty();
  result.domain_warnings = DomainWarnings(DomainOf(cloud));
  std::vector<Candidate> candidates;
  if (options_.first) {
    const FirstPosesSearch search{*finder_, verifiers_, options_.pose_selection, *options_.first};
    FirstPoses found = FindFirstPoses(search, cloud, input, rng, result.seconds);
    candidates = std::move(found.candidates);
    result.hypotheses = std::move(found.hypotheses);
  } else {
    candidates = finder_->Find(cloud, rng, result.seconds, input.trace);
    const StageTimer timer(result.seconds, "non_maximum_suppression");
    result.hypotheses = SelectPoses(cloud, finder_->candidate_refiner().model_points(),
                                    finder_->candidate_refiner().distances(), verifiers_,
                                    candidates, options_.pose_selection, input.instances);
  }
  if (input.trace) {
    Trace(cloud, candidates, result.hypotheses, *input.trace);
    input.trace->instances = input.instances;
  }
  {
    const StageTimer timer(result.seconds, "refine");
    RefineFinally(refiner_, cloud, finder_->candidate_refiner().model_points(), threads_,
                  result.hypotheses);
  }
  return result;
}

}  // namespace

void DescriptorOptions::Visit(SettingsVisitor& v) {
  v.Integer("code_entries", code_entries, {1, 10000000}, "number of codebook entries per object");
  v.Integer("code_patches_per_view", code_patches_per_view, {1, 1000},
            "number of patches per isolated view");
  v.Real("code_distance_spread", code_distance_spread, {0, 0.9},
         "relative spread of the view distances about the working distance");
  v.Seed("code_seed", code_seed, "random seed of the codebook's views");
  v.Group(
      "candidates", [&](SettingsVisitor& g) { candidates.Visit(g); },
      "settings of the candidate search");
}

DescriptorOptions OptionsForMode(const std::string& mode) {
  DescriptorOptions options;
  if (mode == "fast" || mode == kFirstMode) {
    options.pose_selection.mode = CandidateMode::kFast;
    return options;
  }
  CheckInput(mode == "accurate",
             UnknownNameMessage("estimator mode", mode, {"fast", "accurate", kFirstMode}));
  options.candidates = AccurateCandidates();
  return options;
}

std::unique_ptr<PoseEstimator> MakeLearnedEstimator(const EstimatorSetup& setup,
                                                    const DescriptorOptions& options,
                                                    const LearnedModel& model) {
  CheckSettings("DescriptorOptions", options);
  return std::make_unique<LearnedEstimator>(setup, options, model);
}

std::unique_ptr<PoseEstimator> MakeDescriptorEstimator(const EstimatorSetup& setup,
                                                       const DescriptorOptions& options) {
  return MakeLearnedEstimator(setup, options,
                              {ModelFileOr(setup.spec, kShippedModel), "", kTrainCommand});
}

std::unique_ptr<PoseEstimator> MakeDescriptorEstimator(const EstimatorSetup& setup) {
  return MakeDescriptorEstimator(setup, OptionsForMode(setup.spec.mode));
}

std::unique_ptr<EstimatorTraining> MakeDescriptorTraining() {
  return MakePatchNetworkTraining(kShippedModel, {});
}

}  // namespace pickbed::perception
