#include "perception/training/training.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <numbers>
#include <numeric>

#include "perception/networks/model_file.h"
#include "perception/networks/verifier_file.h"
#include "perception/training/checkpoint.h"
#include "perception/training/training_data.h"
#include "perception/training/training_schedule.h"
#include "perception/training/training_views.h"
#include "perception/training/verifier_training.h"
#include "scenes/base/error.h"
#include "scenes/base/random.h"

namespace pickbed::perception {
namespace {

// Interval of checks for a stop request while waiting for views.
constexpr std::chrono::milliseconds kPollInterval{100};

// Runs `work` and prefixes the message of an InputError with the object's name.
template <typename Work>
auto NamingObject(const ObjectModel& object, const Work& work) {
  try {
    return work();
  } catch (const InputError& error) {
    throw InputError("object '" + object.name + "': " + error.what());
  }
}

// Identifies the shared network in the key of a checkpoint.
std::string SharedNetworkText(const VerifierTrainingOptions& options) {
  if (!options.shared_network) return {};
  const std::vector<float> values =
      VerifierValues({Verifier{*options.shared_network, *options.shared_network, {}}});
  return fmt::format("\nshared verifier {:016x}",
                     HashBytes(values.data(), values.size() * sizeof(float)));
}

// Adds the seconds of its lifetime to a phase of the report.
class PhaseTimer {
 public:
  PhaseTimer(TrainingReport& report, const TrainingClock& now, const std::string& name)
      : report_(report), now_(now), name_(name) {}
  ~PhaseTimer() {
    const double seconds = SecondsBetween(start_, now_());
    for (TrainingReport::PhaseSeconds& phase : report_.phases) {
      if (phase.name != name_) continue;
      phase.seconds += seconds;
      return;
    }
    report_.phases.push_back({name_, seconds});
  }
  PhaseTimer(const PhaseTimer&) = delete;
  PhaseTimer& operator=(const PhaseTimer&) = delete;

 private:
  TrainingReport& report_;
  const TrainingClock& now_;
  std::string name_;
  TrainingTime start_ = now_();
};

// One training, from views to model file.
class Trainer {
 public:
  Trainer(const TrainingJob& job, const TrainingOptions& options);
  TrainingReport Run();

 private:
  bool Report(const char* phase, double share, int total, double shown_from = 0);
  void BeginPhase() { phase_start_ = job_.now(); }
  double SecondsSince(TrainingTime start) const { return SecondsBetween(start, job_.now()); }
  TrainingViewsPlan Plan() const;
  std::vector<ObjectId> NewObjects() const;
  bool AwaitHeldOut();
  bool AwaitScenes(double share, const char* phase, double shown_from);
  bool TrainNetwork();
  void Step(double share);
  void Measure();
  double Share() const;
  double NetworkLimit_s() const;
  std::vector<VerifierDeadlines> Deadlines() const;
  void SaveCheckpoint();
  void NoteCheckpoint();
  bool TrainVerifiers();
  std::vector<TrainedVerifier> AllVerifiers() const;
  double RecentLoss() const;
  void Save();
  void FillPictures();
  DescribePatches Describe() const {
    return [this](std::span<const int8_t> patches) { return network_.Describe(patches); };
  }

