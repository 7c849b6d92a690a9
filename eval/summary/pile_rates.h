#pragma once

// Pick success by the state of the pile: its fill level and the layer of the picked instance.

#include <string>
#include <vector>

#include "eval/stats/statistics.h"
#include "eval/trial/trial.h"

namespace pickbed::eval {

// Success of the executed grasps at one band of fill levels [fill_min, fill_max).
struct FillBand {
  double fill_min = 0, fill_max = 0;
  ReportRate success;
  std::string name() const;  // in percent, such as "20-30"; "100-" for a heap above the rim
};

// Returns the success in bands of 10 % of the bin's height, the emptiest first, without bands that
// no executed grasp is in.
std::vector<FillBand> SuccessByFillLevel(const std::vector<TrialResult>& trials);

// Success of the executed grasps on instances of one layer.
struct LayerRate {
  int layer = 1;         // 1 = top
  bool is_last = false;  // counts the layers below, too
  ReportRate success;
  std::string name() const;  // such as "2"; "5-" for the fifth and all below
};

// Returns the success for each of the upper four layers, and for all below together, without those
// that no executed grasp is in. Grasps that match no instance have no layer and do not count.
std::vector<LayerRate> SuccessByLayers(const std::vector<TrialResult>& trials);

}  // namespace pickbed::eval
