#include "grasp/plan/plan.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <list>
#include <numeric>
#include <stdexcept>

#include "grasp/plan/clearance.h"
#include "grasp/plan/hold_factor.h"
#include "grasp/plan/lift_aside.h"
#include "grasp/plan/object_shape.h"
#include "grasp/plan/rejection_cause.h"
#include "grasp/plan/stacking.h"
#include "scenes/base/error.h"

namespace pickbed::grasp {
namespace {

using Eigen::Vector3d;

constexpr double kTouching_m = 1e-6;  // margin, so that rounding gives no overlap

// Plans on one input. Shapes, obstacle points and flags are shared by all runs.
class CandidateCheck {
 public:
  // `tool`: its number; each tool has its own random order.
  CandidateCheck(const PlanInput& input, const PlanOptions& options, size_t tool)
      : input_(input),
        tool_(tool),
        options_(options),
        ranking_(RankingNamed(options.ranking)),
        bin_boxes_(BinBoxes(input.bin)),
        shapes_(MakeShapes()),
        observed_W_(MakeObserved()),
        field_(MakeField()),
        stack_(options.stacking_cell_m),
        may_grasp_(input.poses.size(), input.targets.empty()),
        is_scored_(input.poses.size(), false),
        ignored_(input.poses.size()),
        pose_scores_(input.poses.size()) {
    for (const int pose : input.targets) may_grasp_.at(pose) = true;
    for (const EstimatedPose& pose : input.poses) {
      stack_.Add(pose.X_WO * shapes_[pose.object]->points_O);
      centers_W_.push_back(pose.X_WO * input.objects[pose.object]->mass.com_O);
      lowest_ = std::min(lowest_, centers_W_.back().z());
      highest_ = std::max(highest_, centers_W_.back().z());
    }
  }

  // `options` may differ from the constructor's in the relaxed constraints only.
  PlanResult Run(const PlanOptions& options) {
    options_ = options;
    pending_.clear();
    rejected_ = {};
    Rng rng(options_.seed + tool_);
    for (size_t i = 0; i < input_.poses.size(); ++i) {
      if (may_grasp_[i]) PlanPose(static_cast<int>(i), rng);
    }
    // The score of a pose and the checks against bin and points are expensive, and only lower a
    // score. So candidates are scored and checked from the best score on, until no other can be
    // among the reported grasps.
    std::make_heap(pending_.begin(), pending_.end(), IsAfter);
    PlanResult result;
    std::vector<Grasp>& best = result.grasps;
    const size_t wanted = options_.max_grasps;
    while (!pending_.empty()) {
      const Pending pending = pending_.front();
      if (best.size() == wanted && best.back().score >= pending.score) break;
      std::pop_heap(pending_.begin(), pending_.end(), IsAfter);
      if (pending.is_bound) {
        pending_.back() = Scored(pending);
        std::push_heap(pending_.begin(), pending_.end(), IsAfter);
        continue;
      }
      pending_.pop_back();
      Grasp grasp = GraspOf(pending);
      const Cause cause = Check(pending, grasp);
      if (cause != kFree) {
        ++rejected_[cause];
        continue;
      }
      const auto place =
          std::upper_bound(best.begin(), best.end(), grasp,
                           [](const Grasp& a, const Grasp& b) { return a.score > b.score; });
      grasp.tool = input_.gripper.name;
      best.insert(place, grasp);
      if (best.size() <= wanted) continue;
      best.pop_back();
      ++rejected_[kOutranked];
    }
    for (Grasp& grasp : best) grasp.lift_aside_m = LiftAside(grasp);
    rejected_[kNotTried] = static_cast<int>(pending_.size());
    for (int cause = 0; cause < kCauses; ++cause) {
      if (rejected_[cause] > 0) result.rejected[CauseName(cause)] = rejected_[cause];
    }
    return result;
  }

