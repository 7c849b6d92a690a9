#include "perception/training/training_schedule.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <stdexcept>

#include "perception/features/patch.h"
#include "scenes/base/error.h"

namespace pickbed::perception {
namespace {

// Share of the clutter scenes for which the first step waits.
constexpr double kFirstShare = 0.08;

int Rounded(double value) { return static_cast<int>(std::lround(value)); }

}  // namespace

// Smooth weighted round-robin: in each turn all credits grow by their weight, and the object with
// the highest credit is chosen. Its credit then decreases by the sum of the weights.
std::vector<ObjectId> TakeTurns(const std::vector<double>& weights, int count) {
  const double total = std::accumulate(weights.begin(), weights.end(), 0.0);
  if (weights.empty() || *std::min_element(weights.begin(), weights.end()) <= 0) {
    throw std::logic_error("alternation needs weights above 0");
  }
  // Rounding errors must not decide which credit is the highest.
  constexpr double kTie = 1e-9;
  std::vector<double> credit(weights.size(), 0);
  std::vector<ObjectId> turns(count, ObjectId(0));
  for (ObjectId& turn : turns) {
    for (size_t i = 0; i < weights.size(); ++i) credit[i] += weights[i];
    turn = ObjectId(0);
    for (size_t i = 1; i < weights.size(); ++i) {
      if (credit[i] > credit[turn] + kTie * total) turn = ObjectId(i);
    }
    credit[turn] -= total;
  }
  return turns;
}

TrainingSchedule::TrainingSchedule(const std::vector<double>& weights,
                                   const TrainingOptions& options)
    : held_out_(options.held_out), views_share_(options.views_share) {
  const double total = std::accumulate(weights.begin(), weights.end(), 0.0);
  iterations_ = Rounded(options.iterations * total);
  measure_every_ = std::max(1, Rounded(options.held_out.every * total));
  main_objects_ = TakeTurns(weights, iterations_);
  // Each object is in at least one clutter scene, even if its weight is low.
  std::vector<double> clutter_scenes;
  for (const double weight : weights)
    clutter_scenes.push_back(std::max(1, Rounded(options.clutter_scenes * weight)));
  scene_objects_ = TakeTurns(
      clutter_scenes, Rounded(std::accumulate(clutter_scenes.begin(), clutter_scenes.end(), 0.0)));
}

void TrainingSchedule::Watch(const std::vector<HeldOutRecall>& history) {
  const int index = PlateauOf(history, held_out_);
  plateau_iteration_ = index < 0 ? -1 : history[index].iteration;
}

double TrainingSchedule::Share(int iteration) const {
  if (iterations_ == 0) return 1;
  const double share = static_cast<double>(iteration) / iterations_;
  if (plateau_iteration_ < 0 || iteration <= plateau_iteration_) return share;
  const double flat = static_cast<double>(plateau_iteration_) / iterations_;
  const int cooling = std::max(1, Rounded(held_out_.cooling * iterations_));
  const int left = std::min(cooling, iterations_ - plateau_iteration_);
  if (left <= 0) return share;
  return flat + (1 - flat) * (iteration - plateau_iteration_) / left;
}

int TrainingSchedule::FirstScenes() const {
  return std::max(1, static_cast<int>(std::ceil(kFirstShare * clutter_scenes())));
}

int TrainingSchedule::WantedScenes(double share) const {
  if (plateau_iteration_ >= 0) {
    share = std::min(share, static_cast<double>(plateau_iteration_) / iterations_);
  }
  const int wanted = static_cast<int>(std::ceil(clutter_scenes() * share / views_share_));
  return std::clamp(wanted, FirstScenes(), clutter_scenes());
}

TrainingStart LoadTrainingStart(const TrainingJob& job, const TrainingOptions& options) {
  const ObjectSet& objects = job.views.objects();
  TrainingStart start;
  start.known.assign(objects.size(), -1);
  if (job.start_from.empty()) return start;
  start.model = LoadModel(job.start_from);
  const ModelInfo& info = start.model->info;
  CheckInput(info.network.kind == options.network.kind &&
                 info.network.descriptor == options.network.descriptor,
             fmt::format("{}: its network is {} with descriptors of length {}, not {} with {}; set "
                         "network.kind and network.descriptor to its values",
                         job.start_from.string(), info.network.kind, info.network.descriptor,
                         options.network.kind, options.network.descriptor));
  CheckInput(start.model->network.channels() == ChannelsOf(options.network),
             fmt::format("{}: its network was trained on {}, not on {}; set "
                         "network.autoencoder.channels to its value",
                         job.start_from.string(), NameOf(start.model->network.channels()),
                         NameOf(ChannelsOf(options.network))));
  // The last layer of a regressing network has one block per object, in the order of training.
  const bool grows = start.model->network.regresses() && info.objects.size() != objects.size();
  CheckInput(!grows, fmt::format("{}: a network that regresses poses cannot learn further objects; "
                                 "train a new model on all objects at once",
                                 job.start_from.string()));
  for (size_t object = 0; object < objects.size(); ++object) {
    for (size_t i = 0; i < info.objects.size(); ++i) {
      if (info.objects[i].name != objects[object]->name) continue;
      if (info.objects[i].mesh_hash == objects[object]->mesh_hash) start.known[object] = i;
    }
  }
  const auto is_known = [](int index) { return index >= 0; };
  if (options.verifiers_only) {
    CheckInput(std::all_of(start.known.begin(), start.known.end(), is_known),
               fmt::format("{}: does not know all objects; verifiers_only trains no network",
                           job.start_from.string()));
    return start;
  }
  start.rehearses = std::any_of(start.known.begin(), start.known.end(), is_known) &&
                    !std::all_of(start.known.begin(), start.known.end(), is_known);
  return start;
}

std::vector<double> ObjectWeights(const TrainingStart& start, const TrainingOptions& options) {
  std::vector<double> weights(start.known.size(), 1);
  for (size_t object = 0; object < weights.size(); ++object) {
    if (start.IsRehearsed(object)) weights[object] = options.rehearsal;
  }
  return weights;
}

std::vector<double> StartSides(const ObjectSet& objects, const TrainingStart& start,
                               const TrainingOptions& options) {
  std::vector<double> sides;
  for (size_t object = 0; object < objects.size(); ++object) {
    sides.push_back(start.known[object] >= 0
                        ? start.model->info.objects[start.known[object]].side_m
                        : PatchSide(objects[object]->diameter_m, options.patch_diameters));
  }
  return sides;
}

std::string CheckpointKey(const LabelledViewSource& views, TrainingOptions options,
                          const std::string& sensor, uint64_t start_hash) {
  options.max_minutes = 0;
  options.checkpoint_every = TrainingOptions{}.checkpoint_every;
  std::string key = WriteSettingsKey([&](SettingsVisitor& v) { options.Visit(v); });
  key += fmt::format("sensor {}\nfrom {:016x}", sensor, start_hash);
  key += fmt::format("\n{}", views.ClutterSceneSettings());
  for (const auto& object : views.objects()) {
    key += fmt::format("\n{} {:016x}", object->name, object->mesh_hash);
  }
  return key;
}

}  // namespace pickbed::perception
