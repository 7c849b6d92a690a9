#include "perception/completion/completion_training.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <numbers>
#include <numeric>

#include "perception/completion/completion_file.h"
#include "perception/completion/sample_stream.h"
#include "scenes/base/byte_blocks.h"
#include "scenes/base/error.h"
#include "scenes/base/files.h"
#include "scenes/base/parallel.h"
#include "scenes/base/random.h"

namespace pickbed::perception {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::string_view kCheckpointMagic = "PICKCPCK";
constexpr uint64_t kCheckpointVersion = 1;
// Steps in the mean of the loss that is shown.
constexpr int kShownSteps = 100;
// Groups that the threads make ahead.
constexpr int kAhead = 32;
// Held-out views evaluated at once.
constexpr int kEvaluated = 16;

struct HeldOutSample {
  CompletionSample sample;
  bool is_occluded = false;
};
using HeldOutViews = std::vector<HeldOutSample>;

std::vector<const ShapeFamilyRow*> FamiliesOf(const std::vector<ShapeDomain>& domains,
                                              bool held_out) {
  std::vector<const ShapeFamilyRow*> families;
  for (const ShapeDomain domain : domains) {
    const auto some = ShapeFamiliesOf(domain, held_out);
    families.insert(families.end(), some.begin(), some.end());
  }
  return families;
}

std::string KeyOf(const CompletionJob& job, CompletionTrainingOptions options) {
  const CompletionTrainingOptions defaults;
  options.max_minutes = 0;
  options.checkpoint_every = defaults.checkpoint_every;
  options.threads = defaults.threads;
  std::string key = WriteSettingsKey([&](SettingsVisitor& v) { options.Visit(v); });
  for (const ShapeDomain domain : job.domains) key += ShapeDomainName(domain) + "\n";
  for (const std::string& name : job.sensor_names) key += name + "\n";
  for (const ShapeFamilyRow* family : FamiliesOf(job.domains, false)) {
    key += std::string(family->name) + "\n";
  }
  return key;
}

CompletionQuality QualityOn(const HeldOutViews& views, const CompletionNetwork& network) {
  CompletionQuality quality;
  double points = 0, sums[2] = {0, 0};
  int counts[2] = {0, 0};
  for (size_t first = 0; first < views.size(); first += kEvaluated) {
    const size_t last = std::min(views.size(), first + kEvaluated);
    std::vector<TurnedSample> samples;
    for (size_t i = first; i < last; ++i) samples.push_back({&views[i].sample, 0});
    const CompletionBatch batch = BatchOf(samples);
    const std::vector<float> probabilities = network.Probabilities(batch);
    for (int view = 0; view < batch.count; ++view) {
      int both = 0, either = 0;
      for (int i = view * batch.points; i < (view + 1) * batch.points; ++i) {
        const bool inside = batch.inside[i] > 0.5f, thought = probabilities[i] > 0.5f;
        both += inside && thought;
        either += inside || thought;
        const float truth = inside ? probabilities[i] : 1 - probabilities[i];
        quality.loss -= std::log(std::max(truth, 1e-7f));
      }
      points += batch.points;
      const bool is_occluded = views[first + view].is_occluded;
      sums[is_occluded] += either > 0 ? static_cast<double>(both) / either : 1;
      ++counts[is_occluded];
    }
  }
  quality.loss /= std::max(points, 1.0);
  quality.iou_clean = sums[0] / std::max(counts[0], 1);
  quality.iou_occluded = sums[1] / std::max(counts[1], 1);
  return quality;
}

// Reads a block with one value.
template <typename Value>
Value OneOf(BlockReader& reader) {
  const std::vector<Value> values = reader.TakeAll<Value>();
  CheckInput(values.size() == 1, "the file has another layout");
  return values.front();
}

// One training, from views to model file.
class CompletionTrainer {
 public:
  CompletionTrainer(const CompletionJob& job, const CompletionTrainingOptions& options)
      : job_(job),
        options_(options),
        key_(KeyOf(job, options)),
        network_(options.network, options.seed, options.device) {
    source_.families = FamiliesOf(job.domains, false);
    source_.sensors = job.sensors;
    source_.views = options.views;
    source_.points = options.points;
    source_.views_per_shape = options.views_per_shape;
    source_.volumes = CompletionNetwork::NeedsVolumes(options.network);
  }

