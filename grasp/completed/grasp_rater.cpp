#include "grasp/completed/grasp_rater.h"

#include <algorithm>
#include <cmath>

#include "grasp/grippers/suction_cup.h"
#include "grasp/plan/clearance.h"

namespace pickbed::grasp {

GraspRater::GraspRater(const PlannerInput& input, const Pose& X_WB, const ImageSegments& segments,
                       std::span<const OccupancyShape> shapes, const PlanOptions& plan)
    : input_(input),
      segments_(segments),
      plan_(plan),
      X_BW_(X_WB.inverse()),
      hidden_(input.frame.depth_m, input.frame.intrinsics, input.X_WC.inverse() * X_WB,
              plan.hidden_behind_m),
      surroundings_(input, segments, shapes) {}

const SegmentMeasures* GraspRater::SegmentOf(const Grasp& grasp, const Gripper& tool) const {
  return GraspedSegment(segments_, input_, tool, grasp.X_WG, grasp.width_m);
}

GraspMeasures GraspRater::Measure(const Grasp& grasp, const Gripper& tool,
                                  GraspedSurface surface) const {
  return MeasureOn(SegmentOf(grasp, tool), grasp, tool, surface);
}

GraspMeasures GraspRater::MeasureOn(const SegmentMeasures* segment, const Grasp& grasp,
                                    const Gripper& tool, GraspedSurface surface) const {
  const bool is_suction = dynamic_cast<const SuctionCup*>(&tool) != nullptr;
  GraspMeasures measures{surface, is_suction, grasp.score, grasp.width_m};
  measures.hidden_m = hidden_.MeanDepth_m(HandSweep(tool, tool.OpeningOrMax_m(grasp.width_m)),
                                          X_BW_ * grasp.X_WG, plan_.hidden_step_m);
  if (segment != nullptr) {
    measures.covered = segment->covered;
    measures.center_offset_m = CenterOffset_m(*segment, input_.X_WC, grasp.X_WG);
  }
  return measures;
}

std::vector<float> GraspRater::Inputs(const Grasp& grasp, const Gripper& tool,
                                      GraspedSurface surface) const {
  const double opening_m = tool.OpeningOrMax_m(grasp.width_m);
  const double tilt_rad = std::acos(std::clamp(-grasp.X_WG.linear()(2, 2), -1.0, 1.0));
  const SegmentMeasures* segment = SegmentOf(grasp, tool);
  return SuccessInputs(MeasureOn(segment, grasp, tool, surface), opening_m, tilt_rad,
                       surroundings_.Of(grasp.X_WG, opening_m, segment));
}

}  // namespace pickbed::grasp
