#include "scenes/geometry/mass_properties.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "scenes/base/error.h"

namespace pickbed::scenes {
namespace {

// Triangles are processed in blocks of plain arrays, one lane per triangle.
constexpr int kTriangleLanes = 64;
using TriangleLanes = std::array<double, kTriangleLanes>;

// The integrals of 1, x and x x^T over a solid. Products of different coordinates are listed in
// both orders, because the sums of the two are rounded differently.
enum Moment { k1, kX, kY, kZ, kXX, kXY, kXZ, kYY, kYZ, kZX, kZY, kZZ, kMoments };

struct Moments {
  double volume = 0;
  Eigen::Vector3d first = Eigen::Vector3d::Zero();
  Eigen::Matrix3d second = Eigen::Matrix3d::Zero();
};

// Computes the integrals over the tetrahedra of the origin and the triangles with the corners a, b
// and c. With their determinant det and s = a + b + c, these are det / 6, det / 24 s and
// det / 120 (a a^T + b b^T + c c^T + s s^T).
__attribute__((target_clones("avx2", "default"))) void TetrahedronMoments(
    const std::array<TriangleLanes, 9>& corners, std::array<TriangleLanes, kMoments>& out) {
  for (int i = 0; i < kTriangleLanes; ++i) {
    const double ax = corners[0][i], ay = corners[1][i], az = corners[2][i];
    const double bx = corners[3][i], by = corners[4][i], bz = corners[5][i];
    const double cx = corners[6][i], cy = corners[7][i], cz = corners[8][i];
    const double det =
        ax * (by * cz - cy * bz) - bx * (ay * cz - cy * az) + cx * (ay * bz - by * az);
    const double sx = ax + (bx + cx), sy = ay + (by + cy), sz = az + (bz + cz);
    const double f = det / 24, g = det / 120;
    out[k1][i] = det / 6;
    out[kX][i] = f * sx;
    out[kY][i] = f * sy;
    out[kZ][i] = f * sz;
    out[kXX][i] = g * (ax * ax + bx * bx + cx * cx + sx * sx);
    out[kXY][i] = g * (ax * ay + bx * by + cx * cy + sx * sy);
    out[kXZ][i] = g * (ax * az + bx * bz + cx * cz + sx * sz);
    out[kYY][i] = g * (ay * ay + by * by + cy * cy + sy * sy);
    out[kYZ][i] = g * (ay * az + by * bz + cy * cz + sy * sz);
    out[kZX][i] = g * (ax * az + (bx * bz + cx * cz) + sx * sz);
    out[kZY][i] = g * (ay * az + (by * bz + cy * cz) + sy * sz);
    out[kZZ][i] = g * (az * az + (bz * bz + cz * cz) + sz * sz);
  }
}

// Sums over the signed tetrahedra of `origin` and each triangle, relative to `origin`.
Moments SolidMoments(const TriangleMesh& mesh, const Eigen::Vector3d& origin) {
  std::array<TriangleLanes, 9> corners = {};
  std::array<TriangleLanes, kMoments> terms;
  std::array<double, kMoments> m = {};
  for (size_t begin = 0; begin < mesh.triangles.size(); begin += kTriangleLanes) {
    const int count =
        static_cast<int>(std::min<size_t>(kTriangleLanes, mesh.triangles.size() - begin));
    for (int i = 0; i < count; ++i) {
      const Eigen::Vector3i& t = mesh.triangles[begin + i];
      for (int k = 0; k < 9; ++k) corners[k][i] = mesh.vertices[t[k / 3]][k % 3] - origin[k % 3];
    }
    TetrahedronMoments(corners, terms);
    for (int i = 0; i < count; ++i) {
      for (int k = 0; k < kMoments; ++k) m[k] += terms[k][i];
    }
  }
  Moments moments{m[k1], {m[kX], m[kY], m[kZ]}, {}};
  moments.second << m[kXX], m[kXY], m[kXZ], m[kXY], m[kYY], m[kYZ], m[kZX], m[kZY], m[kZZ];
  return moments;
}

}  // namespace

MassProperties UniformMassProperties(const TriangleMesh& closed_mesh, double mass_kg) {
  CheckInput(std::isfinite(mass_kg) && mass_kg > 0,
             "a mass of " + std::to_string(mass_kg) + " kg is not positive; give one above 0");
  // The moments are taken about the center of the mesh. About a far origin they would cancel.
  const Bounds bounds = MeshBounds(closed_mesh);
  const Eigen::Vector3d center = bounds.center();
  const Moments moments = SolidMoments(closed_mesh, center);
  CheckInput(moments.volume > kFlatVolumeRatio * std::pow(bounds.size().norm(), 3),
             "the mesh encloses no positive volume; close it and orient its faces outwards");
  const Eigen::Vector3d com = moments.first / moments.volume;
  const Eigen::Matrix3d covariance = moments.second / moments.volume - com * com.transpose();
  MassProperties properties;
  properties.mass_kg = mass_kg;
  properties.volume_m3 = moments.volume;
  properties.com_O = center + com;
  properties.inertia_com_O =
      mass_kg * (covariance.trace() * Eigen::Matrix3d::Identity() - covariance);
  return properties;
}

MassProperties UniformDensityProperties(const TriangleMesh& closed_mesh, double density_kgpm3) {
  CheckInput(
      std::isfinite(density_kgpm3) && density_kgpm3 > 0,
      "a density of " + std::to_string(density_kgpm3) + " kg/m3 is not positive; give one above 0");
  MassProperties properties = UniformMassProperties(closed_mesh, 1.0);
  properties.mass_kg = density_kgpm3 * properties.volume_m3;
  properties.inertia_com_O *= properties.mass_kg;
  return properties;
}

}  // namespace pickbed::scenes
