#include "grasp/plan/plan.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>

#include "grasp/candidates/pad_contact.h"
#include "grasp/candidates/surface_sampling.h"
#include "grasp/plan/clearance.h"
#include "scenes/base/error.h"

namespace pickbed::grasp {
namespace {

using Eigen::Vector3d;

constexpr double kTouching_m = 1e-6;  // margin, so that rounding gives no overlap

enum Cause {
  kTilt,
  kQuality,
  kOpening,
  kBinFloor,
  kBinWall,
  kFingers,
  kPalm,
  kOutranked,
  kNotTried,
  kCauses,
  kFree = kCauses
};
constexpr const char* kCauseNames[kCauses] = {"tilt",
                                              "quality",
                                              "opening",
                                              "bin floor",
                                              "bin wall",
                                              "fingers meet an instance",
                                              "palm meets an instance",
                                              "outranked",
                                              "not tried"};

// Data shared by all poses of one object.
struct ObjectShape {
  Eigen::Matrix3Xd points_O;    // uniform density
  Eigen::Matrix3Xd obstacle_O;  // points_O and points along sharp edges
  double thickness_m;           // minimum extent along the axes of O
  SurfaceBand band;
  std::vector<std::optional<double>> openings_m;  // by candidate; nullopt = beyond the stroke
};

ObjectShape MakeShape(const PlanInput& input, ObjectId object, const PlanOptions& options) {
  const ObjectModel& model = *input.objects[object];
  Rng rng(model.mesh_hash);
  SurfacePoints surface = SpreadPoints(model.mesh_O, options.neighbor_spacing_m,
                                       options.min_object_points, options.max_object_points, rng);
  const Eigen::Matrix3Xd points_O = surface.points_O.matrix().transpose().cast<double>();
  const Vector3d extent_m = points_O.rowwise().maxCoeff() - points_O.rowwise().minCoeff();
  const Eigen::Matrix3Xd edges_O = SharpEdgePoints(model.mesh_O, options.neighbor_spacing_m);
  Eigen::Matrix3Xd obstacle_O(3, points_O.cols() + edges_O.cols());
  obstacle_O << points_O, edges_O;
  ObjectShape shape{points_O,
                    std::move(obstacle_O),
                    extent_m.minCoeff(),
                    SurfaceBand(points_O, options.own_points_m),
                    {}};
  for (const GraspCandidate& candidate : input.candidates[object]) {
    shape.openings_m.push_back(input.gripper.ApproachOpening_m(candidate.width_m));
  }
  return shape;
}

Vector3d CenterOf(const PlanInput& input, const EstimatedPose& pose) {
  return pose.X_WO * input.objects[pose.object]->mass.com_O;
}

class Planner {
 public:
  Planner(const PlanInput& input, const PlanOptions& options)
      : input_(input),
        options_(options),
        ranking_(RankingNamed(options.ranking)),
        bin_boxes_(BinBoxes(input.bin)),
        shapes_(MakeShapes()),
        field_(MakeField()) {
    for (const EstimatedPose& pose : input.poses) {
      lowest_ = std::min(lowest_, CenterOf(input, pose).z());
      highest_ = std::max(highest_, CenterOf(input, pose).z());
    }
  }