  // Whether this pose has a grasp that is free of bin, points and other poses.
  bool HasGrasp(int pose) {
    if (!may_grasp_[pose]) return false;
    pending_.clear();
    Rng rng(options_.seed + tool_);
    PlanPose(pose, rng);
    for (Pending& pending : pending_) pending = Scored(pending);
    std::stable_sort(pending_.begin(), pending_.end(),
                     [](const Pending& a, const Pending& b) { return a.score > b.score; });
    return std::any_of(pending_.begin(), pending_.end(), [&](const Pending& pending) {
      Grasp grasp = GraspOf(pending);
      return Check(pending, grasp) == kFree;
    });
  }

 private:
  bool by_chance() const { return ranking_.value == nullptr; }
  double Size_m(const EstimatedPose& pose) const { return input_.objects[pose.object]->diameter_m; }

  // A candidate of a pose that is neither too tilted, too poor nor too wide.
  struct Pending {
    double score;  // maximum, before the checks
    int order;     // among all pending candidates
    int pose;
    int candidate;
    bool is_bound;  // the pose is not scored yet: from its confidence
  };
  // Order of the heap: the best score first, equal ones in their order.
  static bool IsAfter(const Pending& a, const Pending& b) {
    return a.score < b.score || (a.score == b.score && a.order > b.order);
  }

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

  std::vector<Vector3d> MakeObserved() const {
    double height = 0;  // reach of the swept volume above the finger tips
    for (const AxisAlignedBox& box : HandSweep(input_.gripper, 0)) {
      height = std::max(height, box.half_size.z() - box.center.z());
    }
    return ThinnedCloud(input_.cloud_W, input_.bin, options_.voxel_m, options_.bin_band_m, height);
  }

  // Each observed point is a group, then each pose.
  ObstacleField MakeField() const {
    std::vector<Vector3d> points = observed_W_;
    std::vector<int> groups(points.size());
    std::iota(groups.begin(), groups.end(), 0);
    for (size_t i = 0; i < input_.poses.size(); ++i) {
      const EstimatedPose& pose = input_.poses[i];
      if (pose.confidence < options_.neighbor_confidence) continue;
      const Eigen::Matrix3Xd& points_O = shapes_[pose.object]->obstacle_O;
      for (int k = 0; k < points_O.cols(); ++k) points.push_back(pose.X_WO * points_O.col(k));
      groups.resize(points.size(), static_cast<int>(observed_W_.size() + i));
    }
    return ObstacleField(std::move(points), std::move(groups), options_.column_m);
  }

  // Poses that claim the same instance as pose `target`, itself included. Flat objects that cross
  // each other have their centers one thickness apart and are two instances.
  std::vector<bool> Rivals(int target) const {
    const EstimatedPose& pose = input_.poses[target];
    std::vector<bool> rivals(input_.poses.size());
    for (size_t i = 0; i < rivals.size(); ++i) {
      const EstimatedPose& other = input_.poses[i];
      const double size = std::min(Size_m(pose), Size_m(other));
      const double thickness =
          std::min(shapes_[pose.object]->thickness_m, shapes_[other.object]->thickness_m);
      const double apart = (centers_W_[target] - centers_W_[i]).norm();
      rivals[i] =
          apart < std::min(options_.same_share * size, options_.same_thickness_share * thickness);
    }
    rivals[target] = true;
    return rivals;
  }

  std::vector<uint8_t> IgnoredGroups(int target, const std::vector<bool>& rivals) const {
    const EstimatedPose& pose = input_.poses[target];
    const ObjectShape& shape = *shapes_[pose.object];
    const Pose X_OW = pose.X_WO.inverse();
    const double radius2 = shape.band_radius_m * shape.band_radius_m;
    std::vector<uint8_t> ignored;
    for (const Vector3d& p_W : observed_W_) {
      ignored.push_back((p_W - pose.X_WO.translation()).squaredNorm() < radius2 &&
                        shape.band.Contains(X_OW * p_W));
    }
    ignored.insert(ignored.end(), rivals.begin(), rivals.end());
    return ignored;
  }

