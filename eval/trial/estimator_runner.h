#pragma once

// Runs the estimator that a scenario names in the simulated cell. Estimates have the object indices
// of the cell and are inside its bin.

#include <filesystem>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "eval/cell/simulated_cell.h"
#include "perception/estimators/pose_estimator.h"

namespace pickbed::eval {

// Returns a source of labelled training images of `objects`, with the cell's camera, sensor and
// bin.
std::unique_ptr<LabelledViewSource> CellViews(const SimulatedCell& cell, const ObjectSet& objects);

// Removes hypotheses whose center of mass is beside or below the cell's bin, where the calibration
// assumes it. Noise at the edge of the rim can look like an instance that hangs outside, where no
// depth contradicts it. PoseHypothesis::object is an index into cell.objects().
void RemoveOutsideBin(const SimulatedCell& cell, const CellCalibration& calibration,
                      std::vector<PoseHypothesis>& hypotheses);

// Returns the depth along camera z of the objects, see eval/cell/visible_size.h.
double WorkingDistance_m(const SimulatedCell& cell);

// Holds the estimator of a scenario.
class EstimatorRunner {
 public:
  using Progress = std::function<void(std::string_view what, double share)>;
  // Counts the poses that a grasp can reach; see EstimatorInput::count_reachable. The poses have
  // the object indices of the cell.
  using ReachCounter = std::function<int(std::span<const PoseHypothesis>, int wanted)>;

  // Makes the estimator. Codebooks come from the cache if it holds them, else they are made and
  // `on_progress` is called. `cell` must outlive this object. Results do not depend on `threads`.
  // `log_dir`: folder for the output of an estimator that is another program; empty = not kept.
  // Throws InputError that begins with the key "estimator" for an unknown name or mode and for a
  // broken model file, and one with the key "camera.eye_m" if an object is smaller than
  // kMinVisibleDiameter_px in the image.
  EstimatorRunner(const SimulatedCell& cell, const ScenarioSpec& spec, int threads,
                  const Progress& on_progress, const std::filesystem::path& log_dir = {});
  ~EstimatorRunner();

  // Returns the poses inside the bin, in the camera frame. Times are under "estimate" and, for each
  // stage, "estimate/STAGE". Only estimators that support traces fill `trace`. Without
  // `count_reachable`, a grasp can reach every pose. `is_first`: see EstimatorInput. Throws
  // InputError if it is set and no depth reading is in the region of interest.
  EstimateResult Estimate(const RgbdFrame& frame, const CellCalibration& calibration, Rng& rng,
                          EstimateTrace* trace = nullptr, const ReachCounter& count_reachable = {},
                          bool is_first = false);
  // Same for an exact cell.
  EstimateResult Estimate(const RgbdFrame& frame, Rng& rng, EstimateTrace* trace = nullptr);

 private:
  // Replaces the object indices of the estimator by the indices of the cell.
  void UseObjectsOfCell(std::vector<PoseHypothesis>& hypotheses) const;

  const SimulatedCell& cell_;
  RegionSpec roi_;
  std::unique_ptr<LabelledViewSource> views_;
  std::unique_ptr<PoseEstimator> estimator_;
};

// Makes the runner of the scenario's estimator; null if it is the oracle, whose poses are
// substituted after the estimate (eval/trial/oracle_estimator.h). Throws as EstimatorRunner().
std::unique_ptr<EstimatorRunner> MakeEstimatorRunner(const SimulatedCell& cell,
                                                     const ScenarioSpec& spec, int threads,
                                                     const EstimatorRunner::Progress& on_progress,
                                                     const std::filesystem::path& log_dir = {});

}  // namespace pickbed::eval
