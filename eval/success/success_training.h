#pragma once

// Trains the network that rates grasps of unknown objects (grasp/completed/success_network.h).

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "eval/stats/forecast_quality.h"
#include "eval/stats/statistics.h"
#include "eval/success/grasp_examples.h"
#include "perception/training/perceptron_fit.h"
#include "scenes/base/settings.h"

namespace pickbed::eval {

struct SuccessTrainingOptions {
  uint64_t seed = 0;
  int first_group = 0;
  int groups = 60;  // of bins, half of them deep
  int folds = 4;    // each part is predicted by a network that was trained on the others
  ExampleOptions examples;
  PerceptronOptions perceptron;
  void Visit(SettingsVisitor& v);
};

struct SuccessTrainingJob {
  std::filesystem::path data_folder;  // a file of examples for each group
  std::filesystem::path model_file;   // written at the end, atomically
  int jobs = 1;                       // processes that make examples
  std::function<void(int done, int total, int done_before)> on_group;
  std::function<bool()> stop;
};

// Quality of predictions of held-out grasps of one kind of bins. Groups are the independent units
// of the intervals.
struct SuccessQuality {
  GroupKind kind = GroupKind::kShallow;
  int grasps = 0;
  double base_rate = 0;  // share of all grasps that succeeded
  double auc = 0.5;      // area under the ROC curve
  Interval auc_ci95 = Interval::Unknown();
  ClusterValue calibration_error;  // expected calibration error
  int images = 0;
  double best = 0;  // share of the images in which the grasp with the best chance succeeded
  double any = 0;   // share of the images in which at least one executed grasp succeeded
};

struct SuccessTrainingReport {
  bool finished = false;  // false: stopped on request; what was made is kept
  std::vector<SuccessQuality> quality;
  int grasps = 0;
};

// Makes the missing examples of the groups from first_group on. Then predicts each part of all
// groups in the folder from the others, and trains the network on all of them. The result does not
// depend on the number of jobs. Forks, see RunInWorkers(). Throws InputError for examples of other
// settings, and if no group gives grasps of both outcomes.
SuccessTrainingReport TrainSuccessNetwork(const SuccessTrainingJob& job,
                                          const SuccessTrainingOptions& options);

}  // namespace pickbed::eval
