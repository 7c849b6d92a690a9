#pragma once

// The final refiners by the names that a scenario's `refiner` takes: pcl_icp, two_way_icp or none.

#include <span>
#include <string>
#include <vector>

#include "perception/icp.h"
#include "perception/two_way_icp.h"

namespace pickbed {

struct PolishOptions {
  PclIcpOptions pcl_icp;
  TwoWayIcpOptions two_way_icp;
};

// Refines each hypothesis with `models[hypothesis.object]`; another name than the two changes
// nothing. No pose gets worse by its refiner's own measure. Poses are the same for any number of
// threads.
void PolishPoses(const std::string& refiner, const OrganizedCloud& cloud,
                 std::span<const ModelPoints> models, const PolishOptions& options, int threads,
                 std::vector<PoseHypothesis>& hypotheses);

}  // namespace pickbed
