#include "grasp/place.h"

#include <algorithm>
#include <limits>

namespace pickbed {
namespace {

using Eigen::Vector3d;

std::vector<Vector3d> UpDirections(const ObjectModel& model) {
  std::vector<Vector3d> ups_O;
  for (const RestingDirection& resting : model.resting_O) ups_O.push_back(resting.up_O);
  if (!ups_O.empty()) return ups_O;
  for (int axis = 0; axis < 3; ++axis) {
    ups_O.push_back(Vector3d::Unit(axis));
    ups_O.push_back(-Vector3d::Unit(axis));
  }
  return ups_O;
}

// The turn of part and hand that lays the part down, of those that are asked for the one after
// which the hand points down most; the first of equals.
Eigen::Matrix3d LayingDown(const ObjectModel& model, const Pose& X_WO, const Pose& X_WG) {
  Eigen::Matrix3d best = Eigen::Matrix3d::Identity();
  double best_down = -std::numeric_limits<double>::infinity();
  for (const Vector3d& up_O : UpDirections(model)) {
    const Vector3d up_W = X_WO.linear() * up_O;
    const Eigen::Matrix3d turn =
        Eigen::Quaterniond::FromTwoVectors(up_W, Vector3d::UnitZ()).toRotationMatrix();
    const double down = -(turn * X_WG.linear().col(2)).z();
    if (down <= best_down + 1e-9) continue;
    best_down = down;
    best = turn;
  }
  return best;
}

double LowestOf(const TriangleMesh& mesh, const Pose& X_WO) {
  double lowest_m = std::numeric_limits<double>::infinity();
  for (const Vector3d& p_O : mesh.vertices) lowest_m = std::min(lowest_m, (X_WO * p_O).z());
  return lowest_m;
}

double LowestOf(std::span<const AxisAlignedBox> boxes, const Pose& X_WG) {
  double lowest_m = std::numeric_limits<double>::infinity();
  const Vector3d down_share = X_WG.linear().row(2).cwiseAbs();
  for (const AxisAlignedBox& box : boxes) {
    lowest_m = std::min(lowest_m, (X_WG * box.center).z() - down_share.dot(box.half_size));
  }
  return lowest_m;
}

}  // namespace

PlacePlan PlanPlace(const Bin& bin, const ObjectModel& model, const Pose& X_WO, const Pose& X_WG,
                    std::span<const AxisAlignedBox> hand_boxes, const PlaceOptions& options) {
  const double half_table_m = 2 * model.diameter_m;
  const double edge_m = 0.5 * bin.inner_size_m.x() + bin.wall_m + options.gap_m;
  PlacePlan plan;
  plan.table_W = {{edge_m + half_table_m, 0, -half_table_m}, Vector3d::Constant(half_table_m)};

  plan.X_WO = MakePose(LayingDown(model, X_WO, X_WG) * X_WO.linear(), Vector3d::Zero());
  Vector3d to_middle = -(plan.X_WO * model.mass.com_O);
  to_middle.x() += plan.table_W.center.x();
  to_middle.z() = -LowestOf(model.mesh_O, plan.X_WO);
  plan.X_WO.translation() = to_middle;

  plan.X_WG = plan.X_WO * X_WO.inverse() * X_WG;
  const double room_m = std::min(0.0, LowestOf(hand_boxes, plan.X_WG));
  plan.X_WG = Translation({0, 0, options.clearance_m - room_m}) * plan.X_WG;
  return plan;
}

PlaceError PlaceErrorOf(const ObjectModel& model, const Pose& X_WO_wanted, const Pose& X_WO) {
  constexpr int kTurns = 72;  // of a continuous symmetry: good to 2.5 degrees
  const Vector3d com_W = X_WO * model.mass.com_O;
  PlaceError best{0, std::numeric_limits<double>::infinity()};
  for (const Pose& X_OS : SymmetryTransforms(model.symmetries_O, kTurns)) {
    const Pose X_WS = X_WO_wanted * X_OS;
    const double turn_rad = RotationAngleRad(X_WS.linear(), X_WO.linear());
    if (turn_rad >= best.turn_rad) continue;
    best = {(com_W - X_WS * model.mass.com_O).norm(), turn_rad};
  }
  return best;
}

}  // namespace pickbed
