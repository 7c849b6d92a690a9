#include "grasp/plan/object_shape.h"

#include "grasp/candidates/pad_contact.h"
#include "grasp/candidates/surface_sampling.h"

namespace pickbed::grasp {

ObjectShape MakeShape(const PlanInput& input, ObjectId object, const PlanOptions& options) {
  const ObjectModel& model = *input.objects[object];
  Rng rng(model.mesh_hash);
  SurfacePoints surface = SpreadPoints(model.mesh_O, options.neighbor_spacing_m,
                                       options.min_object_points, options.max_object_points, rng);
  const Eigen::Matrix3Xd points_O = surface.points_O.matrix().transpose().cast<double>();
  const Eigen::Vector3d extent_m = points_O.rowwise().maxCoeff() - points_O.rowwise().minCoeff();
  const Eigen::Matrix3Xd edges_O = SharpEdgePoints(model.mesh_O, options.neighbor_spacing_m);
  Eigen::Matrix3Xd obstacle_O(3, points_O.cols() + edges_O.cols());
  obstacle_O << points_O, edges_O;
  ObjectShape shape{points_O,
                    std::move(obstacle_O),
                    extent_m.minCoeff(),
                    points_O.colwise().norm().maxCoeff() + 2 * options.own_points_m,
                    SurfaceBand(points_O, options.own_points_m),
                    {}};
  for (const GraspCandidate& candidate : input.candidates[object]) {
    shape.openings_m.push_back(input.gripper.ApproachOpening_m(candidate.width_m));
  }
  return shape;
}

}  // namespace pickbed::grasp
