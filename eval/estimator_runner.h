#pragma once

// Any estimator by name, the oracle included, in the cell of a scenario.

#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "eval/virtual_cell.h"
#include "perception/pose_estimator.h"

namespace pickbed {

// Views of these parts by the cell's camera and sensor.
std::unique_ptr<LabelledViewSource> CellViews(const VirtualCell& cell, const ObjectSet& objects);

// Leaves out poses whose centre of mass lies beside or under the cell's bin: what one looks for is
// in it, and noise on the rim's edge can look like a part that hangs outside, where no depth
// contradicts it. `object` is an index into cell.objects().
void KeepThoseInBin(const VirtualCell& cell, std::vector<PoseHypothesis>& hypotheses);

class EstimatorRunner {
 public:
  using Progress = std::function<void(std::string_view what, double share)>;

  // Makes the estimator, its code books from the cache where it holds them; `on_progress` is told
  // while they are made. `cell` must outlive this. Throws InputError that begins with the key
  // "estimator" for an unknown name or mode and for a broken model file.
  // Results are the same for any number of threads.
  EstimatorRunner(const VirtualCell& cell, const ScenarioSpec& spec, int threads,
                  const Progress& on_progress);
  ~EstimatorRunner();

  // Poses in the bin, but for the oracle's, for which alone `truth` is. Seconds stand under
  // "estimate" and, by stage, "estimate/STAGE". A trace is filled by estimators whose row explains.
  EstimateResult Estimate(const Scene& truth, const View& view, Rng& rng,
                          EstimateTrace* trace = nullptr);

  double working_distance_m() const;  // camera to parts

 private:
  const VirtualCell& cell_;
  EstimatorSpec spec_;
  std::unique_ptr<LabelledViewSource> views_;
  std::unique_ptr<PoseEstimator> estimator_;  // null: the oracle
};

}  // namespace pickbed
