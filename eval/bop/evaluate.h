#pragma once

// Scores of pose estimates on a BOP data set, by the rules that eval/bop/scores.h states. Errors:
// VSD (tolerances 0.05 to 0.5 diameters, thresholds 0.05 to 0.5), MSSD (thresholds 0.05 to 0.5
// diameters) and MSPD (thresholds 5 to 50 px of an image 640 px wide). Symmetries are those of
// models_info.json, errors are taken over all vertices of models_eval (else models).

#include <filesystem>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "eval/bop/results_csv.h"
#include "eval/bop/vsd.h"

namespace pickbed::bop {

struct ObjectScores {
  int wanted = 0;  // instances to be found, BOP19
  double ar_vsd = 0, ar_mssd = 0, ar_mspd = 0;
  bool detectable = false;  // has an instance that counts in BOP24
  double ap_mssd = 0, ap_mspd = 0;
};

struct Scores {
  double ar_vsd = 0, ar_mssd = 0, ar_mspd = 0;  // BOP19, over all instances
  double ap_mssd = 0, ap_mspd = 0;              // BOP24, mean over objects
  double ar() const { return (ar_vsd + ar_mssd + ar_mspd) / 3; }
  double ap() const { return (ap_mssd + ap_mspd) / 2; }
  int wanted = 0;                  // instances to be found, BOP19
  int images = 0;                  // with a target
  int estimates_elsewhere = 0;     // of images that are no target; they do not count
  double seconds_an_image = -1;    // -1 unless every estimate states its time
  std::vector<std::string> notes;  // what had to be made up, such as missing targets
  std::map<int, ObjectScores> objects;
};

// Throws InputError for a broken data set, a split without scenes, targets without truth, and
// estimates of an object that models_info.json does not have.
Scores Evaluate(const std::filesystem::path& root, const std::string& split,
                const std::vector<Estimate>& estimates, const VsdOptions& options = {},
                const std::function<void(const std::string& scene)>& on_scene = {});

}  // namespace pickbed::bop
