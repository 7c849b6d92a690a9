#include "grasp/tolerance/tolerance_trial.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "grasp/plan/plan.h"
#include "scenes/base/error.h"
#include "sim/drop/resting_poses.h"
#include "sim/physics/physics_world.h"

namespace pickbed::grasp {
namespace {

// Best grasp of the planner among `candidates` for an object with estimated pose X_WO.
std::optional<Grasp> BestGrasp(const Table& table, const Bin& bin, const Pose& X_WO,
                               std::vector<GraspCandidate> candidates, const PlanOptions& options) {
  const std::vector<EstimatedPose> poses{{ObjectId{0}, X_WO, 1}};
  const std::vector<std::vector<GraspCandidate>> by_object{std::move(candidates)};
  const PlanInput input{bin, poses, by_object, {}, table.objects, *table.gripper};
  const PlanResult plan = PlanGrasps(input, options);
  if (plan.grasps.empty()) return std::nullopt;
  return plan.grasps.front();
}

Pose SettledPose(const ObjectModel& object, const Bin& bin, Pose X_WO,
                 const TableOptions& options) {
  PhysicsWorld world;
  world.AddBin(bin);
  X_WO.translation().z() += options.drop_m;
  world.AddInstance(object, X_WO);
  while (world.time_s() < options.settle_s && !world.AllAsleep()) world.Step();
  return world.X_WO(0);
}

// Place at a share 0..1 of the drops that end in a graspable place.
int PlaceAt(const Table& table, double share) {
  double total = 0;
  for (const RestingPlace& place : table.places) total += place.graspable ? place.probability : 0;
  int last = 0;
  for (size_t i = 0; i < table.places.size(); ++i) {
    if (!table.places[i].graspable) continue;
    last = static_cast<int>(i);
    share -= table.places[i].probability / total;
    if (share < 0) break;
  }
  return last;
}

std::vector<GraspCandidate> DrawnCandidates(std::vector<GraspCandidate> candidates, int count,
                                            Rng& rng) {
  const int all = static_cast<int>(candidates.size());
  for (int k = 0; k < count; ++k) std::swap(candidates[k], candidates[k + rng.Index(all - k)]);
  candidates.resize(count);
  return candidates;
}

// The candidate that the planner selects at the true pose. The planner may have retracted the hand
// from the table along the approach, so the candidate is the one whose approach line contains the
// hand.
std::optional<GraspCandidate> ChosenCandidate(const Table& table, int place,
                                              const std::vector<GraspCandidate>& choice) {
  PlanOptions plan;
  plan.max_grasps = 1;
  const Scene& scene = table.places[place].scene;
  const Pose& X_WO = scene.objects[0].X_WO;
  const auto best = BestGrasp(table, scene.bin, X_WO, choice, plan);
  if (!best) return std::nullopt;
  const Pose X_OG = X_WO.inverse() * best->X_WG;
  const auto distance = [&](const GraspCandidate& candidate) {
    const Eigen::Vector3d moved_G = candidate.X_OG.inverse() * X_OG.translation();
    return moved_G.head<2>().norm() + std::max(0.0, moved_G.z()) +
           RotationAngleRad(candidate.X_OG.linear(), X_OG.linear());
  };
  return *std::min_element(
      choice.begin(), choice.end(),
      [&](const GraspCandidate& a, const GraspCandidate& b) { return distance(a) < distance(b); });
}

}  // namespace

void TableOptions::Visit(SettingsVisitor& v) {
  v.Vector3("size_m", size_m, {0, 10}, "size of the table, a bin without walls, m");
  v.Real("friction", friction, {0, 10}, "coefficient of friction of the table top");
  v.Integer("drops", drops, {1, 10000}, "number of drops from which the resting poses are found");
  v.Real("min_probability", min_probability, {0, 1}, "minimum probability of a resting pose");
  v.Real("drop_m", drop_m, {0, 0.1}, "height from which the object settles in its resting pose, m");
  v.Real("settle_s", settle_s, {0, 100}, "maximum time to settle, s");
  v.Real("choice_share", choice_share, {0, 1},
         "share of the candidates from which a grasp is chosen");
  v.Integer("min_choice", min_choice, {1, 1000000},
            "minimum number of candidates from which a grasp is chosen");
  v.Integer("max_draws", max_draws, {1, 100},
            "maximum number of choices until the planner finds a grasp");
}

std::vector<RestingPlace> RestingPlacesOf(const ObjectModel& object, const TableOptions& options) {
  CheckSettings("TableOptions", options);
  Bin bin;
  bin.inner_size_m = options.size_m;
  bin.friction = options.friction;
  std::vector<RestingPlace> places;
  for (const RestingPose& pose : FindRestingPoses(object, options.drops)) {
    if (pose.probability < options.min_probability) continue;
    places.push_back(
        {{bin, {{InstanceId{0}, ObjectId{0}, SettledPose(object, bin, pose.X_WO, options)}}},
         pose.probability});
  }
  return places;
}

Table MakeTable(std::shared_ptr<const ObjectModel> object, std::shared_ptr<const Gripper> gripper,
                std::vector<GraspCandidate> candidates, const TableOptions& options) {
  CheckSettings("TableOptions", options);
  const std::string who = fmt::format("{} with {}", object->name, gripper->name);
  CheckInput(!candidates.empty(), who + ": the object has no grasp that fits this gripper");
  Table table{
      {object}, std::move(gripper), std::move(candidates), RestingPlacesOf(*object, options)};
  bool any = false;
  for (RestingPlace& place : table.places) {
    const Scene& scene = place.scene;
    place.graspable =
        BestGrasp(table, scene.bin, scene.objects[0].X_WO, table.candidates, {}).has_value();
    any = any || place.graspable;
  }
  CheckInput(any,
             fmt::format("{}: the table leaves no room for a grasp in any of the {} resting poses",
                         who, table.places.size()));
  return table;
}

std::vector<TableGrasp> DrawTableGrasps(const Table& table, int count, Rng& rng,
                                        const TableOptions& options) {
  CheckSettings("TableOptions", options);
  const int all = static_cast<int>(table.candidates.size());
  std::vector<TableGrasp> grasps;
  for (int i = 0; i < count; ++i) {
    const int place = PlaceAt(table, (i + 0.5) / count);
    int wanted = std::max(options.min_choice, static_cast<int>(options.choice_share * all));
    for (int draw = 0; draw < options.max_draws; ++draw, wanted *= 2) {
      const auto choice = DrawnCandidates(table.candidates, std::min(wanted, all), rng);
      if (const auto candidate = ChosenCandidate(table, place, choice)) {
        grasps.push_back({place, *candidate});
        break;
      }
      if (wanted >= all) break;
    }
  }
  return grasps;
}

GraspOutcome ExecuteWithError(const Table& table, const TableGrasp& grasp, const Pose& X_OE,
                              const ExecuteOptions& options) {
  const Scene& scene = table.places[grasp.place].scene;
  PlanOptions plan;
  plan.max_grasps = 1;
  plan.max_tilt_rad = std::numbers::pi;  // the grasp is given: only the table may reject it
  plan.min_quality = 0;
  const Pose X_WO_estimated = scene.objects[0].X_WO * X_OE;
  const auto planned = BestGrasp(table, scene.bin, X_WO_estimated, {grasp.candidate}, plan);
  if (!planned) {
    GraspOutcome outcome;
    outcome.failure = FailureReason::kNoGrasp;
    return outcome;
  }
  return ExecuteGrasp(scene, table.objects, *planned, *table.gripper, InstanceId{0}, options)
      .outcome;
}

}  // namespace pickbed::grasp