  PlanResult Run() {
    ignored_.resize(input_.poses.size());
    for (size_t i = 0; i < input_.poses.size(); ++i) {
      if (MayGrasp(static_cast<int>(i))) PlanPose(static_cast<int>(i));
    }
    if (by_chance()) {
      Rng rng(options_.seed);
      for (Pending& pending : pending_) pending.grasp.score = rng.Uniform();
    }
    // The point check is the most expensive one and only lowers a score. So candidates are checked
    // from the best score on, until no other can be among the reported grasps.
    std::stable_sort(pending_.begin(), pending_.end(), [](const Pending& a, const Pending& b) {
      return a.grasp.score > b.grasp.score;
    });
    PlanResult result;
    std::vector<Grasp>& best = result.grasps;
    const size_t wanted = options_.max_grasps;
    rejected_[kNotTried] = static_cast<int>(pending_.size());
    for (Pending& pending : pending_) {
      if (best.size() == wanted && best.back().score >= pending.grasp.score) break;
      --rejected_[kNotTried];
      const Cause cause = CheckPoints(pending);
      if (cause != kFree) {
        ++rejected_[cause];
        continue;
      }
      const auto place =
          std::upper_bound(best.begin(), best.end(), pending.grasp,
                           [](const Grasp& a, const Grasp& b) { return a.score > b.score; });
      best.insert(place, pending.grasp);
      if (best.size() <= wanted) continue;
      best.pop_back();
      ++rejected_[kOutranked];
    }
    for (int cause = 0; cause < kCauses; ++cause) {
      if (rejected_[cause] > 0) result.rejected[kCauseNames[cause]] = rejected_[cause];
    }
    return result;
  }

  // Number of poses with a grasp that is free of bin, points and other poses, up to `wanted`.
  int Reachable(int wanted) {
    ignored_.resize(input_.poses.size());
    int reachable = 0;
    for (size_t i = 0; i < input_.poses.size() && reachable < wanted; ++i) {
      pending_.clear();
      PlanPose(static_cast<int>(i));
      std::stable_sort(pending_.begin(), pending_.end(), [](const Pending& a, const Pending& b) {
        return a.grasp.score > b.grasp.score;
      });
      reachable += std::any_of(pending_.begin(), pending_.end(),
                               [&](Pending& p) { return CheckPoints(p) == kFree; });
    }
    return reachable;
  }

 private:
  bool by_chance() const { return ranking_.value == nullptr; }

  bool MayGrasp(int pose) const {
    const auto& targets = input_.targets;
    return targets.empty() || std::find(targets.begin(), targets.end(), pose) != targets.end();
  }

  // Clear of the bin; not yet checked against the points.
  struct Pending {
    Grasp grasp;
    double opening_m;
  };

  std::vector<std::optional<ObjectShape>> MakeShapes() const {
    std::vector<std::optional<ObjectShape>> shapes(input_.objects.size());
    for (const EstimatedPose& pose : input_.poses) {
      const size_t object = static_cast<size_t>(pose.object);
      if (object >= shapes.size() || object >= input_.candidates.size()) {
        throw std::logic_error("an estimated pose names an object without grasp candidates");
      }
      if (!shapes[object]) shapes[object] = MakeShape(input_, pose.object, options_);
    }
    return shapes;
  }

  ObstacleField MakeField() const {
    double height = 0;  // reach of the swept volume above the finger tips
    for (const AxisAlignedBox& box : HandSweep(input_.gripper, 0)) {
      height = std::max(height, box.half_size.z() - box.center.z());
    }
    std::vector<Vector3d> points =
        ThinnedCloud(input_.cloud_W, input_.bin, options_.voxel_m, options_.bin_band_m, height);
    std::vector<int> sources(points.size(), -1);
    for (size_t i = 0; i < input_.poses.size(); ++i) {
      const EstimatedPose& pose = input_.poses[i];
      if (pose.confidence < options_.neighbor_confidence) continue;
      const Eigen::Matrix3Xd& points_O = shapes_[pose.object]->obstacle_O;
      for (int k = 0; k < points_O.cols(); ++k) points.push_back(pose.X_WO * points_O.col(k));
      sources.resize(points.size(), static_cast<int>(i));
    }
    return ObstacleField(std::move(points), std::move(sources), options_.column_m);
  }

