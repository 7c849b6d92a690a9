#include "sim/drop/drop_layout.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "scenes/base/error.h"
#include "scenes/geometry/decompositions.h"

namespace pickbed::sim {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

// Returns the axes of O ordered by the object's extent. Index 0 is the longest.
std::array<int, 3> AxesByExtent(const Vector3d& size) {
  std::array<int, 3> axes{0, 1, 2};
  std::stable_sort(axes.begin(), axes.end(), [&](int a, int b) { return size[a] > size[b]; });
  return axes;
}

// The longest axis is parallel to the bin's longer side, the second longest to its shorter side.
Eigen::Matrix3d LyingFlat(const ObjectModel& model, const Bin& bin) {
  const Vector3d size = RotatedBox(model, Eigen::Matrix3d::Identity()).sizes();
  const auto [longest, medium, shortest] = AxesByExtent(size);
  const bool x_is_longer = bin.inner_size_m.x() >= bin.inner_size_m.y();
  const Vector3d along = x_is_longer ? Vector3d::UnitX() : Vector3d::UnitY();
  const Vector3d across = x_is_longer ? Vector3d::UnitY() : Vector3d::UnitX();
  Eigen::Matrix3d R_WO;
  R_WO.col(longest) = along;
  R_WO.col(medium) = across;
  R_WO.col(shortest) = Vector3d::Zero();
  R_WO.col(shortest) = R_WO.col((shortest + 1) % 3).cross(R_WO.col((shortest + 2) % 3));
  return R_WO;
}

// Rotates the resting direction nearest to O's z up, then applies `yaw_rad` about the vertical.
RotatedObject Upright(const ObjectModel& model, ObjectId object, double yaw_rad) {
  Vector3d up_O = Vector3d::UnitZ();
  double maximum = -2;
  for (const RestingDirection& resting : model.resting_O) {
    if (resting.up_O.z() <= maximum) continue;
    maximum = resting.up_O.z();
    up_O = resting.up_O;
  }
  const Eigen::Matrix3d R_up = RotationBetween(up_O, Vector3d::UnitZ()).toRotationMatrix();
  const Eigen::Matrix3d R_WO = Eigen::AngleAxisd(yaw_rad, Vector3d::UnitZ()) * R_up;
  return {object, R_WO, RotatedBox(model, R_WO)};
}

}  // namespace

Eigen::AlignedBox3d RotatedBox(const ObjectModel& model, const Eigen::Matrix3d& R_WO) {
  Eigen::AlignedBox3d box;
  for (const ConvexPiece& piece : model.convex_pieces_O) {
    for (const Vector3d& p_O : piece.vertices_O) box.extend(Vector3d(R_WO * p_O));
  }
  return box;
}

void RequireFits(const ObjectModel& model, const Bin& bin) {
  const Vector3d size = RotatedBox(model, Eigen::Matrix3d::Identity()).sizes();
  const auto [longest, medium, shortest] = AxesByExtent(size);
  const Vector2d inner = bin.inner_size_m.head<2>();
  if (size[longest] <= inner.maxCoeff() && size[medium] <= inner.minCoeff()) return;
  throw InputError(
      fmt::format("object '{}' is {:.3f} x {:.3f} x {:.3f} m and does not fit into the bin's "
                  "{:.3f} x {:.3f} m floor: use a larger bin or check the mesh's unit",
                  model.name, size[longest], size[medium], size[shortest], inner.x(), inner.y()));
}

RotatedObject TurnAtRandom(const ObjectSet& objects, ObjectId object, const Bin& bin,
                           double clearance_m, int attempts, Rng& rng) {
  const ObjectModel& model = *objects[object];
  const Vector2d room = bin.inner_size_m.head<2>() - Vector2d::Constant(2 * clearance_m);
  for (int attempt = 0; attempt < attempts; ++attempt) {
    const Eigen::Matrix3d R_WO = rng.Rotation().toRotationMatrix();
    const Eigen::AlignedBox3d box = RotatedBox(model, R_WO);
    if ((box.sizes().head<2>().array() <= room.array()).all()) return {object, R_WO, box};
  }
  const Eigen::Matrix3d R_WO = LyingFlat(model, bin);
  return {object, R_WO, RotatedBox(model, R_WO)};
}

std::vector<Cell> PackLayer(const std::vector<RotatedObject>& instances, size_t first,
                            const Bin& bin, double clearance_m) {
  const Vector2d inner = bin.inner_size_m.head<2>();
  std::vector<Cell> cells;
  double x = clearance_m, y = clearance_m, row_depth = 0;
  for (size_t i = first; i < instances.size(); ++i) {
    const Vector2d size = instances[i].box.sizes().head<2>() + Vector2d::Constant(clearance_m);
    if (x + size.x() > inner.x()) {
      x = clearance_m;
      y += row_depth;
      row_depth = 0;
    }
    if (!cells.empty() && y + size.y() > inner.y()) break;
    cells.push_back({&instances[i], {x, y}});
    x += size.x();
    row_depth = std::max(row_depth, size.y());
  }
  return cells;
}

std::vector<PlacedInstance> PlaceUpright(const ObjectSet& objects,
                                         const std::vector<ObjectId>& kinds, const Bin& bin,
                                         double clearance_m, int attempts, Rng& rng) {
  std::vector<RotatedObject> instances;
  for (const ObjectId kind : kinds) {
    instances.push_back(Upright(*objects[kind], kind, 2 * std::numbers::pi * rng.Uniform()));
  }
  const auto footprint_m2 = [](const RotatedObject& instance) {
    return instance.box.sizes().head<2>().prod();
  };
  std::stable_sort(instances.begin(), instances.end(),
                   [&](const RotatedObject& a, const RotatedObject& b) {
                     return footprint_m2(a) > footprint_m2(b);
                   });
  const Vector2d inner = bin.inner_size_m.head<2>();
  std::vector<Eigen::AlignedBox2d> taken;
  std::vector<PlacedInstance> placed;
  for (const RotatedObject& instance : instances) {
    const Vector2d size = instance.box.sizes().head<2>();
    const Vector2d room = inner - size - Vector2d::Constant(2 * clearance_m);
    if ((room.array() < 0).any()) continue;
    for (int attempt = 0; attempt < attempts; ++attempt) {
      const Vector2d low = Vector2d(rng.Uniform() * room.x(), rng.Uniform() * room.y()) -
                           0.5 * inner + Vector2d::Constant(clearance_m);
      const Eigen::AlignedBox2d box(low - Vector2d::Constant(clearance_m), low + size);
      const bool free = std::none_of(taken.begin(), taken.end(),
                                     [&](const auto& other) { return other.intersects(box); });
      if (!free) continue;
      taken.push_back(box);
      const Vector3d p_WO = Vector3d(low.x(), low.y(), clearance_m) - instance.box.min();
      placed.push_back({instance.object, MakePose(instance.R_WO, p_WO)});
      break;
    }
  }
  return placed;
}

}  // namespace pickbed::sim
