#pragma once

// Final refinement of reported poses, selected by the scenario key `refiner`. A new refiner is one
// file in icp/ and one row in final_refinement.cpp.

#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "perception/cloud/organized_cloud.h"
#include "perception/icp/icp_result.h"
#include "perception/model/model_points.h"
#include "perception/pose_hypothesis.h"
#include "scenes/base/settings.h"

namespace pickbed::perception {

// Refines one pose in the frame for which the function was made. It may be called from several
// threads at once.
using RefinePose = std::function<IcpResult(const ModelPoints& model, const Pose& X_CO)>;

// A refiner with its options.
class PoseRefiner {
 public:
  virtual ~PoseRefiner() = default;
  // Visits the options of this refiner.
  virtual void Visit(SettingsVisitor& v) = 0;
  // Prepares the refinement of poses in one frame; `cloud` must outlive the result. Empty: poses
  // are not refined.
  virtual RefinePose ForFrame(const OrganizedCloud& cloud) const = 0;
};

// One row of the table of refiners.
struct RefinerRow {
  const char* name;
  const char* help;
  std::unique_ptr<PoseRefiner> (*make)();  // with its default options
};

// Returns all refiners.
std::span<const RefinerRow> RefinerTable();

// Returns the row with this name. Throws InputError with the known names if there is none.
const RefinerRow& RefinerNamed(const std::string& name);

// Refines each hypothesis in place with `models[hypothesis.object]`: sets its X_CO, unrefined_X_CO
// and fit. A pose changes only if the refiner returns kRefined. The result does not depend on the
// number of threads.
void RefineFinally(const PoseRefiner& refiner, const OrganizedCloud& cloud,
                   std::span<const ModelPoints> models, int threads,
                   std::vector<PoseHypothesis>& hypotheses);
// Same for the row with this name and its default options. Throws InputError as RefinerNamed().
void RefineFinally(const std::string& refiner, const OrganizedCloud& cloud,
                   std::span<const ModelPoints> models, int threads,
                   std::vector<PoseHypothesis>& hypotheses);

}  // namespace pickbed::perception
