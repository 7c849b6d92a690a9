#include "perception/training.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <numbers>
#include <numeric>

#include "perception/checkpoint.h"
#include "perception/torch_model_file.h"
#include "perception/training_data.h"
#include "perception/verifier_training.h"
#include "scenes/check.h"

namespace pickbed {
namespace {

using Clock = std::chrono::steady_clock;

double SecondsSince(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

// Settings and parts, without what may change between two sessions of one training.
std::string CheckpointKey(const ObjectSet& objects, TrainingOptions options,
                          const std::string& sensor) {
  options.max_minutes = 0;
  options.checkpoint_every = TrainingOptions{}.checkpoint_every;
  std::string key = WriteSettings([&](SettingsVisitor& v) { options.Visit(v); });
  key += "sensor " + sensor;
  for (const auto& object : objects) {
    key += fmt::format("\n{} {:016x}", object->name, object->mesh_hash);
  }
  return key;
}

// Runs `work`; an InputError that it throws gets the part's name in front.
template <typename Work>
auto BlamePart(const ObjectModel& part, const Work& work) {
  try {
    return work();
  } catch (const InputError& error) {
    throw InputError("part '" + part.name + "': " + error.what());
  }
}

// One training from views to model file.
class Trainer {
 public:
  Trainer(const TrainingJob& job, const TrainingOptions& options)
      : job_(job),
        options_(options),
        objects_(job.views.objects()),
        key_(CheckpointKey(objects_, options, job.sensor_profile)),
        network_(options.network, options.seed),
        sides_(Sides(objects_, options)),
        data_(objects_, sides_, options) {}

  TrainingReport Run();

 private:
  static std::vector<double> Sides(const ObjectSet& objects, const TrainingOptions& options) {
    std::vector<double> sides;
    for (const auto& object : objects) {
      sides.push_back(PatchSide(object->diameter_m, options.patch_diameters));
    }
    return sides;
  }
  int Iterations() const { return options_.iterations * static_cast<int>(objects_.size()); }
  bool Report(const char* phase, double share, int total, Clock::time_point phase_start);
  void StartFrom(const std::filesystem::path& file);
  bool CollectViews();
  bool TrainNetwork();
  double ScheduleShare(int iteration) const;
  void SaveCheckpoint(int iteration) const;
  std::vector<TrainedVerifier> TrainVerifiers();
  double RecentLoss() const;
  void Save(const std::vector<TrainedVerifier>& trained);

  const TrainingJob& job_;
  const TrainingOptions& options_;
  const ObjectSet& objects_;
  std::string key_;
  DescriptorNetwork network_;
  std::vector<double> sides_;
  TrainingData data_;
  TrainingReport report_;
  Clock::time_point start_ = Clock::now();
};

void Trainer::StartFrom(const std::filesystem::path& file) {
  const DescriptorModel model = LoadModel(file);
  CheckInput(model.info.network.kind == options_.network.kind &&
                 model.info.network.descriptor == options_.network.descriptor,
             fmt::format("{}: its network is {} with descriptors of {}, not {} with {}; set "
                         "network.kind and network.descriptor to those",
                         file.string(), model.info.network.kind, model.info.network.descriptor,
                         options_.network.kind, options_.network.descriptor));
  network_.SetWeights(model.network.Weights());
}

bool Trainer::Report(const char* phase, double share, int total, Clock::time_point phase_start) {
  if (!job_.on_progress) return true;
  TrainingProgress progress;
  progress.phase = phase;
  progress.done = static_cast<int>(std::lround(share * total));
  progress.total = total;
  progress.loss = RecentLoss();
  progress.seconds_left = share > 0 ? SecondsSince(phase_start) * (1 - share) / share : 0;
  return job_.on_progress(progress);
}

double Trainer::RecentLoss() const {
  const std::vector<double>& losses = report_.loss_history;
  const size_t count = std::min<size_t>(100, losses.size());
  return count == 0 ? 0 : std::accumulate(losses.end() - count, losses.end(), 0.0) / count;
}

bool Trainer::CollectViews() {
  const Clock::time_point phase = Clock::now();
  const int piles = options_.piles * static_cast<int>(objects_.size());
  return data_.Collect(job_.views,
                       [&](double share) { return Report("views", share, piles, phase); });
}

double Trainer::ScheduleShare(int iteration) const {
  const double by_count = static_cast<double>(iteration) / Iterations();
  const double limit_s = 60 * options_.max_minutes;
  return limit_s > 0 ? std::max(by_count, SecondsSince(start_) / limit_s) : by_count;
}

void Trainer::SaveCheckpoint(int iteration) const {
  if (job_.checkpoint.empty()) return;
  WriteCheckpoint(job_.checkpoint,
                  {key_, iteration, report_.loss_history, network_.TrainingState()});
}

bool Trainer::TrainNetwork() {
  int iteration = 0;
  if (job_.resume) {
    const Checkpoint checkpoint = ReadCheckpoint(job_.checkpoint, key_);
    iteration = checkpoint.iteration;
    report_.loss_history = checkpoint.loss_history;
    network_.RestoreTrainingState(checkpoint.training_state);
  }
  const Clock::time_point phase = Clock::now();
  const double first_share = ScheduleShare(iteration);
  for (double share = first_share; share < 1; share = ScheduleShare(iteration)) {
    const double rate = 0.5 * options_.learning_rate * (1 + std::cos(std::numbers::pi * share));
    const double loss = network_.TrainStep(data_.Batch(iteration), options_.loss, rate);
    CheckInput(std::isfinite(loss), fmt::format("training diverged at step {}; lower "
                                                "learning_rate ({})",
                                                iteration, options_.learning_rate));
    report_.loss_history.push_back(loss);
    ++iteration;
    if (iteration % options_.checkpoint_every == 0) SaveCheckpoint(iteration);
    const double done = (ScheduleShare(iteration) - first_share) / (1 - first_share);
    if (!Report("network", done, Iterations(), phase)) {
      SaveCheckpoint(iteration);
      return false;
    }
  }
  SaveCheckpoint(iteration);
  return true;
}

// One verifier for each part; fewer when asked to stop.
std::vector<TrainedVerifier> Trainer::TrainVerifiers() {
  const Clock::time_point phase = Clock::now();
  const int parts = static_cast<int>(objects_.size());
  const int piles = options_.verifier_piles * parts;
  VerifierTrainingOptions options;
  options.seed = options_.seed;
  options.piles = options_.verifier_piles;
  options.views_per_pile = options_.views_per_pile;
  options.verifier = options_.verifier;
  std::vector<TrainedVerifier> trained;
  for (int i = 0; i < parts; ++i) {
    const VerifierPart part{
        i,
        sides_[i],
        network_.length(),
        [&](std::span<const int8_t> patches) { return network_.Describe(patches); },
        options_.verifier_entries,
        options_.candidates};
    bool go_on = true;
    TrainedVerifier verifier = BlamePart(*objects_[i], [&] {
      return TrainPartVerifier(job_.views, i, DescriptorSource(job_.views, part, options.seed),
                               options, [&](double share) {
                                 return go_on =
                                            Report("verifier", (i + share) / parts, piles, phase);
                               });
    });
    if (!go_on) return trained;
    trained.push_back(std::move(verifier));
  }
  Report("verifier", 1, piles, phase);
  return trained;
}

void Trainer::Save(const std::vector<TrainedVerifier>& trained) {
  ModelInfo info;
  std::vector<Verifier> verifiers;
  for (size_t i = 0; i < objects_.size(); ++i) {
    info.objects.push_back({objects_[i]->name, objects_[i]->mesh_hash, objects_[i]->diameter_m,
                            sides_[i], trained[i].auc});
    verifiers.push_back(trained[i].verifier);
    report_.verifier_auc += trained[i].auc / static_cast<double>(objects_.size());
  }
  info.sensor = job_.sensor_profile;
  info.network = options_.network;
  TrainingOptions options = options_;
  info.training = WriteSettings([&](SettingsVisitor& v) { options.Visit(v); });
  info.iterations = static_cast<int>(report_.loss_history.size());
  info.loss = RecentLoss();
  SaveModel(job_.model_file, info, network_, verifiers);
}

TrainingReport Trainer::Run() {
  // A checkpoint that cannot be used is told before minutes are spent on views.
  if (job_.resume) ReadCheckpoint(job_.checkpoint, key_);
  if (!job_.start_from.empty()) StartFrom(job_.start_from);
  bool go_on = options_.iterations == 0 || (CollectViews() && TrainNetwork());
  if (go_on) {
    const std::vector<TrainedVerifier> trained = TrainVerifiers();
    go_on = trained.size() == objects_.size();
    if (go_on) Save(trained);
  }
  report_.finished = go_on;
  report_.seconds = SecondsSince(start_);
  return report_;
}

}  // namespace

void TrainingOptions::Visit(SettingsVisitor& v) {
  v.Seed("seed", seed, "of weights, views and batches");
  v.Integer("piles", piles, {1, 100000}, "training piles per part");
  v.Integer("views_per_pile", views_per_pile, {1, 100}, "views of each");
  v.Group(
      "twins", [&](SettingsVisitor& g) { twins.Visit(g); }, "the pairs to learn from");
  v.Integer("iterations", iterations, {0, 10000000}, "steps per part; 0 = verifiers alone");
  v.Integer("batch", batch, {2, 100000}, "pairs of patches in a step");
  v.Real("main_share", main_share, {0, 1}, "share of a batch that is of one part");
  v.Real("patch_diameters", patch_diameters, {0.05, 4}, "side of a patch over the diameter");
  v.Real("learning_rate", learning_rate, {1e-7, 1}, "of Adam, at the start of the cosine");
  v.Integer("verifier_piles", verifier_piles, {1, 100000}, "piles per part for the verifier");
  v.Integer("verifier_entries", verifier_entries, {1, 10000000},
            "code book entries per part while the verifier learns");
  v.Integer("checkpoint_every", checkpoint_every, {1, 1000000}, "steps");
  v.Real("max_minutes", max_minutes, {0, 1e6}, "of views and network; 0 = no limit");
  v.Group(
      "network", [&](SettingsVisitor& g) { network.Visit(g); }, "the network");
  v.Group(
      "loss", [&](SettingsVisitor& g) { loss.Visit(g); }, "what it is taught");
  v.Group(
      "verifier", [&](SettingsVisitor& g) { verifier.Visit(g); }, "the verifier's training");
  v.Group(
      "candidates", [&](SettingsVisitor& g) { candidates.Visit(g); },
      "how the candidates are found that the verifier learns on");
}

TrainingReport TrainDescriptor(const TrainingJob& job, const TrainingOptions& options) {
  CheckInput(!job.views.objects().empty(), "training needs at least one part");
  CheckInput(!job.resume || !job.checkpoint.empty(), "resuming needs a checkpoint file");
  return Trainer(job, options).Run();
}

}  // namespace pickbed
