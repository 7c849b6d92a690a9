#pragma once

// Training job of `pickbed train`: the objects (from the catalog, a scenario or a BOP data set) and
// the cell, camera and sensor.

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "eval/layer.h"
#include "scenes/labelled_view.h"
#include "scenes/scenario/find_scenario.h"
#include "sim/sensor/sensor_profile.h"

namespace pickbed::eval {

// Selection on the command line.
struct TrainingSetChoice {
  std::vector<std::string> objects;  // names in the catalog
  std::string bop_path;              // a BOP data set: all of its models, with its camera
  ScenarioRequest scenario;          // optional: camera, bin, sensor, appearance and objects
  std::vector<std::string> sensors;  // for clutter scenes; empty = sensor of the scenario
  double distractor_share = 0.3;     // share of clutter scenes with distractors
  double deep_share = 0.4;           // share of clutter scenes that are deep piles
  std::string start_from;            // model file; its objects are trained again with the others
};

// The training job: objects, and the cell that they are trained for.
struct TrainingSet {
  std::string name;
  ScenarioSpec spec;
  bool has_cell = false;  // true: cell of a scenario; else the cell size fits each object
  std::vector<SensorProfile> sensors;  // for clutter scenes; empty = sensor of the scenario
  double distractor_share = 0;         // share of clutter scenes with distractors
  double deep_share = 0;               // share of clutter scenes that are deep piles
  ObjectSet objects;
  std::optional<CameraIntrinsics> camera;  // of a BOP data set; replaces the camera of the scenario
};

// Plans the training. Throws InputError if no object is named, for an unknown object, and for one
// that is too small in the scenario camera. Also throws it if an object of `start_from` is in no
// catalog or has another mesh there.
TrainingSet PlanTrainingSet(const TrainingSetChoice& choice);

// Returns a source that renders training views of the objects on demand.
std::unique_ptr<LabelledViewSource> MakeTrainingViews(const TrainingSet& training_set);

// Returns the names of the sensors, as recorded in the model file.
std::string SensorNames(const TrainingSet& training_set);

}  // namespace pickbed::eval
