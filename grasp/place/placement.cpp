#include "grasp/place/placement.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "grasp/place/hand_motion.h"
#include "scenes/geometry/decompositions.h"

namespace pickbed::grasp {
namespace {

using Eigen::AngleAxisd;
using Eigen::Vector3d;

constexpr int kTurns = 72;       // of a continuous symmetry; error at most 2.5 degrees
constexpr int kPathSamples = 8;  // poses of the hand checked along the path

// Resting directions and their images under the symmetries; a bottle rests on any side. Without
// known directions, the six along the axes of O are used.
std::vector<RestingDirection> WaysToRest(const ObjectModel& model) {
  std::vector<RestingDirection> known = model.resting_O;
  for (int axis = 0; axis < 3 && model.resting_O.empty(); ++axis) {
    known.push_back({Vector3d::Unit(axis), 1.0 / 6});
    known.push_back({-Vector3d::Unit(axis), 1.0 / 6});
  }
  const std::vector<Pose> same = SymmetryTransforms(model.symmetries_O, kTurns);
  std::vector<RestingDirection> ways;
  for (const RestingDirection& resting : known) {
    for (const Pose& X_OS : same) {
      ways.push_back({X_OS.linear() * resting.up_O, resting.probability});
    }
  }
  return ways;
}

// Vertices of the collision shape of the object.
std::vector<Vector3d> CornersOf(const ObjectModel& model) {
  std::vector<Vector3d> corners_O;
  for (const ConvexPiece& piece : model.convex_pieces_O) {
    corners_O.insert(corners_O.end(), piece.vertices_O.begin(), piece.vertices_O.end());
  }
  return corners_O.empty() ? model.mesh_O.vertices : corners_O;
}

Vector3d LowestOf(std::span<const Vector3d> corners_O, const Pose& X_WO) {
  const Eigen::RowVector3d up_O = X_WO.linear().row(2);
  return *std::min_element(
      corners_O.begin(), corners_O.end(),
      [&](const Vector3d& a, const Vector3d& b) { return up_O.dot(a) < up_O.dot(b); });
}

double LowestOf(std::span<const AxisAlignedBox> boxes, const Pose& X_WG) {
  double lowest_m = std::numeric_limits<double>::infinity();
  const Vector3d down_share = X_WG.linear().row(2).cwiseAbs();
  for (const AxisAlignedBox& box : boxes) {
    lowest_m = std::min(lowest_m, (X_WG * box.center).z() - down_share.dot(box.half_size));
  }
  return lowest_m;
}

// Height of the lowest point of the hand above the plane z = 0. The object rests on that plane with
// orientation R_WO and is held at X_OG.
double HandLowest_m(std::span<const Vector3d> corners_O, const Eigen::Matrix3d& R_WO,
                    const Pose& X_OG, std::span<const AxisAlignedBox> hand_boxes) {
  Pose X_WO = MakePose(R_WO, Vector3d::Zero());
  X_WO.translation() = -(X_WO * LowestOf(corners_O, X_WO));
  return LowestOf(hand_boxes, X_WO * X_OG);
}

// Factor 0..1 for the height from which the object drops.
double DropFactor(double hand_lowest_m, const PlaceOptions& options) {
  const double drop_m = std::max(0.0, options.clearance_m - hand_lowest_m);
  return options.good_drop_m / (options.good_drop_m + drop_m);
}

// Factor 0..1 for a hand that does not point straight down; `approach_W` is z of G.
double TiltFactor(const Vector3d& approach_W, const PlaceOptions& options) {
  const double tilt_rad = std::acos(std::clamp(-approach_W.z(), -1.0, 1.0));
  return std::max(0.0, 1 - options.tilt_share * tilt_rad / (0.5 * std::numbers::pi));
}

struct Laying {
  Eigen::Matrix3d R_WO = Eigen::Matrix3d::Identity();  // at release
  Eigen::Matrix3d R_WO_flat = Eigen::Matrix3d::Identity();
  double hand_lowest_m = 0;
  double worth = -1;
};

// Selects the best orientation at release over all resting directions. If the hand would collide
// with the table, the object is released inclined and tips the rest.
Laying BestLaying(std::span<const RestingDirection> ways, std::span<const Vector3d> corners_O,
                  const Pose& X_WO, const Pose& X_WG, std::span<const AxisAlignedBox> hand_boxes,
                  const PlaceOptions& options) {
  const Pose X_OG = X_WO.inverse() * X_WG;
  Laying best;
  for (const RestingDirection& way : ways) {
    const AngleAxisd turn(RotationBetween(X_WO.linear() * way.up_O, Vector3d::UnitZ()));
    const Eigen::Matrix3d R_WO_flat = turn * X_WO.linear();
    const double upright = TiltFactor(R_WO_flat * X_OG.linear().col(2), options);
    for (int step = 0; step < options.tip_steps; ++step) {
      const double left_rad = options.tip_rad * step / options.tip_steps;
      if (step > 0 && left_rad > turn.angle()) break;
      Laying laying;
      laying.R_WO_flat = R_WO_flat;
      laying.R_WO = AngleAxisd(turn.angle() - left_rad, turn.axis()) * X_WO.linear();
      laying.hand_lowest_m = HandLowest_m(corners_O, laying.R_WO, X_OG, hand_boxes);
      laying.worth = way.probability * (1 - left_rad / options.tip_rad) * upright *
                     DropFactor(laying.hand_lowest_m, options);
      // The margin keeps the first of equals, so that neither order nor rounding decides.
      if (laying.worth > best.worth + 1e-9) best = laying;
      if (laying.hand_lowest_m >= options.clearance_m) break;  // more only reduces the worth
    }
  }
  return best;
}

}  // namespace

void PlaceOptions::Visit(SettingsVisitor& v) {
  const Range length{0, 1}, share{0, 1}, speed{0.001, 10};
  v.Real("gap_m", gap_m, length, "gap between bin and table, m");
  v.Real("rim_clearance_m", rim_clearance_m, length,
         "distance of hand and object above the bin's rim during the carry, m");
  v.Real("clearance_m", clearance_m, length, "distance of the hand above the table at release, m");
  v.Real("tilt_share", tilt_share, share,
         "share of a resting direction's worth that is lost if the hand points sideways");
  v.Real("tip_rad", tip_rad, {0.01, 1.5}, "inclination at release at which the worth is 0, rad");
  v.Real("good_drop_m", good_drop_m, {0.0001, 1},
         "drop height at release that halves the worth, m");
  v.Integer("tip_steps", tip_steps, {1, 1000}, "number of inclinations tried");
  v.Real("lower_mps", lower_mps, speed, "peak speed of the descent to the table, m/s");
  v.Real("slow_m", slow_m, length, "height above the table from which the descent is slow, m");
  v.Real("slow_mps", slow_mps, speed, "speed of the slow descent, m/s");
  v.Real("steady_s", steady_s, {0, 10}, "pause before the slow descent to measure the weight, s");
  v.Real("touch_n", touch_n, {0.01, 1000}, "load taken by the table at which the descent stops, N");
  v.Real("overtravel_m", overtravel_m, length,
         "maximum descent below the expected height of the table, m");
  v.Real("release_mps", release_mps, speed, "speed of each finger at release, m/s");
}

PlacePlan PlanPlace(const Bin& bin, const ObjectModel& model, const Pose& X_WO, const Pose& X_WG,
                    std::span<const AxisAlignedBox> hand_boxes, const PlaceOptions& options) {
  CheckSettings("PlaceOptions", options);
  const double half_table_m = 2 * model.diameter_m;
  const double edge_m = 0.5 * bin.inner_size_m.x() + bin.wall_m + options.gap_m;
  PlacePlan plan;
  plan.table_W = {{edge_m + half_table_m, 0, -half_table_m}, Vector3d::Constant(half_table_m)};

  const std::vector<Vector3d> corners_O = CornersOf(model);
  const Laying laying = BestLaying(WaysToRest(model), corners_O, X_WO, X_WG, hand_boxes, options);

  plan.X_WO = MakePose(laying.R_WO_flat, Vector3d::Zero());
  Vector3d to_center = -(plan.X_WO * model.mass.com_O);
  to_center.x() += plan.table_W.center.x();
  to_center.z() = -(plan.X_WO * LowestOf(corners_O, plan.X_WO)).z();
  plan.X_WO.translation() = to_center;

  // An inclined object tips about its lowest corner, which stays in place.
  Pose X_WO_let_go = MakePose(laying.R_WO, Vector3d::Zero());
  const Vector3d low_O = LowestOf(corners_O, X_WO_let_go);
  Vector3d low_W = plan.X_WO * low_O;
  low_W.z() = 0;
  X_WO_let_go.translation() = low_W - X_WO_let_go * low_O;

  const double drop_m = std::max(0.0, options.clearance_m - laying.hand_lowest_m);
  plan.X_WG = Translation({0, 0, drop_m}) * X_WO_let_go * X_WO.inverse() * X_WG;
  plan.overtravel_m =
      std::clamp(laying.hand_lowest_m - options.clearance_m, 0.0, options.overtravel_m);
  return plan;
}

double CarryHeight_m(const Bin& bin, const ObjectModel& model, const Pose& X_GO,
                     const Pose& X_WG_from, const Pose& X_WG_to,
                     std::span<const AxisAlignedBox> hand_boxes, const PlaceOptions& options) {
  const std::vector<Vector3d> corners_O = CornersOf(model);
  double lowest_m = 0;  // relative to the origin of G
  for (int i = 0; i <= kPathSamples; ++i) {
    Pose X_WG = Between(X_WG_from, X_WG_to, static_cast<double>(i) / kPathSamples);
    X_WG.translation().setZero();
    const Pose X_WO = X_WG * X_GO;
    lowest_m =
        std::min({lowest_m, LowestOf(hand_boxes, X_WG), (X_WO * LowestOf(corners_O, X_WO)).z()});
  }
  return bin.inner_size_m.z() + options.rim_clearance_m - lowest_m;
}

std::vector<double> SetDownWorths(const ObjectModel& model, std::span<const Pose> X_OG,
                                  std::span<const std::vector<AxisAlignedBox>> hand_boxes,
                                  const PlaceOptions& options) {
  CheckSettings("PlaceOptions", options);
  const std::vector<Vector3d> corners_O = CornersOf(model);
  std::vector<double> worths(X_OG.size(), 0);
  double maximum = 0;
  for (const RestingDirection& way : WaysToRest(model)) {
    maximum = std::max(maximum, way.probability);
    const Eigen::Matrix3d R_WO = RotationBetween(way.up_O, Vector3d::UnitZ()).toRotationMatrix();
    for (size_t i = 0; i < X_OG.size(); ++i) {
      const double upright = way.probability * TiltFactor(R_WO * X_OG[i].linear().col(2), options);
      if (upright <= worths[i]) continue;
      const double lowest_m = HandLowest_m(corners_O, R_WO, X_OG[i], hand_boxes[i]);
      worths[i] = std::max(worths[i], upright * DropFactor(lowest_m, options));
    }
  }
  if (maximum > 0) {
    for (double& worth : worths) worth /= maximum;
  }
  return worths;
}

PlaceError PlaceErrorOf(const ObjectModel& model, const Pose& X_WO_wanted, const Pose& X_WO,
                        const Vector3d& com_O) {
  const Vector3d com_W = X_WO * com_O;
  PlaceError best{0, std::numeric_limits<double>::infinity()};
  for (const Pose& X_OS : SymmetryTransforms(model.symmetries_O, kTurns)) {
    const Pose X_WS = X_WO_wanted * X_OS;
    const double rotation_error_rad = RotationAngleRad(X_WS.linear(), X_WO.linear());
    if (rotation_error_rad >= best.rotation_error_rad) continue;
    best = {(com_W - X_WS * model.mass.com_O).norm(), rotation_error_rad};
  }
  return best;
}

}  // namespace pickbed::grasp