  // Score of the pose, which every grasp on it is multiplied by.
  double PoseScore(int target, const std::vector<bool>& rivals) const {
    const EstimatedPose& pose = input_.poses[target];
    const ObjectShape& shape = *shapes_[pose.object];
    const double covered =
        field_.CoveredShare(pose.X_WO * shape.points_O, ignored_[target], options_.cover_above_m);
    const double range = highest_ - lowest_;
    const double depth = range > 0 ? (highest_ - centers_W_[target].z()) / range : 0;
    const std::vector<int> above = stack_.Above(target);
    const std::vector<bool> others = Others(rivals);
    const auto carried =
        std::count_if(above.begin(), above.end(), [&](int other) { return others[other]; });
    return pose.confidence * (1 - options_.cover_share * covered) *
           (1 - options_.height_share * depth) *
           std::pow(1 - options_.stacking_share, static_cast<double>(carried));
  }

  // Poses that count as other instances than the target.
  std::vector<bool> Others(std::vector<bool> rivals) const {
    for (size_t i = 0; i < rivals.size(); ++i) {
      rivals[i] = !rivals[i] && input_.poses[i].confidence >= options_.neighbor_confidence;
    }
    return rivals;
  }

  Eigen::Vector2d LiftAside(const Grasp& grasp) const {
    const int target = grasp.hypothesis;
    const EstimatedPose& pose = input_.poses[target];
    const auto cover = stack_.CenterOfCover(target, Others(Rivals(target)));
    if (!cover || !input_.gripper.PullsAside()) return Eigen::Vector2d::Zero();
    const double length_m = options_.lift_aside_diameters * Size_m(pose);
    const auto wanted_m = AwayFrom(*cover, centers_W_[target].head<2>(), length_m);
    const auto opening_m = input_.gripper.ApproachOpening_m(grasp.width_m);
    return ShiftInBin(wanted_m, input_.bin, pose.X_WO * shapes_[pose.object]->points_O,
                      input_.gripper.Boxes(*opening_m), grasp.X_WG);
  }

  // Fills ignored_ and pose_scores_ of a pose.
  void ScorePose(int target) {
    if (is_scored_[target]) return;
    const std::vector<bool> rivals = Rivals(target);
    ignored_[target] = IgnoredGroups(target, rivals);
    pose_scores_[target] = PoseScore(target, rivals);
    is_scored_[target] = true;
  }

  // Cosine of the angle between the approach and straight down.
  double Down(int target, const GraspCandidate& candidate) const {
    const Eigen::RowVector3d up_O = input_.poses[target].X_WO.linear().row(2);
    return -up_O.dot(candidate.X_OG.linear().col(2));
  }

  // Score of a candidate on a pose with this score.
  double ScoreOf(int target, const GraspCandidate& candidate, double pose_score) const {
    const EstimatedPose& pose = input_.poses[target];
    const double tilt = std::acos(std::clamp(Down(target, candidate), -1.0, 1.0));
    const double place_factor = 1 - options_.place_share * (1 - candidate.place_quality);
    const double load_factor =
        ranking_.weighs_load ? 1 - options_.load_share / (1 + candidate.epsilon) : 1;
    return pose_score * place_factor * load_factor * ranking_.value(candidate) *
           (1 - options_.tilt_share * tilt / options_.max_tilt_rad) *
           HoldFactor(input_.gripper, *input_.objects[pose.object], candidate.X_OG, pose.X_WO,
                      options_.lift_load);
  }

  // Replaces a bound by the score.
  Pending Scored(Pending pending) {
    ScorePose(pending.pose);
    const double pose_score = pose_scores_[pending.pose];
    if (pending.is_bound) pending.score = ScoreOf(pending.pose, CandidateOf(pending), pose_score);
    pending.is_bound = false;
    return pending;
  }

