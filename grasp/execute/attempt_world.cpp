#include "grasp/execute/attempt_world.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "grasp/place/boxes_apart.h"
#include "grasp/place/hand_motion.h"
#include "scenes/geometry/triangle_mesh.h"

namespace pickbed::grasp {

using Eigen::Vector3d;

void AttemptWorldOptions::Visit(SettingsVisitor& v) {
  v.Real("near_m", near_m, {-1, 10},
         "distance from the path of target and hand from which instances are static, m");
  v.Bool("all_active", all_active, "whether all instances move and start awake; slow");
  v.Real("lost_below_m", lost_below_m, {0.01, 100},
         "depth below the floor at which instances are removed, m");
}

namespace {

// Box of each object in its frame.
std::vector<AxisAlignedBox> BoxesOf(const ObjectSet& objects) {
  std::vector<AxisAlignedBox> boxes;
  for (const auto& object : objects) {
    const Bounds bounds = MeshBounds(object->mesh_O);
    boxes.push_back({0.5 * (bounds.min + bounds.max), 0.5 * bounds.size()});
  }
  return boxes;
}

AxisAlignedBox Grown(AxisAlignedBox box, double by_m) {
  box.half_size = (box.half_size.array() + by_m).max(0);
  return box;
}

// Motions of target and hand from the grasp pose on, close enough for options.near_m. Straight up,
// they come closer to nothing.
std::vector<Pose> MotionsAside(const Eigen::Vector2d& lift_aside_m) {
  std::vector<Pose> motions_W{Pose::Identity()};
  if (lift_aside_m.isZero()) return motions_W;
  for (const double height_m : {0.01, 0.02, 0.04, 0.06, 0.12}) {
    motions_W.push_back(Translation(LiftMotion(lift_aside_m, height_m)));
  }
  return motions_W;
}

}  // namespace

AttemptWorld::AttemptWorld(const Scene& scene, const ObjectSet& objects, const Pose& X_WG,
                           std::span<const AxisAlignedBox> hand_G,
                           const Eigen::Vector2d& lift_aside_m, InstanceId instance,
                           const AttemptWorldOptions& options, const PhysicsOptions& physics)
    : scene_(scene), objects_(objects), lost_below_m_(options.lost_below_m), physics_(physics) {
  CheckSettings("AttemptWorldOptions", options);
  physics_.AddBin(scene.bin);
  const int reference = ReferenceInstance(X_WG.translation(), instance);
  if (reference >= 0) reference_diameter_m_ = ModelOf(reference).diameter_m;
  const std::vector<AxisAlignedBox> boxes_O = BoxesOf(objects);
  const std::vector<Pose> motions_W = MotionsAside(lift_aside_m);
  const auto is_near = [&](const PosedObject& posed) {
    const AxisAlignedBox box_O = Grown(boxes_O[posed.object], options.near_m);
    const auto meets = [&](const AxisAlignedBox& box, const Pose& X_W) {
      const Pose X_OW = posed.X_WO.inverse();
      return std::any_of(motions_W.begin(), motions_W.end(), [&](const Pose& motion_W) {
        return !BoxesApart(box_O, box, X_OW * motion_W * X_W);
      });
    };
    if (reference >= 0) {
      const PosedObject& target = scene.objects[reference];
      if (meets(boxes_O[target.object], target.X_WO)) return true;
    }
    return std::any_of(hand_G.begin(), hand_G.end(),
                       [&](const AxisAlignedBox& box_G) { return meets(box_G, X_WG); });
  };
  for (size_t i = 0; i < scene.objects.size(); ++i) {
    const PosedObject& posed = scene.objects[i];
    const ObjectModel& model = *objects.at(posed.object);
    const bool near = options.all_active || static_cast<int>(i) == reference || is_near(posed);
    const BodyMode moving = options.all_active ? BodyMode::kDynamic : BodyMode::kAsleep;
    physics_.AddInstance(model, posed.X_WO, near ? moving : BodyMode::kStatic, {}, posed.deviation);
    is_static_.push_back(!near);
    is_lost_.push_back(false);
  }
}

// The target, or the instance nearest to the grasp.
int AttemptWorld::ReferenceInstance(const Vector3d& grasp_W, InstanceId instance) const {
  int nearest = -1;
  double nearest_distance = std::numeric_limits<double>::infinity();
  for (size_t i = 0; i < scene_.objects.size(); ++i) {
    if (scene_.objects[i].instance == instance) return static_cast<int>(i);
    const double distance = (Center(static_cast<int>(i), scene_.objects[i].X_WO) - grasp_W).norm();
    if (distance < nearest_distance) {
      nearest_distance = distance;
      nearest = static_cast<int>(i);
    }
  }
  return nearest;
}

// An instance that falls past the floor is removed before its speed looks like a physics failure.
void AttemptWorld::Step() {
  physics_.Step();
  for (int i = 0; i < instance_count(); ++i) {
    if (is_static_[i] || is_lost_[i] || physics_.X_WO(i).translation().z() > -lost_below_m_)
      continue;
    physics_.RemoveInstance(i);
    is_lost_[i] = true;
  }
}

int AttemptWorld::Steps(double seconds) const {
  return static_cast<int>(std::lround(seconds / physics_.step_s()));
}

Vector3d AttemptWorld::Center(int position, const Pose& X_WO) const {
  return X_WO * ModelOf(position).mass.com_O;
}

// For a static instance the snapshot is exact; the pose in Bullet went through a frame conversion.
Pose AttemptWorld::PoseOf(int position) const {
  return is_static_[position] ? scene_.objects[position].X_WO : physics_.X_WO(position);
}

Scene AttemptWorld::Remaining(const std::vector<int>& gone) const {
  Scene remaining;
  remaining.bin = scene_.bin;
  for (int i = 0; i < instance_count(); ++i) {
    if (std::find(gone.begin(), gone.end(), i) != gone.end()) continue;
    PosedObject posed = scene_.objects[i];
    posed.X_WO = PoseOf(i);
    if (scene_.bin.Holds(Center(i, posed.X_WO))) remaining.objects.push_back(posed);
  }
  return remaining;
}

int AttemptWorld::Displaced(double distance_m, const std::vector<int>& gone,
                            InstanceId instance) const {
  int displaced = 0;
  for (int i = 0; i < instance_count(); ++i) {
    if (std::find(gone.begin(), gone.end(), i) != gone.end()) continue;
    const PosedObject& before = scene_.objects[i];
    if (before.instance == instance) continue;
    displaced += (Center(i, PoseOf(i)) - Center(i, before.X_WO)).norm() > distance_m;
  }
  return displaced;
}

}  // namespace pickbed::grasp
