#include "grasp/execute/settle.h"

#include <algorithm>
#include <vector>

#include "grasp/place/boxes_apart.h"
#include "scenes/geometry/triangle_mesh.h"

namespace pickbed::grasp {
namespace {

// Pose before and after a movement.
struct Movement {
  ObjectId object;
  Pose X_WO_before, X_WO_after;
};

// Bound of the distance that a point of the object moved.
double Moved_m(const ObjectModel& model, const Pose& X_WO_before, const Pose& X_WO_after) {
  const Eigen::Vector3d& com_O = model.mass.com_O;
  return (X_WO_after * com_O - X_WO_before * com_O).norm() +
         0.5 * model.diameter_m * RotationAngleRad(X_WO_before.linear(), X_WO_after.linear());
}

class Settler {
 public:
  Settler(const ObjectSet& objects, const SettleOptions& options, const PhysicsOptions& physics)
      : objects_(objects), options_(options), physics_(physics) {
    for (const auto& object : objects) {
      const Bounds bounds = MeshBounds(object->mesh_O);
      boxes_O_.push_back({0.5 * (bounds.min + bounds.max), 0.5 * bounds.size()});
    }
  }

  // Instances of `after` that moved since `before`.
  std::vector<Movement> Movements(const Scene& before, const Scene& after) const {
    std::vector<Movement> movements;
    for (const PosedObject& now : after.objects) {
      const auto then =
          std::find_if(before.objects.begin(), before.objects.end(),
                       [&](const PosedObject& posed) { return posed.instance == now.instance; });
      if (then == before.objects.end()) continue;
      if (Moved_m(*objects_.at(now.object), then->X_WO, now.X_WO) <= options_.moved_m) continue;
      movements.push_back({now.object, then->X_WO, now.X_WO});
    }
    return movements;
  }

  // Simulates the neighbors of these movements; all other instances are static.
  Scene Settle(const Scene& scene, const std::vector<Movement>& movements) const {
    PhysicsWorld world(physics_);
    world.AddBin(scene.bin);
    std::vector<bool> moves;
    for (const PosedObject& posed : scene.objects) {
      moves.push_back(IsNeighbor(posed, movements));
      world.AddInstance(*objects_.at(posed.object), posed.X_WO,
                        moves.back() ? BodyMode::kDynamic : BodyMode::kStatic, {}, posed.deviation);
    }
    while (world.time_s() < options_.max_s && !world.AllAsleep() && !world.BlewUp()) world.Step();
    if (world.BlewUp()) return scene;
    Scene settled;
    settled.bin = scene.bin;
    for (size_t i = 0; i < scene.objects.size(); ++i) {
      PosedObject posed = scene.objects[i];
      if (moves[i]) posed.X_WO = world.X_WO(static_cast<int>(i));
      const Eigen::Vector3d& com_O = objects_[posed.object]->mass.com_O;
      if (scene.bin.Holds(posed.X_WO * com_O)) settled.objects.push_back(posed);
    }
    return settled;
  }

 private:
  bool IsNeighbor(const PosedObject& posed, const std::vector<Movement>& movements) const {
    AxisAlignedBox grown_O = boxes_O_[posed.object];
    grown_O.half_size.array() += options_.gap_m;
    const Pose X_OW = posed.X_WO.inverse();
    return std::any_of(movements.begin(), movements.end(), [&](const Movement& movement) {
      const AxisAlignedBox& moved_O = boxes_O_[movement.object];
      return !BoxesApart(grown_O, moved_O, X_OW * movement.X_WO_before) ||
             !BoxesApart(grown_O, moved_O, X_OW * movement.X_WO_after);
    });
  }

  const ObjectSet& objects_;
  const SettleOptions& options_;
  const PhysicsOptions& physics_;
  std::vector<AxisAlignedBox> boxes_O_;  // by object
};

}  // namespace

void SettleOptions::Visit(SettingsVisitor& v) {
  v.Real("moved_m", moved_m, {0, 1},
         "movement of an instance above which its neighbors are settled, m");
  v.Real("gap_m", gap_m, {0, 1}, "distance of two bounding boxes of neighbors, m");
  v.Real("max_s", max_s, {0, 100}, "maximum simulated time of one round, s");
  v.Integer("max_rounds", max_rounds, {0, 1000}, "maximum number of rounds; 0 = no settling");
}

Scene SettleDisturbed(const Scene& before, Scene after, const ObjectSet& objects,
                      const SettleOptions& options, const PhysicsOptions& physics) {
  CheckSettings("SettleOptions", options);
  const Settler settler(objects, options, physics);
  std::vector<Movement> movements = settler.Movements(before, after);
  for (int round = 0; round < options.max_rounds && !movements.empty(); ++round) {
    Scene settled = settler.Settle(after, movements);
    movements = settler.Movements(after, settled);
    after = std::move(settled);
  }
  return after;
}

}  // namespace pickbed::grasp