  CompletionReport Run() {
    if (job_.resume) Resume();
    MakeHeldOut();
    if (!Train()) return report_;
    Save();
    report_.finished = true;
    return report_;
  }

 private:
  double Seconds() const {
    return report_.seconds + std::chrono::duration<double>(Clock::now() - start_).count();
  }
  double Share(int step) const {
    const double by_steps = static_cast<double>(step) / options_.steps;
    if (options_.max_minutes <= 0) return by_steps;
    return std::max(by_steps, Seconds() / (60 * options_.max_minutes));
  }
  void Resume();
  void MakeHeldOut();
  bool Train();
  void Step(int step, double share, SampleStream& stream);
  void Measure(int step);
  bool HasConverged() const;
  void SaveCheckpoint(int step);
  bool Report(const char* phase, int done, int total, double seconds_left);
  void Save();
  // Groups in use at a step: from the returned one, options_.window of them.
  int64_t FirstGroup(int step) const {
    const double groups =
        static_cast<double>(step) * options_.batch / (options_.uses * options_.views_per_shape);
    return static_cast<int64_t>(groups);
  }

  const CompletionJob& job_;
  const CompletionTrainingOptions options_;
  const std::string key_;
  CompletionNetwork network_;
  CompletionSource source_;
  HeldOutViews held_out_[kHeldOutSplitCount];
  CompletionReport report_;
  int first_step_ = 0;
  Clock::time_point start_ = Clock::now();
};

void CompletionTrainer::Resume() {
  const CompletionCheckpoint saved = ReadCompletionCheckpoint(job_.checkpoint, key_);
  network_.RestoreTrainingState(saved.training_state);
  first_step_ = saved.step;
  report_.loss_history = saved.loss_history;
  report_.measurements = saved.measurements;
  report_.seconds = saved.seconds;
  report_.has_checkpoint = true;
}

void CompletionTrainer::MakeHeldOut() {
  for (int split = 0; split < kHeldOutSplitCount; ++split) {
    CompletionSource source = source_;
    if (split == 1) source.split = ShapeSplit::kUnseenSizes;
    if (split == 2) source.families = FamiliesOf(job_.domains, true);
    if (source.families.empty()) continue;
    HeldOutViews& views = held_out_[split];
    views.resize(options_.held_out);
    Report("held-out views", split, kHeldOutSplitCount, -1);
    // One shape for each view, clean and occluded in turn.
    source.views_per_shape = 1;
    ForRanges(options_.held_out, options_.threads + 1, [&](int begin, int end) {
      CompletionSource own = source;
      for (int i = begin; i < end; ++i) {
        own.views.occluded_share = i % 2;
        const uint64_t seed = HashBytes(kHeldOutSplits[split], 4, ~options_.seed);
        views[i] = {DrawGroup(own, seed, i).front(), i % 2 == 1};
      }
    });
  }
}

bool CompletionTrainer::Train() {
  start_ = Clock::now();
  SampleStream stream([&](int64_t group) { return DrawGroup(source_, options_.seed, group); },
                      FirstGroup(first_step_), kAhead, options_.threads);
  if (report_.measurements.empty()) Measure(0);
  const double seconds_before = Seconds();
  const double share_before = Share(first_step_);
  int step = first_step_;
  for (; Share(step) < 1; ++step) {
    const double share = Share(step);
    const double per_share = (Seconds() - seconds_before) / std::max(share - share_before, 1e-9);
    const int shown = static_cast<int>(share * options_.steps);
    const bool knows_rate = step >= first_step_ + 20;
    if (!Report("network", shown, options_.steps, knows_rate ? per_share * (1 - share) : -1)) {
      SaveCheckpoint(step);
      return false;
    }
    Step(step, share, stream);
    const int done = step + 1;
    if (done % options_.measure_every == 0) Measure(done);
    if (done % options_.checkpoint_every == 0) SaveCheckpoint(done);
    if (HasConverged()) {
      report_.stopped_early = true;
      ++step;
      break;
    }
  }
  report_.steps = step;
  if (report_.measurements.back().step != step) Measure(step);
  report_.seconds = Seconds();
  return true;
}

void CompletionTrainer::Step(int step, double share, SampleStream& stream) {
  const int64_t first = FirstGroup(step);
  stream.Advance(first, first + options_.window - 1);
  Rng rng = Rng::Derive(options_.seed, static_cast<uint64_t>(step), "completion step");
  struct Choice {
    int64_t group;
    int view, turn;
  };
  std::vector<Choice> choices;
  for (int i = 0; i < options_.batch; ++i) {
    choices.push_back({first + rng.Index(options_.window), rng.Index(options_.views_per_shape),
                       rng.Index(kCubeTurns)});
  }
  std::vector<TurnedSample> samples;
  for (const Choice& c : choices) samples.push_back({&stream.At(c.group)[c.view], c.turn});
  const CompletionBatch batch = BatchOf(samples, options_.threads);
  const double rise = std::min(1.0, (step + 1.0) / std::max(options_.warm_up, 1));
  const double fall = 0.5 * (1 + std::cos(std::numbers::pi * std::min(share, 1.0)));
  const double loss =
      network_.TrainStep(batch, options_.learning_rate * rise * fall, options_.replicas);
  CheckInput(std::isfinite(loss),
             fmt::format("the training diverged at step {}; lower learning_rate {}", step,
                         options_.learning_rate));
  report_.loss_history.push_back(loss);
}

void CompletionTrainer::Measure(int step) {
  CompletionMeasurement measurement;
  measurement.step = step;
  for (int split = 0; split < kHeldOutSplitCount; ++split) {
    measurement.splits[split] = QualityOn(held_out_[split], network_);
  }
  report_.measurements.push_back(measurement);
}

bool CompletionTrainer::HasConverged() const {
  const auto& all = report_.measurements;
  if (options_.patience <= 0 || static_cast<int>(all.size()) <= options_.patience) return false;
  const auto best = std::min_element(all.begin(), all.end(), [](const auto& a, const auto& b) {
    return a.splits[0].loss < b.splits[0].loss;
  });
  return all.end() - best > options_.patience;
}

void CompletionTrainer::SaveCheckpoint(int step) {
  if (job_.checkpoint.empty()) return;
  WriteCompletionCheckpoint(job_.checkpoint, {key_, step, Seconds(), report_.loss_history,
                                              report_.measurements, network_.TrainingState()});
  report_.has_checkpoint = true;
}

bool CompletionTrainer::Report(const char* phase, int done, int total, double seconds_left) {
  if (!job_.on_progress) return true;
  CompletionProgress progress{phase, done, total, 0, -1, seconds_left};
  const auto& losses = report_.loss_history;
  if (!losses.empty()) {
    const size_t count = std::min<size_t>(losses.size(), kShownSteps);
    progress.loss = std::accumulate(losses.end() - count, losses.end(), 0.0) / count;
  }
  if (!report_.measurements.empty()) {
    progress.iou = report_.measurements.back().splits[0].iou_clean;
  }
  return job_.on_progress(progress);
}

void CompletionTrainer::Save() {
  CompletionModelInfo info;
  info.network = options_.network;
  for (const ShapeDomain domain : job_.domains) info.domains.push_back(ShapeDomainName(domain));
  for (const ShapeFamilyRow* family : source_.families) info.families.push_back(family->name);
  info.sensors = job_.sensor_names;
  info.steps = report_.steps;
  info.loss = report_.measurements.back().splits[0].loss;
  info.iou = report_.measurements.back().splits[0].iou_clean;
  CompletionTrainingOptions copy = options_;
  copy.threads = 1;
  info.training = WriteSettings([&](SettingsVisitor& v) { copy.Visit(v); });
  SaveCompletionModel(job_.model_file, info, network_);
}

}  // namespace

