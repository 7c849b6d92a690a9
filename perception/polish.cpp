#include "perception/polish.h"

#include "scenes/parallel.h"

namespace pickbed {

void PolishPoses(const std::string& refiner, const OrganizedCloud& cloud,
                 std::span<const ModelPoints> models, const PolishOptions& options, int threads,
                 std::vector<PoseHypothesis>& hypotheses) {
  if (hypotheses.empty()) return;
  const auto refine_all = [&](const auto& refine) {
    ForRanges(static_cast<int>(hypotheses.size()), threads, [&](int begin, int end) {
      for (int i = begin; i < end; ++i) refine(models[hypotheses[i].object], hypotheses[i]);
    });
  };
  if (refiner == "pcl_icp") {
    const PclRefiner pcl(cloud, options.pcl_icp);
    refine_all([&](const ModelPoints& model, PoseHypothesis& h) { pcl.Refine(model, h); });
  } else if (refiner == "two_way_icp") {
    refine_all([&](const ModelPoints& model, PoseHypothesis& h) {
      RefineTwoWay(cloud, model, h, options.two_way_icp);
    });
  }
}

}  // namespace pickbed
