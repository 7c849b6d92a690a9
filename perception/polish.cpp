#include "perception/polish.h"

namespace pickbed {

void PolishPoses(const std::string& refiner, const OrganizedCloud& cloud,
                 std::span<const ModelPoints> models, const PolishOptions& options,
                 std::vector<PoseHypothesis>& hypotheses) {
  if (hypotheses.empty()) return;
  if (refiner == "pcl_icp") {
    const PclRefiner pcl(cloud, options.pcl_icp);
    for (PoseHypothesis& h : hypotheses) pcl.Refine(models[h.object], h);
  } else if (refiner == "two_way_icp") {
    for (PoseHypothesis& h : hypotheses) {
      RefineTwoWay(cloud, models[h.object], h, options.two_way_icp);
    }
  }
}

}  // namespace pickbed