void CompletionTrainingOptions::Visit(SettingsVisitor& v) {
  v.Seed("seed", seed, "random seed");
  v.Integer("steps", steps, {1, 1e9}, "number of training steps");
  v.Integer("batch", batch, {2, 4096}, "samples in a step");
  v.Integer("replicas", replicas, {1, 256},
            "parts of a step, each computed by a thread of its own; the model depends on it");
  v.Real("learning_rate", learning_rate, {1e-6, 1}, "learning rate of Adam");
  v.Integer("warm_up", warm_up, {0, 1e6}, "steps in which the learning rate rises");
  v.Real("max_minutes", max_minutes, {0, 1e6},
         "time limit that shortens the schedule, minutes; 0 = none");
  v.Integer("window", window, {1, 1e6}, "groups of samples from which a step draws");
  v.Real("uses", uses, {0.1, 1000}, "mean number of steps that use a sample");
  v.Integer("held_out", held_out, {2, 1e5}, "held-out views of each split");
  v.Integer("measure_every", measure_every, {1, 1e9},
            "steps between measurements on held-out views");
  v.Integer("patience", patience, {0, 1e6},
            "measurements without a better one that end the training; 0 = none");
  v.Integer("checkpoint_every", checkpoint_every, {1, 1e9}, "steps between checkpoints");
  v.Integer("points", points, {16, 1e6}, "queries of a sample");
  v.Integer("views_per_shape", views_per_shape, {1, 1000}, "views of each sampled shape");
  v.Integer("threads", threads, {1, 256}, "threads that make samples");
  v.Text("device", device, {"cpu", "cuda"}, "device on which the network trains");
  v.Group(
      "network", [&](SettingsVisitor& g) { network.Visit(g); }, "settings of the network");
  v.Group(
      "views", [&](SettingsVisitor& g) { views.Visit(g); }, "settings of the views");
}