  void PlanPose(int target, Rng& rng) {
    const EstimatedPose& pose = input_.poses[target];
    const ObjectShape& shape = *shapes_[pose.object];
    const std::vector<GraspCandidate>& candidates = input_.candidates[pose.object];
    const double min_down = std::cos(options_.max_tilt_rad);
    for (size_t k = 0; k < candidates.size(); ++k) {
      const double down = Down(target, candidates[k]);
      const Cause cause = down < min_down                                                ? kTilt
                          : !by_chance() && candidates[k].quality < options_.min_quality ? kQuality
                          : !shape.openings_m[k]                                         ? kOpening
                                                                                         : kFree;
      if (cause != kFree) {
        ++rejected_[cause];
        continue;
      }
      Pending pending{0, static_cast<int>(pending_.size()), target, static_cast<int>(k), false};
      if (!by_chance()) {
        // PoseScore() is at most the confidence.
        pending.is_bound = !is_scored_[target];
        pending.score = ScoreOf(target, candidates[k],
                                pending.is_bound ? pose.confidence : pose_scores_[target]);
      } else {
        Grasp grasp = GraspOf(pending);
        const Cause bin = CheckBin(pending, grasp);
        if (bin != kFree) {
          ++rejected_[bin];
          continue;
        }
        pending.score = rng.Uniform();
      }
      pending_.push_back(pending);
    }
  }

  const GraspCandidate& CandidateOf(const Pending& pending) const {
    return input_.candidates[input_.poses[pending.pose].object][pending.candidate];
  }

  double OpeningOf(const Pending& pending) const {
    return *shapes_[input_.poses[pending.pose].object]->openings_m[pending.candidate];
  }

  Grasp GraspOf(const Pending& pending) const {
    Grasp grasp;
    grasp.X_WG = input_.poses[pending.pose].X_WO * CandidateOf(pending).X_OG;
    grasp.width_m = CandidateOf(pending).width_m;
    grasp.hypothesis = pending.pose;
    grasp.score = pending.score;
    return grasp;
  }

  // Moves the grasp off floor and walls, and scales its score.
  Cause Check(const Pending& pending, Grasp& grasp) {
    ScorePose(pending.pose);
    const Cause cause = CheckBin(pending, grasp);
    if (by_chance()) grasp.score = pending.score;
    return cause == kFree ? CheckPoints(OpeningOf(pending), grasp) : cause;
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
    return AnyInside(X_GO * shapes_[pose.object]->obstacle_O, sweep);
  }

  bool MeetsBin(double opening_m, const Grasp& on) const {
    return HandMeetsBin(input_.gripper, opening_m, on.X_WG, bin_boxes_, options_.bin_clearance_m);
  }

  Cause CheckBin(const Pending& pending, Grasp& grasp) const {
    const double opening_m = OpeningOf(pending);
    const auto sweep = HandSweep(input_.gripper, opening_m);
    if (!KeepOffFloor(sweep, CandidateOf(pending).depth_m, grasp)) return kBinFloor;
    if (MeetsBin(opening_m, grasp) && (!KeepOffWalls(opening_m, grasp) ||
                                       MeetsBin(opening_m, grasp) || MeetsTarget(sweep, grasp))) {
      return kBinWall;
    }
    return kFree;
  }

  // Scales the score of a free grasp by the free space around it.
  Cause CheckPoints(double opening_m, Grasp& grasp) const {
    const Gripper& gripper = input_.gripper;
    const auto sweep = HandSweep(gripper, opening_m);
    const std::vector<uint8_t>& ignored = ignored_[grasp.hypothesis];
    const double clearance_m = options_.clearance_share * gripper.clearance_m;
    if (const auto box = field_.FirstMet(grasp.X_WG, sweep, ignored, clearance_m)) {
      return *box + 1 < static_cast<int>(sweep.size()) ? kFingers : kPalm;
    }
    if (by_chance()) return kFree;
    const auto between = gripper.RegionBetween(opening_m);
    const auto seen = field_.Query(grasp.X_WG, sweep, between, ignored, options_.good_room_m);
    const double nearest_m = *std::min_element(seen.distance_m.begin(), seen.distance_m.end());
    const double room = std::min(1.0, nearest_m / options_.good_room_m);
    const double crowd = std::min(1.0, double(seen.between) / options_.many_between);
    grasp.score *= (1 - options_.room_share * (1 - room)) * (1 - options_.between_share * crowd);
    if (input_.hidden != nullptr) {
      const double hidden_m = input_.hidden->MeanDepth_m(sweep, grasp.X_WG, options_.hidden_step_m);
      grasp.score *= 1 - options_.hidden_share * std::min(1.0, hidden_m / options_.full_hidden_m);
    }
    return kFree;
  }

