#pragma once

// What `pickbed train` learns: parts of the catalog, of a scenario or of a BOP data set, and the
// cell, camera and sensor that they are seen in.

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "eval/command_line.h"
#include "scenes/labelled_view.h"
#include "sim/sensor_profile.h"

namespace pickbed {

// As asked for on the command line.
struct LessonChoice {
  std::vector<std::string> objects;  // of the catalog
  std::string bop_path;              // a BOP data set: all of its models, for its camera
  ScenarioArguments scenario;        // optional: camera, bin, sensor, looks and parts
  std::vector<std::string> sensors;  // of the piles; empty = the scenario's
  double foreign_share = 0.3;        // of the piles, in which shapes lie that are no parts
  std::string start_from;            // model whose parts are learned on with the others
};

// What is learned, and the cell that it is learned for.
struct TrainingLesson {
  std::string name;
  ScenarioSpec spec;
  bool has_cell = false;               // of a scenario; else cells of a size that suits each part
  std::vector<SensorProfile> sensors;  // of the piles; empty = the scenario's
  double foreign_share = 0;            // of the piles, in which shapes lie that are no parts
  ObjectSet objects;
  std::optional<CameraIntrinsics> camera;  // of a data set, instead of the scenario's
};

// Throws InputError when nothing is named, for an unknown part, for one that `start_from` knows by
// another mesh or that is in no catalog, and for one too small to be seen in the scenario's camera.
TrainingLesson PlanTrainingLesson(const LessonChoice& choice);

// Views of the lesson's parts, rendered on the fly.
std::unique_ptr<LabelledViewSource> MakeTrainingViews(const TrainingLesson& lesson);

// As recorded in the model.
std::string SensorNames(const TrainingLesson& lesson);

}  // namespace pickbed