CompletionReport TrainCompletion(const CompletionJob& job,
                                 const CompletionTrainingOptions& options) {
  CheckSettings("CompletionTrainingOptions", options);
  const auto require_order = [](const char* of, double low, double high) {
    CheckInput(low <= high, fmt::format("views.min_{0} = {1} is above views.max_{0} = {2}; set "
                                        "both in this order",
                                        of, low, high));
  };
  require_order("distance_m", options.views.min_distance_m, options.views.max_distance_m);
  require_order("diameter_px", options.views.min_diameter_px, options.views.max_diameter_px);
  require_order("hidden", options.views.min_hidden, options.views.max_hidden);
  return CompletionTrainer(job, options).Run();
}

void WriteCompletionCheckpoint(const std::filesystem::path& file,
                               const CompletionCheckpoint& checkpoint) {
  BlockWriter writer;
  writer.Put(checkpoint.key);
  writer.Put(&checkpoint.step, sizeof checkpoint.step);
  writer.Put(&checkpoint.seconds, sizeof checkpoint.seconds);
  writer.Put(checkpoint.loss_history);
  writer.Put(checkpoint.measurements);
  writer.Put(checkpoint.training_state);
  WriteFileAtomically(file, writer.Bytes(kCheckpointMagic, kCheckpointVersion));
}

CompletionCheckpoint ReadCompletionCheckpoint(const std::filesystem::path& file,
                                              const std::string& key) {
  const std::string bytes = ReadFileBytes(file);
  CompletionCheckpoint checkpoint;
  try {
    BlockReader reader(bytes, kCheckpointMagic, kCheckpointVersion, "a completion checkpoint");
    checkpoint.key = reader.Take();
    checkpoint.step = OneOf<int>(reader);
    checkpoint.seconds = OneOf<double>(reader);
    checkpoint.loss_history = reader.TakeAll<double>();
    checkpoint.measurements = reader.TakeAll<CompletionMeasurement>();
    checkpoint.training_state = reader.Take();
    reader.RequireEnd();
  } catch (const InputError& error) {
    throw InputError(fmt::format("{}: {}; restore the file from a copy, or train to another file",
                                 file.string(), error.what()));
  }
  CheckInput(checkpoint.key == key,
             fmt::format("{}: belongs to a training with other settings; use the same ones, write "
                         "to another file, or delete it to start again",
                         file.string()));
  return checkpoint;
}

}  // namespace pickbed::perception
