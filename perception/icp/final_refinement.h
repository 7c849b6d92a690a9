#pragma once

// Final refinement of reported poses, selected by the scenario key `refiner`. A new refiner is one
// file in icp/ and one row in final_refinement.cpp.

#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "perception/icp/bidirectional_icp.h"
#include "perception/icp/icp_result.h"
#include "perception/icp/pcl_icp.h"
#include "perception/pose_hypothesis.h"

namespace pickbed::perception {

// Options of all refiners.
struct RefinerOptions {
  PclIcpOptions pcl_icp;
  BidirectionalIcpOptions bidirectional_icp;
  void Visit(SettingsVisitor& v);
};

// Refines one pose in the frame for which the function was made. It may be called from several
// threads at once.
using RefinePose = std::function<IcpResult(const ModelPoints& model, const Pose& X_CO)>;

// One row of the table of refiners.
struct RefinerRow {
  const char* name;
  const char* help;
  // Makes the refiner of one frame; `cloud` must outlive it. Empty: poses are not refined.
  RefinePose (*make)(const OrganizedCloud& cloud, const RefinerOptions& options);
};

// Returns all refiners.
std::span<const RefinerRow> RefinerTable();

// Returns the row with this name. Throws InputError with the known names if there is none.
const RefinerRow& RefinerNamed(const std::string& name);

// Refines each hypothesis in place with `models[hypothesis.object]`: sets its X_CO, unrefined_X_CO
// and fit. A pose changes only if the refiner returns kRefined. The result does not depend on the
// number of threads. Throws InputError as RefinerNamed() does, and for options out of
// range.
void RefineFinally(const std::string& refiner, const OrganizedCloud& cloud,
                   std::span<const ModelPoints> models, const RefinerOptions& options, int threads,
                   std::vector<PoseHypothesis>& hypotheses);

}  // namespace pickbed::perception