  // Poses that claim the same instance as pose `target`, itself included. Flat objects that cross
  // each other have their centers one thickness apart and are two instances.
  std::vector<bool> Rivals(int target) const {
    const EstimatedPose& pose = input_.poses[target];
    std::vector<bool> rivals(input_.poses.size());
    for (size_t i = 0; i < rivals.size(); ++i) {
      const EstimatedPose& other = input_.poses[i];
      const double size = std::min(input_.objects[pose.object]->diameter_m,
                                   input_.objects[other.object]->diameter_m);
      const double thickness =
          std::min(shapes_[pose.object]->thickness_m, shapes_[other.object]->thickness_m);
      const double apart = (CenterOf(input_, pose) - CenterOf(input_, other)).norm();
      rivals[i] =
          apart < std::min(options_.same_share * size, options_.same_thickness_share * thickness);
    }
    rivals[target] = true;
    return rivals;
  }

  std::vector<uint8_t> IgnoredPoints(int target) const {
    const EstimatedPose& pose = input_.poses[target];
    const ObjectShape& shape = *shapes_[pose.object];
    const std::vector<bool> rivals = Rivals(target);
    const Pose X_OW = pose.X_WO.inverse();
    std::vector<uint8_t> ignored(field_.points_W().size());
    for (size_t i = 0; i < ignored.size(); ++i) {
      const int source = field_.sources()[i];
      ignored[i] = source >= 0 ? rivals[source] : shape.band.Contains(X_OW * field_.points_W()[i]);
    }
    return ignored;
  }

  void PlanPose(int target) {
    const EstimatedPose& pose = input_.poses[target];
    const ObjectShape& shape = *shapes_[pose.object];
    ignored_[target] = IgnoredPoints(target);
    const double covered =
        field_.CoveredShare(pose.X_WO * shape.points_O, ignored_[target], options_.cover_above_m);
    const double range = highest_ - lowest_;
    const double depth = range > 0 ? (highest_ - CenterOf(input_, pose).z()) / range : 0;
    const double pose_score = pose.confidence * (1 - options_.cover_share * covered) *
                              (1 - options_.height_share * depth);
    const std::vector<GraspCandidate>& candidates = input_.candidates[pose.object];
    for (size_t k = 0; k < candidates.size(); ++k) {
      Grasp grasp;
      grasp.X_WG = pose.X_WO * candidates[k].X_OG;
      grasp.width_m = candidates[k].width_m;
      grasp.hypothesis = target;
      const double place_factor = 1 - options_.place_share * (1 - candidates[k].place_quality);
      grasp.score = pose_score * place_factor * (by_chance() ? 1 : ranking_.value(candidates[k]));
      const std::optional<double>& opening_m = shape.openings_m[k];
      const Cause cause = CheckBin(candidates[k], opening_m, grasp);
      if (cause == kFree) {
        pending_.push_back({grasp, *opening_m});
      } else {
        ++rejected_[cause];
      }
    }
  }

  // Retracts a hand that would meet the floor along its approach and lowers the score accordingly.
  // Returns false if too little of the contact would remain.
  bool KeepOffFloor(std::span<const AxisAlignedBox> sweep, double depth_m, Grasp& grasp) const {
    const Eigen::RowVector3d up = grasp.X_WG.linear().row(2);
    double lowest = std::numeric_limits<double>::infinity();
    for (const AxisAlignedBox& box : sweep) {
      lowest = std::min(lowest, grasp.X_WG.translation().z() + up.dot(box.center) -
                                    up.cwiseAbs().dot(box.half_size));
    }
    const double missing = options_.bin_clearance_m + kTouching_m - lowest;
    if (missing <= 0) return true;
    const double back = missing / -up.z();
    if (!(up.z() < 0) || back > depth_m - options_.min_depth_m) return false;
    grasp.X_WG.translate(Vector3d(0, 0, -back));
    grasp.score *= std::min(1.0, (depth_m - back) / options_.good_depth_m) /
                   std::min(1.0, depth_m / options_.good_depth_m);
    return true;
  }

