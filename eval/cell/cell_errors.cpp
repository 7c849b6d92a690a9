#include "eval/cell/cell_errors.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string_view>

#include "grasp/grippers/requirements.h"
#include "scenes/base/error.h"
#include "scenes/base/math.h"
#include "scenes/base/random.h"
#include "scenes/geometry/triangle_mesh.h"
#include "scenes/objects/scaled_object.h"

namespace pickbed::eval {
namespace {

constexpr double kPercentShare = 0.01, kMillimetre_m = 0.001;

// A stream of limited normal deviates.
class Deviates {
 public:
  Deviates(uint64_t seed, BinIndex bin_index, std::string_view stage)
      : rng_(Rng::Derive(seed, bin_index, stage)) {}

  double One() {
    constexpr double kMax = CellErrorsSpec::kMaxDeviate;
    return std::clamp(rng_.Normal(), -kMax, kMax);
  }
  Eigen::Vector3d Three() {
    const double x = One(), y = One();
    return {x, y, One()};
  }
  // A rotation vector of this standard deviation about a random axis.
  Eigen::Vector3d Rotation_rad(double degrees) {
    const double angle_rad = Radians(degrees) * One();
    return angle_rad * rng_.UnitVector();
  }

 private:
  Rng rng_;
};

Pose PoseOfVectors(const Eigen::Vector3d& p_m, const Eigen::Vector3d& rotation_rad) {
  const double angle_rad = rotation_rad.norm();
  if (angle_rad == 0) return Translation(p_m);
  return MakePose(Eigen::AngleAxisd(angle_rad, rotation_rad / angle_rad).toRotationMatrix(), p_m);
}

}  // namespace

BinErrors DrawBinErrors(const CellErrorsSpec& spec, uint64_t seed, BinIndex bin_index) {
  BinErrors errors;
  if (spec.off()) return errors;
  Deviates hand_eye(seed, bin_index, "cell/hand_eye");
  errors.hand_eye_m = spec.hand_eye_mm * kMillimetre_m * hand_eye.Three();
  errors.hand_eye_rotation_rad = hand_eye.Rotation_rad(spec.hand_eye_deg);
  Deviates intrinsics(seed, bin_index, "cell/intrinsics");
  errors.focal = spec.focal_percent * kPercentShare * intrinsics.One();
  errors.principal_px = spec.principal_px * intrinsics.Three().head<2>();
  Deviates depth(seed, bin_index, "cell/depth");
  errors.depth_bias_m = spec.depth_bias_mm * kMillimetre_m * depth.One();
  errors.depth_scale = spec.depth_scale_percent * kPercentShare * depth.One();
  Deviates bin(seed, bin_index, "cell/bin");
  errors.bin_m = spec.bin_mm * kMillimetre_m * bin.Three();
  errors.bin_rotation_rad = bin.Rotation_rad(spec.bin_deg);
  return errors;
}

AttemptErrors DrawAttemptErrors(const CellErrorsSpec& spec, uint64_t seed, BinIndex bin_index,
                                int attempt) {
  AttemptErrors errors;
  if (spec.off()) return errors;
  Deviates robot(seed, bin_index, fmt::format("cell/robot/{}", attempt));
  errors.robot_m = spec.repeatability_mm * kMillimetre_m * robot.Three();
  Deviates force(seed, bin_index, fmt::format("cell/force/{}", attempt));
  errors.force = spec.force_percent * kPercentShare * force.One();
  return errors;
}

InstanceDeviation DrawDeviation(const CellErrorsSpec& spec, uint64_t seed, BinIndex bin_index,
                                InstanceId instance) {
  InstanceDeviation deviation;
  if (spec.off()) return deviation;
  Deviates own(seed, bin_index, fmt::format("cell/instance/{}", static_cast<int>(instance)));
  deviation.friction = spec.friction_percent * kPercentShare * own.One();
  deviation.mass = spec.mass_percent * kPercentShare * own.One();
  return deviation;
}

std::vector<double> DrawSizes(const CellErrorsSpec& spec, uint64_t seed, BinIndex bin_index,
                              size_t objects) {
  std::vector<double> sizes(objects, 0);
  if (spec.size_percent == 0) return sizes;
  Deviates deviates(seed, bin_index, "cell/size");
  for (double& size : sizes) size = spec.size_percent * kPercentShare * deviates.One();
  return sizes;
}

ObjectSet ObjectsOfSizes(const ObjectSet& objects, const std::vector<double>& sizes) {
  ObjectSet true_objects = objects;
  for (size_t i = 0; i < objects.size(); ++i) {
    if (sizes.at(i) == 0) continue;
    true_objects[i] = std::make_shared<ObjectModel>(ScaledObject(*objects[i], 1 + sizes[i]));
  }
  return true_objects;
}

void RequireSizesFit(const ScenarioSpec& spec, const ObjectSet& objects, const Tools& tools) {
  if (spec.cell.size_percent == 0) return;
  std::vector<double> largest(objects.size(), 0);
  std::vector<int> bins(objects.size(), 0);
  for (int bin = 0; bin < spec.trials; ++bin) {
    const std::vector<double> sizes =
        DrawSizes(spec.cell, spec.seed, BinIndex(bin), objects.size());
    for (size_t i = 0; i < sizes.size(); ++i) {
      if (sizes[i] <= largest[i]) continue;
      largest[i] = sizes[i];
      bins[i] = bin;
    }
  }
  const Eigen::Vector2d inner_m = spec.bin.inner_size_m.head<2>();
  for (size_t i = 0; i < objects.size(); ++i) {
    const double factor = 1 + largest[i];
    const auto require = [&](bool fits, const std::string& fault) {
      CheckInput(fits, fmt::format("{} = {}: in bin {}, object '{}' is {:.1f} % larger than its "
                                   "model and {}; lower it, or use a larger bin or gripper",
                                   spec.At("cell.size_percent"), spec.cell.size_percent, bins[i],
                                   objects[i]->name, 100 * largest[i], fault));
    };
    Eigen::Vector3d size_m = factor * MeshBounds(objects[i]->mesh_O).size();
    std::sort(size_m.data(), size_m.data() + 3);
    require(size_m[1] <= inner_m.minCoeff() && size_m[2] <= inner_m.maxCoeff(),
            fmt::format("does not fit into the bin of {:.0f} x {:.0f} mm", 1e3 * inner_m.x(),
                        1e3 * inner_m.y()));
    if (spec.objects[i].distractor) continue;
    const double mass_kg = objects[i]->mass.mass_kg * std::pow(factor, 3);
    const bool any_carries = std::any_of(tools.begin(), tools.end(), [&](const auto& tool) {
      return CanCarry(*tool, mass_kg, objects[i]->friction);
    });
    require(any_carries, fmt::format("weighs {:.3g} kg, which no gripper carries", mass_kg));
  }
}

Pose CellCalibration::X_BD() const {
  return X_WB ? X_WB->inverse() * camera.X_WC() : camera.X_WC();
}

KnownBackground CellCalibration::Background(const Bin& bin) const {
  return {bin, X_WB ? camera.X_CW() * *X_WB : camera.X_CW()};
}

CellCalibration CalibrationOf(const Camera& camera, const BinErrors& errors) {
  CellCalibration calibration{camera, std::nullopt};
  const CameraIntrinsics& k = camera.intrinsics;
  if (errors.focal != 0 || !errors.principal_px.isZero(0)) {
    calibration.camera.intrinsics = {k.width(),
                                     k.height(),
                                     k.fx() * (1 + errors.focal),
                                     k.fy() * (1 + errors.focal),
                                     k.cx() + errors.principal_px.x(),
                                     k.cy() + errors.principal_px.y()};
  }
  if (!errors.hand_eye_m.isZero(0) || !errors.hand_eye_rotation_rad.isZero(0)) {
    calibration.camera.SetPose(camera.X_WC() *
                               PoseOfVectors(errors.hand_eye_m, errors.hand_eye_rotation_rad));
  }
  if (!errors.bin_m.isZero(0) || !errors.bin_rotation_rad.isZero(0)) {
    calibration.X_WB = PoseOfVectors(errors.bin_m, errors.bin_rotation_rad);
  }
  return calibration;
}

void AddDepthErrors(const BinErrors& errors, Image<float>& depth_m) {
  if (errors.depth_bias_m == 0 && errors.depth_scale == 0) return;
  for (float& depth : depth_m.pixels()) {
    if (depth <= 0) continue;
    const double read_m = depth * (1 + errors.depth_scale) + errors.depth_bias_m;
    depth = static_cast<float>(std::max(0.0, read_m));
  }
}

Pose PoseInImage(const Pose& X_CO, const Eigen::Vector3d& p_O, const CameraIntrinsics& intrinsics,
                 const CameraIntrinsics& calibrated, const BinErrors& errors) {
  const bool exact =
      intrinsics == calibrated && errors.depth_bias_m == 0 && errors.depth_scale == 0;
  if (exact) return X_CO;
  const Eigen::Vector3d true_C = X_CO * p_O;
  const Eigen::Vector2d pixel = Project(intrinsics, true_C);
  const double depth_m = true_C.z() * (1 + errors.depth_scale) + errors.depth_bias_m;
  const Eigen::Vector3d seen_C = BackProject(calibrated, pixel.x(), pixel.y(), depth_m);
  return Translation(seen_C - true_C) * X_CO;
}

ExecuteResult ExecuteWithErrors(const TrueScene& truth, const Grasp& planned,
                                const Gripper& gripper, const GraspTarget& target,
                                const ExecuteOptions& options, const AttemptErrors& errors,
                                const MotionListener& on_step) {
  Grasp executed = planned;
  executed.X_WG.translation() += errors.robot_m;
  GraspTarget assumed = target;
  assumed.planned_X_WG = planned.X_WG;
  const auto with_force = errors.force == 0 ? nullptr : gripper.WithForce(1 + errors.force);
  return ExecuteGrasp(truth.scene, truth.objects, executed, with_force ? *with_force : gripper,
                      assumed, options, on_step);
}

}  // namespace pickbed::eval
