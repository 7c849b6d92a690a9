#include "sim/drop/resting_poses.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <sstream>
#include <string>

#include "scenes/base/cache_file.h"
#include "scenes/geometry/decompositions.h"
#include "sim/physics/physics_world.h"

namespace pickbed::sim {
namespace {

using Eigen::Vector3d;

constexpr double kSpacing = 2.5;    // grid pitch in diameters; rolling instances do not meet
constexpr double kDrop = 0.1;       // initial gap below the lowest point, in diameters
constexpr double kMax_s = 8;        // limit of the simulated time
constexpr double kSame_rad = 0.14;  // largest angle between up directions of one resting pose
constexpr double kStillMoving_radps = 0.5;
constexpr int kSymmetrySteps = 72;  // rotations per continuous axis

double LowestPoint(const ObjectModel& model, const Pose& X_WO) {
  double lowest = std::numeric_limits<double>::infinity();
  for (const ConvexPiece& piece : model.convex_pieces_O) {
    for (const Vector3d& p : piece.vertices_O) lowest = std::min(lowest, (X_WO * p).z());
  }
  return lowest;
}

// Returns the smallest angle between `reference` and a symmetric equivalent of `up_O`.
double AngleBetween(const Vector3d& up_O, const Vector3d& reference,
                    const std::vector<Pose>& symmetries) {
  double maximum = -1;
  for (const Pose& S : symmetries) {
    maximum = std::max(maximum, reference.dot(S.linear().transpose() * up_O));
  }
  return std::acos(std::clamp(maximum, -1.0, 1.0));
}

Pose StandingOnPlane(const ObjectModel& model, const Vector3d& up_O) {
  const Eigen::Quaterniond turn = RotationBetween(up_O, Vector3d::UnitZ());
  Pose X_WO = MakePose(turn.toRotationMatrix(), Vector3d::Zero());
  X_WO.translation().z() = -LowestPoint(model, X_WO);
  return X_WO;
}

std::vector<Vector3d> SettledUps(const ObjectModel& model, int drops, uint64_t seed) {
  PhysicsOptions options;
  options.angular_damping = 0.5;
  PhysicsWorld world(options);
  const double pitch_m = kSpacing * model.diameter_m;
  const int side = static_cast<int>(std::ceil(std::sqrt(drops)));
  const double half_m = (side + 4) * pitch_m;
  world.AddStaticBox(Translation({0, 0, -0.5}), {half_m, half_m, 0.5}, model.friction);
  Rng rng = Rng::Derive(seed, 0, "resting poses");
  for (int i = 0; i < drops; ++i) {
    Pose X_WO = MakePose(rng.Rotation().toRotationMatrix(), Vector3d::Zero());
    X_WO.translation() =
        Vector3d((i % side - 0.5 * side) * pitch_m, (i / side - 0.5 * side) * pitch_m,
                 kDrop * model.diameter_m - LowestPoint(model, X_WO));
    world.AddInstance(model, X_WO);
  }
  while (world.time_s() < kMax_s && !world.AllAsleep() && !world.BlewUp()) world.Step();
  std::vector<Vector3d> ups;
  for (int i = 0; i < drops; ++i) {
    if (world.V_WO(i).angular_W.norm() > kStillMoving_radps) continue;
    ups.push_back(world.X_WO(i).linear().row(2).transpose());
  }
  return ups;
}

}  // namespace

std::vector<RestingPose> FindRestingPoses(const ObjectModel& model, int drops, uint64_t seed) {
  const std::vector<Pose> symmetries = SymmetryTransforms(model.symmetries_O, kSymmetrySteps);
  std::vector<RestingPose> poses;
  for (const Vector3d& up_O : SettledUps(model, drops, seed)) {
    const auto same = std::find_if(poses.begin(), poses.end(), [&](const RestingPose& pose) {
      return AngleBetween(up_O, pose.up_O, symmetries) < kSame_rad;
    });
    if (same != poses.end()) {
      same->probability += 1.0 / drops;
    } else {
      poses.push_back({up_O, StandingOnPlane(model, up_O), 1.0 / drops});
    }
  }
  std::stable_sort(poses.begin(), poses.end(), [](const RestingPose& a, const RestingPose& b) {
    return a.probability > b.probability;
  });
  return poses;
}

namespace {

// Increase it whenever the same object would get other directions.
constexpr const char* kVersion = "pickbed resting directions 1\n";

std::filesystem::path CacheFile(const ObjectModel& model) {
  std::string text = kVersion;
  text += fmt::format("{:016x} {} {}", model.mesh_hash, model.friction, model.mass.mass_kg);
  for (const double x : model.mass.com_O) text += fmt::format(" {}", x);
  for (const double x : model.mass.inertia_com_O.reshaped()) text += fmt::format(" {}", x);
  for (const Pose& X : SymmetryTransforms(model.symmetries_O, kSymmetrySteps)) {
    for (const double x : X.linear().reshaped()) text += fmt::format(" {}", x);
  }
  uint64_t hash = HashBytes(text.data(), text.size());
  for (const ConvexPiece& piece : model.convex_pieces_O) {
    hash = HashBytes(piece.vertices_O.data(), piece.vertices_O.size() * sizeof(Vector3d), hash);
  }
  return CacheDir() / "resting" / fmt::format("{:016x}.txt", hash);
}

std::string DirectionsText(const std::vector<RestingDirection>& directions) {
  std::string text;
  for (const RestingDirection& d : directions) {
    text += fmt::format("{} {} {} {}\n", d.up_O.x(), d.up_O.y(), d.up_O.z(), d.probability);
  }
  return text;
}

std::vector<RestingDirection> DirectionsFrom(const std::string& text) {
  std::istringstream in(text);
  std::vector<RestingDirection> directions;
  RestingDirection d;
  while (in >> d.up_O.x() >> d.up_O.y() >> d.up_O.z() >> d.probability) directions.push_back(d);
  CheckInput(in.eof() && text.ends_with('\n'), "a line is cut short");
  for (const RestingDirection& direction : directions) {
    CheckInput(std::abs(direction.up_O.norm() - 1) < 1e-6 && direction.probability > 0 &&
                   direction.probability <= 1,
               "a direction has no unit length, or its probability is not over 0 and up to 1");
  }
  return directions;
}

std::vector<RestingDirection> CachedDirections(const ObjectModel& model) {
  const auto make = [&] {
    std::vector<RestingDirection> directions;
    for (const RestingPose& pose : FindRestingPoses(model)) {
      directions.push_back({pose.up_O, pose.probability});
    }
    return directions;
  };
  return Cached(CacheFile(model), DirectionsFrom, make, DirectionsText);
}

}  // namespace

ObjectSet WithRestingDirections(const ObjectSet& objects) {
  ObjectSet known;
  for (const auto& object : objects) {
    if (!object->resting_O.empty()) {
      known.push_back(object);
      continue;
    }
    auto copy = std::make_shared<ObjectModel>(*object);
    copy->resting_O = CachedDirections(*object);
    known.push_back(std::move(copy));
  }
  return known;
}

}  // namespace pickbed::sim
