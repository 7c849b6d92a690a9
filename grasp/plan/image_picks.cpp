#include "grasp/plan/image_picks.h"

#include <algorithm>

#include "grasp/candidates/pad_contact.h"
#include "grasp/place/hand_motion.h"
#include "grasp/plan/clearance.h"

namespace pickbed::grasp {
namespace {

bool IsInside(const AxisAlignedBox& box, double clearance_m, const Eigen::Vector3d& p_G) {
  return ((p_G - box.center).cwiseAbs() - box.half_size).maxCoeff() < clearance_m;
}

// Returns the height of the lowest corner of the boxes at X_WG.
double LowestCorner_m(const std::vector<AxisAlignedBox>& boxes_G, const Pose& X_WG) {
  const Eigen::RowVector3d up = X_WG.linear().row(2);
  double lowest_m = X_WG.translation().z();
  for (const AxisAlignedBox& box : boxes_G) {
    lowest_m = std::min(
        lowest_m, X_WG.translation().z() + up.dot(box.center) - up.cwiseAbs().dot(box.half_size));
  }
  return lowest_m;
}

}  // namespace

void ImagePicksOptions::Visit(SettingsVisitor& v) {
  v.Real("apart_m", apart_m, {0, 1},
         "distance between the objects of two picks beyond half of their diameters, m");
  v.Real("spacing_m", spacing_m, {0.001, 0.1}, "spacing of the points on an object's surface, m");
  v.Real("lift_step_m", lift_step_m, {0.001, 0.1}, "step of the lift, m");
}

ImagePicks::ImagePicks(const ObjectSet& objects, const ImagePicksOptions& options)
    : objects_(objects), options_(options), points_O_(objects.size()) {
  CheckSettings("ImagePicksOptions", options_);
}

const Eigen::Matrix3Xd& ImagePicks::PointsOf(ObjectId object) const {
  constexpr int kMinPoints = 200, kMaxPoints = 2000;
  Eigen::Matrix3Xd& points_O = points_O_.at(object);
  if (points_O.cols() > 0) return points_O;
  const TriangleMesh& mesh_O = objects_.at(object)->mesh_O;
  Rng rng(objects_.at(object)->mesh_hash);
  const SurfacePoints surface =
      SpreadPoints(mesh_O, options_.spacing_m, kMinPoints, kMaxPoints, rng);
  points_O = surface.points_O.matrix().transpose().cast<double>();
  return points_O;
}

ImagePicks::Pick ImagePicks::MakePick(const Grasp& grasp, const EstimatedPose& pose,
                                      const Gripper& gripper) const {
  const ObjectModel& model = *objects_.at(pose.object);
  const double opening_m = gripper.OpeningOrMax_m(grasp.width_m);
  return {pose.X_WO * model.mass.com_O,
          0.5 * model.diameter_m + grasp.lift_aside_m.norm(),
          pose.X_WO * PointsOf(pose.object),
          grasp.X_WG,
          grasp.lift_aside_m,
          gripper.Boxes(opening_m),
          HandSweep(gripper, opening_m),
          gripper.clearance_m};
}

void ImagePicks::Add(const Grasp& grasp, const EstimatedPose& pose, const Gripper& gripper) {
  picks_.push_back(MakePick(grasp, pose, gripper));
}

bool ImagePicks::AreApart(const Pick& pick, const Eigen::Vector3d& center_W,
                          double radius_m) const {
  return (pick.center_W - center_W).head<2>().norm() >= pick.radius_m + radius_m + options_.apart_m;
}

bool ImagePicks::IsApart(const EstimatedPose& pose) const {
  const ObjectModel& model = *objects_.at(pose.object);
  const Eigen::Vector3d center_W = pose.X_WO * model.mass.com_O;
  return std::all_of(picks_.begin(), picks_.end(), [&](const Pick& pick) {
    return AreApart(pick, center_W, 0.5 * model.diameter_m);
  });
}

// A lifted hand passes a point if the hand at rest contains the point moved back by the lift.
bool ImagePicks::HandKeepsOff(const Pick& pick, const Eigen::Matrix3Xd& points_W) const {
  const double lowest_m = LowestCorner_m(pick.hand_G, pick.X_WG) - pick.clearance_m;
  const Pose X_GW = pick.X_WG.inverse();
  const auto meets = [&](const std::vector<AxisAlignedBox>& boxes_G, const Eigen::Vector3d& p_W) {
    const Eigen::Vector3d p_G = X_GW * p_W;
    return std::any_of(boxes_G.begin(), boxes_G.end(), [&](const AxisAlignedBox& box) {
      return IsInside(box, pick.clearance_m, p_G);
    });
  };
  for (int i = 0; i < points_W.cols(); ++i) {
    const Eigen::Vector3d p_W = points_W.col(i);
    if (meets(pick.sweep_G, p_W)) return false;
    for (double rise_m = 0; p_W.z() - rise_m >= lowest_m; rise_m += options_.lift_step_m) {
      if (meets(pick.hand_G, p_W - LiftMotion(pick.lift_aside_m, rise_m))) return false;
    }
  }
  return true;
}

bool ImagePicks::IsIndependent(const Grasp& grasp, const EstimatedPose& pose,
                               const Gripper& gripper) const {
  const Pick pick = MakePick(grasp, pose, gripper);
  return std::all_of(picks_.begin(), picks_.end(), [&](const Pick& earlier) {
    return AreApart(earlier, pick.center_W, pick.radius_m) &&
           HandKeepsOff(earlier, pick.points_W) && HandKeepsOff(pick, earlier.points_W);
  });
}

}  // namespace pickbed::grasp
