#include "sim/drop/certified_scene.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "scenes/base/error.h"
#include "scenes/base/ids_format.h"
#include "sim/drop/drop_layout.h"
#include "sim/drop/penetration.h"

namespace pickbed::sim {

namespace {

Movement MovementSince(const Scene& scene, const ObjectSet& objects, const PhysicsWorld& world,
                       const std::vector<Eigen::AlignedBox3d>& boxes_O) {
  Movement movement;
  for (size_t i = 0; i < scene.objects.size(); ++i) {
    const PosedObject& posed = scene.objects[i];
    movement.Include(boxes_O[posed.object], objects[posed.object]->diameter_m, posed.X_WO,
                     world.X_WO(static_cast<int>(i)));
  }
  return movement;
}

}  // namespace

PhysicsOptions PhysicsFor(const ObjectSet& objects, PhysicsOptions physics) {
  constexpr double kFullSize_m = 0.04;
  double size = 1;
  for (const auto& object : objects) size = std::min(size, object->diameter_m / kFullSize_m);
  physics.rate_hz /= std::sqrt(size);
  physics.contact_reuse_m *= size;
  physics.still_m *= size;
  return physics;
}

// The center of the box may be far from the origin of O.
void Movement::Include(const Eigen::AlignedBox3d& box_O, double diameter_m, const Pose& before_X_WO,
                       const Pose& after_X_WO) {
  const double moved_m =
      (after_X_WO * box_O.center() - before_X_WO * box_O.center()).norm() +
      0.5 * box_O.diagonal().norm() * RotationAngleRad(after_X_WO.linear(), before_X_WO.linear());
  m = std::max(m, moved_m);
  diameters = std::max(diameters, moved_m / diameter_m);
}

SceneCertificate CertifyRest(const Scene& scene, const ObjectSet& objects,
                             const DropOptions& options) {
  PhysicsWorld world(PhysicsFor(objects, options.physics));
  world.AddBin(scene.bin);
  for (const PosedObject& posed : scene.objects)
    world.AddInstance(*objects[posed.object], posed.X_WO);
  world.ForbidSleep();
  std::vector<Eigen::AlignedBox3d> boxes_O;
  for (const auto& object : objects) {
    boxes_O.push_back(RotatedBox(*object, Eigen::Matrix3d::Identity()));
  }

  Movement movement;
  const auto at_rest = [&] {
    const Movement now = MovementSince(scene, objects, world, boxes_O);
    movement.m = std::max(movement.m, now.m);
    movement.diameters = std::max(movement.diameters, now.diameters);
    return movement.diameters <= options.wake_diameters;
  };
  SceneCertificate certificate;
  certificate.at_rest = true;
  while (certificate.at_rest && !world.BlewUp() && world.time_s() < options.wake_s) {
    const double next_s = std::min(options.wake_s, world.time_s() + options.check_interval_s);
    while (world.time_s() < next_s) world.Step();
    certificate.at_rest = at_rest();
  }
  certificate.simulated_s = world.time_s();
  certificate.blew_up = world.BlewUp();
  certificate.wake_movement_m = movement.m;
  certificate.wake_movement_diameters = movement.diameters;
  for (size_t i = 0; i < scene.objects.size(); ++i) {
    const PosedObject& posed = scene.objects[i];
    const Twist V_WO = world.V_WO(static_cast<int>(i));
    certificate.max_speed_mps = std::max(certificate.max_speed_mps, V_WO.linear_W.norm());
    certificate.max_spin_radps = std::max(certificate.max_spin_radps, V_WO.angular_W.norm());
    const Eigen::Vector3d center_W = posed.X_WO * objects[posed.object]->mass.com_O;
    certificate.instances_outside += !scene.bin.Holds(center_W);
  }
  certificate.deepest_penetration_m = DeepestPenetration(scene, objects);
  return certificate;
}

SceneSamples TryScene(const SceneRequest& request, const DropOptions& options, int max_attempts) {
  SceneSamples samples;
  for (int attempt = 0; attempt < max_attempts; ++attempt) {
    const std::string stage =
        attempt == 0 ? request.stage : fmt::format("{}/{}", request.stage, attempt);
    Rng rng = Rng::Derive(request.seed, request.bin_index, stage);
    DropResult drop = DropInstances(request.bin, request.objects, request.counts, rng, options);
    std::vector<std::string> faults = Faults(drop.certificate);
    if (faults.empty()) {
      samples.made = {std::move(drop.scene), std::move(drop.certificate), samples.refused};
      return samples;
    }
    samples.refused.push_back({attempt, std::move(faults)});
  }
  return samples;
}

CertifiedScene MakeScene(const SceneRequest& request, const DropOptions& options,
                         int max_attempts) {
  SceneSamples samples = TryScene(request, options, max_attempts);
  if (samples.made) return *std::move(samples.made);
  throw InputError(
      fmt::format("trial {}: {} scenes in a row were refused, the last because {}; drop fewer "
                  "objects, lower the fill or use a larger bin",
                  request.bin_index, max_attempts, fmt::join(samples.refused.back().faults, ", ")));
}

}  // namespace pickbed::sim