  const TrainingJob& job_;
  const TrainingOptions& options_;
  const VerifierTrainingOptions verifier_options_;
  const ObjectSet& objects_;
  TrainingStart from_;
  std::vector<double> sides_;
  TrainingSchedule schedule_;
  std::string key_;
  DescriptorNetwork network_;
  TrainingData data_;
  HeldOutSet held_out_;
  std::vector<TrainedVerifier> trained_;  // finished verifiers, in the order of NewObjects()
  std::unique_ptr<TrainingViews> views_;
  int iteration_ = 0;  // steps done
  TrainingReport report_;
  TrainingTime start_, phase_start_;
};

Trainer::Trainer(const TrainingJob& job, const TrainingOptions& options)
    : job_(job),
      options_(options),
      verifier_options_(VerifierOptionsOf(options)),
      objects_(job.views.objects()),
      from_(LoadTrainingStart(job, options)),
      sides_(StartSides(objects_, from_, options)),
      schedule_(ObjectWeights(from_, options), options),
      key_(CheckpointKey(job.views, options, job.sensor_profile,
                         from_.model ? from_.model->network_hash : 0) +
           SharedNetworkText(verifier_options_)),
      network_(options.network, options.seed, static_cast<int>(objects_.size())),
      data_(objects_, schedule_.main_objects(), sides_, network_.regresses(), options),
      start_(job.began.value_or(job.now())),
      phase_start_(start_) {
  for (size_t object = 0; object < objects_.size(); ++object) {
    report_.rehearsed.push_back(from_.IsRehearsed(object));
  }
}

// shown_from: the share at which this session started; it is needed for the remaining time.
bool Trainer::Report(const char* phase, double share, int total, double shown_from) {
  if (!job_.on_progress) return true;
  TrainingProgress progress;
  progress.phase = phase;
  progress.done = static_cast<int>(std::lround(std::min(share, 1.0) * total));
  progress.total = total;
  progress.loss = RecentLoss();
  if (!report_.recall_history.empty()) {
    progress.recall_at_1 = report_.recall_history.back().at_1;
    progress.recall_at_8 = report_.recall_history.back().at_8;
  }
  if (share > shown_from) {
    progress.seconds_left = SecondsSince(phase_start_) * (1 - share) / (share - shown_from);
  }
  return job_.on_progress(progress);
}

double Trainer::RecentLoss() const {
  const std::vector<double>& losses = report_.loss_history;
  const size_t count = std::min<size_t>(100, losses.size());
  return count == 0 ? 0 : std::accumulate(losses.end() - count, losses.end(), 0.0) / count;
}

// Objects that are not rehearsed; each gets a verifier.
std::vector<ObjectId> Trainer::NewObjects() const {
  std::vector<ObjectId> new_objects;
  for (size_t object = 0; object < objects_.size(); ++object) {
    if (!from_.IsRehearsed(object)) new_objects.push_back(ObjectId(object));
  }
  return new_objects;
}

TrainingViewsPlan Trainer::Plan() const {
  TrainingViewsPlan plan;
  plan.seed = options_.seed;
  for (const double side_m : sides_) plan.forms.push_back({side_m, network_.channels()});
  if (Share() < 1 && !options_.verifiers_only) plan.scene_objects = schedule_.scene_objects();
  plan.verifiers = NewObjects();
  plan.verifiers.erase(plan.verifiers.begin(), plan.verifiers.begin() + trained_.size());
  plan.views_per_scene = options_.views_per_scene;
  plan.positive_pairs = options_.positive_pairs;
  plan.held_out = options_.held_out;
  plan.verifier = verifier_options_;
  plan.deadlines = Deadlines();
  return plan;
}

bool Trainer::AwaitHeldOut() {
  const PhaseTimer timer(report_, job_.now, "waiting for views");
  while (true) {
    if (!Report("views", 0, schedule_.FirstScenes())) return false;
    if (std::optional<HeldOutSet> set = views_->TakeHeldOut(kPollInterval)) {
      held_out_ = std::move(*set);
      return true;
    }
  }
}

// Waits for the clutter scenes that the schedule requires. With a time limit it does not wait if
// there is at least one, because the result depends on the time anyway.
bool Trainer::AwaitScenes(double share, const char* phase, double shown_from) {
  const int wanted = schedule_.WantedScenes(share);
  if (data_.clutter_scenes() >= wanted) return true;
  const PhaseTimer timer(report_, job_.now, "waiting for views");
  const bool limited = options_.max_minutes > 0;
  while (data_.clutter_scenes() < wanted) {
    const bool enough = limited && data_.clutter_scenes() > 0;
    const std::optional<ClutterPairs> clutter_scene =
        views_->TakeScene(enough ? std::chrono::milliseconds(0) : kPollInterval);
    if (clutter_scene) data_.Add(*clutter_scene);
    if (!clutter_scene && enough) return true;
    const bool first = iteration_ == 0;
    const double shown = first ? std::min(1.0, 1.0 * data_.clutter_scenes() / wanted) : share;
    const int total = first ? wanted : schedule_.iterations();
    if (!Report(first ? "views" : phase, shown, total, first ? 0 : shown_from)) return false;
  }
  if (data_.clutter_scenes() == schedule_.clutter_scenes()) data_.RequireAllObjects();
  return true;
}

double Trainer::Share() const {
  const double by_count = schedule_.Share(iteration_);
  const double limit_s = NetworkLimit_s();
  return limit_s > 0 ? std::max(by_count, SecondsSince(start_) / limit_s) : by_count;
}

// Returns the time limit of the network, from the start; 0 = none.
double Trainer::NetworkLimit_s() const {
  constexpr double kNetworkShare = 0.4;
  const double limit_s = 60 * options_.max_minutes;
  return NewObjects().empty() ? limit_s : kNetworkShare * limit_s;
}

// Returns the deadlines of the verifiers that are not yet trained. Views of one object are rendered
// while the verifier of the one before is trained. A network that ends early leaves them more time,
// which they use up to the planned number of scenes.
std::vector<VerifierDeadlines> Trainer::Deadlines() const {
  constexpr double kUsedShare = 0.97;  // the rest is for the report and the files
  constexpr double kViewsShare = 0.5;  // of an object's time, the rest is for its candidates
  std::vector<VerifierDeadlines> deadlines;
  if (options_.max_minutes <= 0) return deadlines;
  const double begin_s = options_.verifiers_only ? SecondsSince(start_) : NetworkLimit_s();
  const double end_s = kUsedShare * 60 * options_.max_minutes;
  const size_t count = NewObjects().size() - trained_.size();
  const auto at = [&](double objects) {
    return Later(start_, begin_s + (end_s - begin_s) * objects / static_cast<double>(count));
  };
  for (size_t i = 0; i < count; ++i) {
    const double done = static_cast<double>(i);
    deadlines.push_back({at(done + kViewsShare), at(done + 1), job_.now});
  }
  return deadlines;
}

void Trainer::SaveCheckpoint() {
  if (job_.checkpoint.empty()) return;
  WriteCheckpoint(job_.checkpoint, {key_, iteration_, report_.loss_history, report_.recall_history,
                                    network_.TrainingState(), trained_});
  NoteCheckpoint();
}

void Trainer::NoteCheckpoint() {
  report_.has_checkpoint = true;
  report_.kept_steps = iteration_;
  report_.kept_verifiers = static_cast<int>(trained_.size());
  report_.new_objects = static_cast<int>(NewObjects().size());
}

void Trainer::Step(double share) {
  const double rate = 0.5 * options_.learning_rate * (1 + std::cos(std::numbers::pi * share));
  const double loss = network_.TrainStep(data_.Batch(iteration_), options_.loss, rate);
  CheckInput(std::isfinite(loss), fmt::format("training diverged at step {}; lower "
                                              "learning_rate ({})",
                                              iteration_, options_.learning_rate));
  report_.loss_history.push_back(loss);
  ++iteration_;
}

void Trainer::Measure() {
  const PhaseTimer timer(report_, job_.now, "held-out recall");
  HeldOutRecall recall = MeasureRecall(held_out_, objects_, Describe(), network_.length());
  recall.iteration = iteration_;
  report_.recall_history.push_back(std::move(recall));
  schedule_.Watch(report_.recall_history);
}

bool Trainer::TrainNetwork() {
  if (report_.recall_history.empty()) Measure();
  if (options_.verifiers_only) return true;
  BeginPhase();
  const double first_share = Share();
  for (double share = first_share; share < 1; share = Share()) {
    if (!AwaitScenes(share, "network", first_share)) {
      SaveCheckpoint();
      return false;
    }
    if (iteration_ == 0) BeginPhase();
    {
      const PhaseTimer timer(report_, job_.now, "network");
      Step(share);
    }
    if (iteration_ % schedule_.measure_every() == 0) Measure();
    if (iteration_ % options_.checkpoint_every == 0) SaveCheckpoint();
    if (!Report("network", Share(), schedule_.iterations(), first_share)) {
      SaveCheckpoint();
      return false;
    }
  }
  views_->SkipScenes();
  if (report_.recall_history.back().iteration != iteration_) Measure();
  SaveCheckpoint();
  if (data_.clutter_scenes() > 0) data_.RequireAllObjects();
  return true;
}

// Trains one verifier per new object. Returns false if stopped on request.
bool Trainer::TrainVerifiers() {
  BeginPhase();
  const std::vector<ObjectId> new_objects = NewObjects();
  const int clutter_scenes = (options_.verifier_clutter_scenes + options_.verifier_room_scenes) *
                             static_cast<int>(new_objects.size());
  const auto share_of = [&](size_t done, double share) {
    return (static_cast<double>(done) + share) / static_cast<double>(new_objects.size());
  };
  const size_t first = trained_.size();
  const std::vector<VerifierDeadlines> deadlines = Deadlines();
  for (size_t n = first; n < new_objects.size(); ++n) {
    std::optional<VerifierTrainingSet> training_set;
    while (!training_set) {
      const PhaseTimer timer(report_, job_.now, "waiting for verifier views");
      if (!Report("verifier", share_of(n, 0), clutter_scenes)) return false;
      training_set = NamingObject(*objects_[new_objects[n]],
                                  [&] { return views_->TakeTrainingSet(kPollInterval); });
    }
    const PhaseTimer timer(report_, job_.now, "verifier");
    const ObjectId i = new_objects[n];
    const VerifierObject object{i, sides_[i], network_.length(), VoterOf(network_)};
    VerifierTrainingOptions plan = verifier_options_;
    if (!deadlines.empty()) plan.deadlines = deadlines[n - first];
    std::optional<TrainedVerifier> start;
    if (options_.verifier_clutter_scenes == 0 && from_.model) {
      const int known = from_.known[i];
      start = {from_.model->verifiers[known], from_.model->info.objects[known].verifier_auc};
    }
    bool go_on = true;
    const TrainedVerifier trained = NamingObject(*objects_[i], [&] {
      return TrainObjectVerifier(
          *training_set, objects_[i], object, plan,
          [&](double share) {
            return go_on = Report("verifier", share_of(n, share), clutter_scenes);
          },
          start ? &*start : nullptr);
    });
    if (!go_on) return false;
    trained_.push_back(trained);
    SaveCheckpoint();
  }
  Report("verifier", 1, clutter_scenes);
  return true;
}

// By object; rehearsed objects keep the verifier of the initial model.
std::vector<TrainedVerifier> Trainer::AllVerifiers() const {
  std::vector<TrainedVerifier> all;
  size_t next = 0;
  for (size_t i = 0; i < objects_.size(); ++i) {
    if (from_.IsRehearsed(i)) {
      const int known = from_.known[i];
      all.push_back({from_.model->verifiers[known], from_.model->info.objects[known].verifier_auc});
    } else {
      all.push_back(trained_[next++]);
    }
  }
  return all;
}

void Trainer::Save() {
  ModelInfo info;
  std::vector<Verifier> verifiers;
  const std::vector<TrainedVerifier> trained = AllVerifiers();
  const HeldOutRecall& recall = report_.recall_history.back();
  for (size_t i = 0; i < objects_.size(); ++i) {
    ModelObject object{objects_[i]->name, objects_[i]->mesh_hash, objects_[i]->diameter_m,
                       sides_[i], trained[i].auc};
    object.recall_at_1 = recall.object_at_1[i];
    object.recall_at_8 = recall.object_at_8[i];
    info.objects.push_back(object);
    verifiers.push_back(trained[i].verifier);
    report_.object_auc.push_back(trained[i].auc);
    report_.verifier_auc += trained[i].auc / static_cast<double>(objects_.size());
  }
  info.sensor = job_.sensor_profile;
  info.network = options_.network;
  TrainingOptions options = options_;
  info.training = WriteSettings([&](SettingsVisitor& v) { options.Visit(v); });
  info.iterations = options_.verifiers_only ? from_.model->info.iterations : iteration_;
  info.loss = options_.verifiers_only ? from_.model->info.loss : RecentLoss();
  info.recall_at_1 = recall.at_1;
  info.recall_at_8 = recall.at_8;
  SaveModel(job_.model_file, info, network_, verifiers);
}

void Trainer::FillPictures() {
  report_.answers =
      AnswersOf(held_out_, objects_, Describe(), network_.length(), options_.held_out.queries);
  report_.held_out = std::move(held_out_);
  report_.channels = network_.channels();
  constexpr size_t kPairs = 12;  // per object
  for (const PatchPairs& all : data_.pairs()) {
    PatchPairs& some = report_.pairs.emplace_back();
    const size_t count = std::min(kPairs, all.size());
    for (size_t i = 0; i < count; ++i) {
      const size_t row = i * all.size() / count;
      AppendPatch(all.anchors, row, some.anchors);
      AppendPatch(all.codes, row, some.codes);
    }
  }
}

TrainingReport Trainer::Run() {
  // The checkpoint is read first, so that an unusable one is reported before views are rendered.
  if (job_.resume) {
    const Checkpoint checkpoint = ReadCheckpoint(job_.checkpoint, key_);
    iteration_ = checkpoint.iteration;
    report_.loss_history = checkpoint.loss_history;
    report_.recall_history = checkpoint.recall_history;
    schedule_.Watch(report_.recall_history);
    network_.RestoreTrainingState(checkpoint.training_state);
    trained_ = checkpoint.verifiers;
    NoteCheckpoint();
  } else if (from_.model) {
    network_.SetWeights(from_.model->network.Weights());
  }
  views_ = std::make_unique<TrainingViews>(job_.views, Plan());
  report_.finished = AwaitHeldOut() && TrainNetwork() && TrainVerifiers();
  views_.reset();
  report_.plateau_iteration = schedule_.plateau_iteration();
  if (report_.finished) {
    Save();
    FillPictures();
  }
  report_.seconds = SecondsSince(start_);
  return std::move(report_);
}

}  // namespace

TrainingReport TrainDescriptor(const TrainingJob& job, const TrainingOptions& options) {
  CheckSettings("TrainingOptions", options);
  CheckInput(options.verifier_clutter_scenes > 0 || options.verifiers_only,
             "verifier_clutter_scenes is 0, which keeps known verifiers; set verifiers_only=true");
  CheckInput(!options.verifiers_only || !job.start_from.empty(),
             "verifiers_only needs a model whose network is kept; name one to start from");
  CheckInput(!job.views.objects().empty(), "training needs at least one object");
  CheckInput(!job.resume || !job.checkpoint.empty(), "resuming needs a checkpoint file");
  return Trainer(job, options).Run();
}

}  // namespace pickbed::perception
