#pragma once

// Runs the estimator that a scenario names in the simulated cell. Estimates have the object indices
// of the cell and are inside its bin. The name may also be the oracle.

#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "eval/trial/simulated_cell.h"
#include "perception/estimators/pose_estimator.h"

namespace pickbed::eval {

// Returns a source of labelled training images of `objects`, with the cell's camera, sensor and
// bin.
std::unique_ptr<LabelledViewSource> CellViews(const SimulatedCell& cell, const ObjectSet& objects);

// Removes hypotheses whose center of mass is beside or below the cell's bin. Noise at the edge of
// the rim can look like an instance that hangs outside, where no depth contradicts it.
// PoseHypothesis::object is an index into cell.objects().
void KeepThoseInBin(const SimulatedCell& cell, std::vector<PoseHypothesis>& hypotheses);

// Holds the estimator of a scenario, or none if the scenario names the oracle.
class EstimatorRunner {
 public:
  using Progress = std::function<void(std::string_view what, double share)>;

  // Makes the estimator. Codebooks come from the cache if it holds them, else they are made and
  // `on_progress` is called. `cell` must outlive this object. Results do not depend on `threads`.
  // Throws InputError that begins with the key "estimator" for an unknown name or mode and for a
  // broken model file.
  EstimatorRunner(const SimulatedCell& cell, const ScenarioSpec& spec, int threads,
                  const Progress& on_progress);
  ~EstimatorRunner();

  // Returns the poses inside the bin, in the camera frame. Times are under "estimate" and, for each
  // stage, "estimate/STAGE". Only estimators that support traces fill `trace`. Throws
  // std::logic_error for the oracle, which does not estimate.
  EstimateResult Estimate(const RgbdFrame& frame, Rng& rng, EstimateTrace* trace = nullptr);

  bool is_oracle() const { return estimator_ == nullptr; }
  const SimulatedCell& cell() const { return cell_; }
  const EstimatorSpec& spec() const { return spec_; }
  double working_distance_m()
      const;  // depth along camera z, a quarter of the bin height above the floor

 private:
  const SimulatedCell& cell_;
  EstimatorSpec spec_;
  std::unique_ptr<LabelledViewSource> views_;
  std::unique_ptr<PoseEstimator> estimator_;  // null: the oracle
};

}  // namespace pickbed::eval