  const PlanInput& input_;
  const size_t tool_;
  PlanOptions options_;
  const RankingRow& ranking_;
  std::vector<AxisAlignedBox> bin_boxes_;
  std::vector<std::optional<ObjectShape>> shapes_;  // by object; set if some pose names the object
  std::vector<Vector3d> observed_W_;
  std::vector<Vector3d> centers_W_;  // by pose: center of mass
  ObstacleField field_;
  InstanceStack stack_;  // by pose
  double lowest_ = std::numeric_limits<double>::infinity();
  double highest_ = -std::numeric_limits<double>::infinity();
  std::vector<bool> may_grasp_;                // by pose
  std::vector<bool> is_scored_;                // by pose: whether the next two are filled
  std::vector<std::vector<uint8_t>> ignored_;  // one flag per group of the field
  std::vector<double> pose_scores_;
  std::vector<Pending> pending_;
  std::array<int, kCauses> rejected_{};
};

// One planner per tool. They keep references to `inputs`.
std::list<CandidateCheck> ChecksOf(std::span<const PlanInput> inputs, const PlanOptions& options) {
  CheckSettings("PlanOptions", options);
  std::list<CandidateCheck> planners;
  for (const PlanInput& input : inputs) planners.emplace_back(input, options, planners.size());
  return planners;
}

}  // namespace

PlanResult PlanWithTools(std::span<const PlanInput> inputs, const PlanOptions& options) {
  std::list<CandidateCheck> planners = ChecksOf(inputs, options);
  const auto run = [&](const PlanOptions& constraints) {
    PlanResult all;
    for (CandidateCheck& planner : planners) {
      PlanResult one = planner.Run(constraints);
      for (const auto& [cause, count] : one.rejected) all.rejected[cause] += count;
      all.grasps.insert(all.grasps.end(), one.grasps.begin(), one.grasps.end());
    }
    std::stable_sort(all.grasps.begin(), all.grasps.end(),
                     [](const Grasp& a, const Grasp& b) { return a.score > b.score; });
    const size_t wanted = std::min<size_t>(options.max_grasps, all.grasps.size());
    if (wanted < all.grasps.size()) {
      all.rejected[CauseName(kOutranked)] += static_cast<int>(all.grasps.size() - wanted);
      all.grasps.resize(wanted);
    }
    return all;
  };
  PlanResult result = run(options);
  if (!result.grasps.empty() || !options.relaxed.enabled) return result;
  PlanOptions wide = options;
  wide.max_tilt_rad = std::max(options.max_tilt_rad, options.relaxed.max_tilt_rad);
  wide.min_quality = std::min(options.min_quality, options.relaxed.min_quality);
  wide.clearance_share = std::min(options.clearance_share, options.relaxed.clearance_share);
  wide.bin_clearance_m = std::min(options.bin_clearance_m, options.relaxed.bin_clearance_m);
  result = run(wide);
  result.with_relaxed_constraints = true;
  return result;
}

PlanResult PlanGrasps(const PlanInput& input, const PlanOptions& options) {
  return PlanWithTools({&input, 1}, options);
}

int CountReachable(std::span<const PlanInput> inputs, int wanted, const PlanOptions& options) {
  std::list<CandidateCheck> planners = ChecksOf(inputs, options);
  int reachable = 0;
  const int poses = static_cast<int>(inputs.front().poses.size());
  for (int pose = 0; pose < poses && reachable < wanted; ++pose) {
    reachable += std::any_of(planners.begin(), planners.end(),
                             [&](CandidateCheck& planner) { return planner.HasGrasp(pose); });
  }
  return reachable;
}

}  // namespace pickbed::grasp
