#include "scenes/shape_families/solid_shape.h"

#include <algorithm>
#include <array>
#include <limits>
#include <type_traits>

#include "scenes/base/random.h"

namespace pickbed::scenes {
namespace {

template <typename T>
uint64_t HashOf(const std::vector<T>& items, uint64_t seed) {
  return HashBytes(items.data(), items.size() * sizeof(T), seed);
}

}  // namespace

SolidShape::SolidShape(SolidProgram program, const Eigen::AlignedBox3f& box_P, float min_wall_mm)
    : program_(std::move(program)), center_mm_(box_P.center()), min_wall_mm_(min_wall_mm) {
  const Eigen::Vector3f half_m = 0.5e-3f * box_P.sizes();
  box_O_ = Eigen::AlignedBox3f(-half_m, half_m);
}

void SolidShape::SignedDistances_m(std::span<const Eigen::Vector3f> points_O,
                                   std::span<float> distances_m) const {
  if (program_.instructions.empty()) {
    std::fill(distances_m.begin(), distances_m.end(), std::numeric_limits<float>::infinity());
    return;
  }
  RunSolidProgram(program_, center_mm_, points_O, distances_m);
  for (float& distance : distances_m) distance *= 1e-3f;
}

float SolidShape::SignedDistance_m(const Eigen::Vector3f& p_O) const {
  float distance = 0;
  SignedDistances_m({&p_O, 1}, {&distance, 1});
  return distance;
}

std::vector<Eigen::Vector3f> SolidShape::Normals(std::span<const Eigen::Vector3f> points_O,
                                                 float step_m) const {
  std::vector<Eigen::Vector3f> around;
  for (const Eigen::Vector3f& p : points_O) {
    for (int k = 0; k < 6; ++k) {
      around.push_back(p + (k % 2 ? -step_m : step_m) * Eigen::Vector3f::Unit(k / 2));
    }
  }
  std::vector<float> d(around.size());
  SignedDistances_m(around, d);
  std::vector<Eigen::Vector3f> normals;
  for (size_t i = 0; i < d.size(); i += 6) {
    const Eigen::Vector3f slope(d[i] - d[i + 1], d[i + 2] - d[i + 3], d[i + 4] - d[i + 5]);
    normals.push_back(slope.stableNormalized());
  }
  return normals;
}

uint64_t SolidShape::hash() const {
  uint64_t hash = HashBytes(center_mm_.data(), sizeof(center_mm_));
  for (const SolidInstruction& op : program_.instructions) {
    const std::array<int32_t, 3> head{static_cast<int32_t>(op.op), op.first, op.count};
    hash = HashBytes(head.data(), sizeof(head), hash);
    hash = HashBytes(op.R.data(), sizeof(op.R), hash);
    hash = HashBytes(op.t.data(), sizeof(op.t), hash);
    hash = HashBytes(op.v.data(), sizeof(op.v), hash);
  }
  return HashOf(program_.planes, HashOf(program_.outlines, hash));
}

}  // namespace pickbed::scenes