  // Moves a hand that would meet a wall horizontally, across its closing direction, and lowers the
  // score. Returns false if the required distance is too large.
  bool KeepOffWalls(double opening_m, Grasp& grasp) const {
    const double max_m = input_.gripper.MaxAside_m();
    const Vector3d across_W = grasp.X_WG.linear().col(0).cross(Vector3d::UnitZ());
    const Eigen::Matrix3d spread = grasp.X_WG.linear().cwiseAbs();
    double move_m = 0;
    for (const AxisAlignedBox& box : input_.gripper.Boxes(opening_m)) {
      const Vector3d center = grasp.X_WG * box.center, reach = spread * box.half_size;
      if (center.z() - reach.z() > input_.bin.inner_size_m.z()) continue;
      for (int axis = 0; axis < 2; ++axis) {
        const double room_m =
            0.5 * input_.bin.inner_size_m[axis] - options_.bin_clearance_m - kTouching_m;
        const double over_m = std::abs(center[axis]) + reach[axis] - room_m;
        if (over_m <= 0) continue;
        const double needed_m = over_m / -(std::copysign(1.0, center[axis]) * across_W[axis]);
        if (!(std::abs(needed_m) <= max_m)) return false;
        if (std::abs(needed_m) > std::abs(move_m)) move_m = needed_m;
      }
    }
    grasp.X_WG = Translation(move_m * across_W) * grasp.X_WG;
    grasp.score *= 1 - options_.aside_share * std::abs(move_m) / std::max(max_m, kTouching_m);
    return true;
  }

  // The candidate was clear of its own instance at its original pose, but may not be after the
  // move.
  bool MeetsTarget(std::span<const AxisAlignedBox> sweep, const Grasp& grasp) const {
    const EstimatedPose& pose = input_.poses[grasp.hypothesis];
    const Pose X_GO = grasp.X_WG.inverse() * pose.X_WO;
    const Eigen::Matrix3Xd points_G = X_GO * shapes_[pose.object]->obstacle_O;
    return std::any_of(sweep.begin(), sweep.end(), [&](const AxisAlignedBox& box) {
      const Eigen::Matrix3Xd outside_m =
          (points_G.colwise() - box.center).cwiseAbs().colwise() - box.half_size;
      return (outside_m.colwise().maxCoeff().array() < 0).any();
    });
  }

  bool MeetsBin(std::span<const AxisAlignedBox> sweep, const Grasp& grasp) const {
    return FindBinContact(sweep, grasp.X_WG, bin_boxes_, options_.bin_clearance_m).has_value();
  }

  // Scales the score of a free grasp by its tilt.
  Cause CheckBin(const GraspCandidate& candidate, const std::optional<double>& opening_m,
                 Grasp& grasp) const {
    const double tilt = std::acos(std::clamp(-grasp.X_WG.linear()(2, 2), -1.0, 1.0));
    if (tilt > options_.max_tilt_rad) return kTilt;
    if (!by_chance() && candidate.quality < options_.min_quality) return kQuality;
    if (!opening_m) return kOpening;
    const auto sweep = HandSweep(input_.gripper, *opening_m);
    if (!KeepOffFloor(sweep, candidate.depth_m, grasp)) return kBinFloor;
    if (MeetsBin(sweep, grasp) &&
        (!KeepOffWalls(*opening_m, grasp) || MeetsBin(sweep, grasp) || MeetsTarget(sweep, grasp))) {
      return kBinWall;
    }
    grasp.score *= 1 - options_.tilt_share * tilt / options_.max_tilt_rad;
    return kFree;
  }

