#pragma once

// Schedule of a training: numbers of steps and clutter scenes, main object of each step, clutter
// scenes in use, and position on the cosine of the learning rate. It depends only on the settings
// and on the measured recall, not on time.

#include <optional>
#include <vector>

#include "perception/networks/model_file.h"
#include "perception/training/training.h"
#include "scenes/base/ids.h"

namespace pickbed::perception {

// Returns a sequence of `count` object indices, each as frequent as its weight and evenly spread.
// Equal weights give 0, 1, 2, ..., 0, 1, ... Throws std::logic_error unless all weights are above
// 0.
std::vector<ObjectId> TakeTurns(const std::vector<double>& weights, int count);

// Schedule with shortening at a plateau.
class TrainingSchedule {
 public:
  // `weights` scales the scenes and steps of each object; 1 = as in the options.
  TrainingSchedule(const std::vector<double>& weights, const TrainingOptions& options);

  int iterations() const { return iterations_; }
  int clutter_scenes() const { return static_cast<int>(scene_objects_.size()); }
  // Main object per step.
  const std::vector<ObjectId>& main_objects() const { return main_objects_; }
  // Required object per scene.
  const std::vector<ObjectId>& scene_objects() const { return scene_objects_; }
  int measure_every() const { return measure_every_; }  // steps

  // Checks the recall for a plateau.
  void Watch(const std::vector<HeldOutRecall>& history);
  int plateau_iteration() const { return plateau_iteration_; }  // -1 = none

  // Returns the completed share of the schedule after `iteration` steps; 1 or more = done. After a
  // plateau the rest is completed in few steps. It is not skipped, because weights trained without
  // the decay of the learning rate are worse.
  double Share(int iteration) const;

  // Returns the number of clutter scenes in use at that share. All are in use early enough that
  // the network trains on each. After a plateau the number does not increase.
  int WantedScenes(double share) const;
  int FirstScenes() const;

 private:
  HeldOutOptions held_out_;
  double views_share_ = 1;
  int iterations_ = 0;
  int measure_every_ = 1;
  int plateau_iteration_ = -1;
  std::vector<ObjectId> main_objects_;
  std::vector<ObjectId> scene_objects_;
};

// Start of a training: new weights, or a model that may know some of the objects.
struct TrainingStart {
  std::optional<DescriptorModel> model;
  std::vector<int> known;  // by object: index into the model's objects, -1 = new object
  bool rehearses = false;  // some objects are known and some are new

  bool IsRehearsed(size_t object) const { return rehearses && known[object] >= 0; }
};

// Loads job.start_from. An object whose mesh has changed is new. Throws InputError as LoadModel
// does, and if kind, descriptor length or channels of the network differ from the options. Also
// throws if a network that regresses poses has another number of objects.
TrainingStart LoadTrainingStart(const TrainingJob& job, const TrainingOptions& options);

// Returns the weight of each object: 1, or options.rehearsal if it is rehearsed.
std::vector<double> ObjectWeights(const TrainingStart& start, const TrainingOptions& options);

// Returns the patch side of each object in metres; known objects keep theirs.
std::vector<double> StartSides(const ObjectSet& objects, const TrainingStart& start,
                               const TrainingOptions& options);

// Returns the key of a checkpoint: settings, views and objects. It excludes max_minutes and
// checkpoint_every, which may change between two sessions. `start_hash` is the hash of the initial
// weights; 0 = new weights.
std::string CheckpointKey(const LabelledViewSource& views, TrainingOptions options,
                          const std::string& sensor, uint64_t start_hash);

}  // namespace pickbed::perception