  // Scales the score of a free grasp by the free space around it.
  Cause CheckPoints(Pending& pending) const {
    const Gripper& gripper = input_.gripper;
    Grasp& grasp = pending.grasp;
    const auto sweep = HandSweep(gripper, pending.opening_m);
    const auto between = gripper.RegionBetween(pending.opening_m);
    const auto seen =
        field_.Query(grasp.X_WG, sweep, between, ignored_[grasp.hypothesis], options_.good_room_m);
    const auto palm = seen.distance_m.begin() + sweep.size() - 1;
    const double fingers = *std::min_element(seen.distance_m.begin(), palm);
    const double clearance_m = options_.clearance_share * gripper.clearance_m;
    if (fingers < clearance_m) return kFingers;
    if (*palm < clearance_m) return kPalm;
    if (by_chance()) return kFree;
    const double room = std::min(1.0, std::min(fingers, *palm) / options_.good_room_m);
    const double crowd = std::min(1.0, double(seen.between) / options_.many_between);
    grasp.score *= (1 - options_.room_share * (1 - room)) * (1 - options_.between_share * crowd);
    return kFree;
  }

  const PlanInput& input_;
  const PlanOptions& options_;
  const RankingRow& ranking_;
  std::vector<AxisAlignedBox> bin_boxes_;
  std::vector<std::optional<ObjectShape>> shapes_;  // by object; set if some pose names the object
  ObstacleField field_;
  double lowest_ = std::numeric_limits<double>::infinity();
  double highest_ = -std::numeric_limits<double>::infinity();
  // By pose that may be grasped: one flag per point of the field.
  std::vector<std::vector<uint8_t>> ignored_;
  std::vector<Pending> pending_;
  std::array<int, kCauses> rejected_{};
};

}  // namespace

PlanResult PlanGrasps(const PlanInput& input, const PlanOptions& options) {
  CheckSettings("PlanOptions", options);
  PlanResult result = Planner(input, options).Run();
  if (!result.grasps.empty() || !options.relaxed.enabled) return result;
  PlanOptions wide = options;
  wide.max_tilt_rad = std::max(options.max_tilt_rad, options.relaxed.max_tilt_rad);
  wide.min_quality = std::min(options.min_quality, options.relaxed.min_quality);
  wide.clearance_share = std::min(options.clearance_share, options.relaxed.clearance_share);
  wide.bin_clearance_m = std::min(options.bin_clearance_m, options.relaxed.bin_clearance_m);
  result = Planner(input, wide).Run();
  result.with_relaxed_constraints = true;
  return result;
}

int CountReachable(const PlanInput& input, int wanted, const PlanOptions& options) {
  CheckSettings("PlanOptions", options);
  return Planner(input, options).Reachable(wanted);
}

namespace {

constexpr std::array<RankingRow, 4> kRankings{{
    {"quality", "quality from angle, area, depth and lever arm of the contacts, 0 to 1",
     [](const GraspCandidate& candidate) { return candidate.quality; }},
    {"epsilon", "smallest load from any direction that the contacts cannot balance",
     [](const GraspCandidate& candidate) { return candidate.epsilon / (1 + candidate.epsilon); }},
    {"robust", "share of sampled errors under which the grasp holds",
     [](const GraspCandidate& candidate) { return candidate.robust; }},
    {"random", "random order of the grasps without collision, as a baseline", nullptr},
}};

}  // namespace

void RelaxedConstraints::Visit(SettingsVisitor& v) {
  v.RenamedKey("look", "enabled");
  v.Bool("enabled", enabled,
         "whether planning is repeated with these limits if no grasp was found");
  v.Real("max_tilt_rad", max_tilt_rad, {0.01, std::numbers::pi},
         "maximum angle of the approach from straight down, rad");
  v.Real("min_quality", min_quality, {0, 1}, "minimum quality of a candidate");
  v.Real("clearance_share", clearance_share, {-2, 1},
         "share of the gripper's clearance that is kept");
  v.Real("bin_clearance_m", bin_clearance_m, {0, 0.1}, "distance between hand and bin, m");
}

void PlanOptions::Visit(SettingsVisitor& v) {
  const Range share{0, 1};
  const Range length{0, 0.1};
  v.Integer("max_grasps", max_grasps, {1, 100000}, "maximum number of reported grasps");
  std::vector<std::string> rankings;
  for (const RankingRow& row : kRankings) rankings.push_back(row.name);
  v.Text("ranking", ranking, rankings, "criterion that orders the grasps");
  v.Seed("seed", seed, "random seed of the ranking random");
  v.Real("max_tilt_rad", max_tilt_rad, {0.01, std::numbers::pi},
         "maximum angle of the approach from straight down, rad");
  v.Real("own_points_m", own_points_m, {0.001, 0.1},
         "cloud points closer than this to the target's surface belong to it, m");
  v.Real("clearance_share", clearance_share, {-2, 1},
         "share of the gripper's clearance that is kept");
  v.Real("bin_clearance_m", bin_clearance_m, length, "distance between hand and bin, m");
  v.Real("min_depth_m", min_depth_m, length, "minimum depth of the contact behind the tips, m");
  v.Real("good_depth_m", good_depth_m, {0.001, 0.1},
         "depth of the contact behind the tips from which there is no loss, m");
  v.Real("min_quality", min_quality, share, "minimum quality of a candidate");
  v.Real("voxel_m", voxel_m, {0.0005, 0.1}, "voxel size to which the cloud is thinned, m");
  v.Real("bin_band_m", bin_band_m, length,
         "cloud points closer than this to floor and walls belong to the bin, m");
  v.Real("neighbor_confidence", neighbor_confidence, {0, kNoNeighbors},
         "minimum confidence of an estimated pose that is an obstacle");
  v.Real("neighbor_spacing_m", neighbor_spacing_m, {0.001, 0.1},
         "spacing of the points on the poses that are obstacles, m");
  v.Real("same_share", same_share, share,
         "poses closer than this share of the diameter can be the same instance");
  v.Real("same_thickness_share", same_thickness_share, share,
         "poses closer than this share of the minimum extent can be the same instance");
  v.Real("height_share", height_share, share, "share of the score that the lowest instance loses");
  v.Real("tilt_share", tilt_share, share, "share of the score that is lost at max_tilt_rad");
  v.Real("room_share", room_share, share,
         "share of the score that is lost if others touch the hand");
  v.Real("cover_share", cover_share, share,
         "share of the score that is lost if others cover the whole target");
  v.Real("aside_share", aside_share, share,
         "share of the score that is lost if the hand is shifted away from a wall");
  v.RenamedKey("set_down_share", "place_share");
  v.Real("place_share", place_share, share,
         "share of the score that is lost if the object cannot be set down with this grasp");
  v.Real("between_share", between_share, share,
         "share of the score that is lost if others are between the fingers");
  v.Real("good_room_m", good_room_m, {0.001, 0.1},
         "distance from others from which there is no loss, m");
  v.Integer("many_between", many_between, {1, 100000},
            "number of points between the fingers at which the loss is full");
  v.Real("column_m", column_m, {0.001, 0.1}, "cell size of the floor-plan grid of the points, m");
  v.RenamedKey("min_part_points", "min_object_points");
  v.Integer("min_object_points", min_object_points, {10, 100000},
            "minimum number of points on an estimated pose");
  v.RenamedKey("max_part_points", "max_object_points");
  v.Integer("max_object_points", max_object_points, {10, 100000},
            "maximum number of points on an estimated pose");
  v.RenamedKey("wide", "relaxed");
  v.Group(
      "relaxed", [this](SettingsVisitor& g) { relaxed.Visit(g); },
      "limits of a second planning if no grasp was found");
  v.Real("cover_above_m", cover_above_m, length,
         "points higher than this above the target cover it, m");
}

std::span<const RankingRow> RankingTable() { return kRankings; }

const RankingRow& RankingNamed(const std::string& name) {
  std::vector<std::string> names;
  for (const RankingRow& row : kRankings) {
    if (name == row.name) return row;
    names.push_back(row.name);
  }
  throw InputError(UnknownNameMessage("ranking", name, names));
}

}  // namespace pickbed::grasp
