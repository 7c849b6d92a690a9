#include "scenes/geometry/mass_properties.h"

#include <cmath>

#include "scenes/base/error.h"

namespace pickbed::scenes {
namespace {

// Integrals of 1, x and x x^T over the solid.
struct Moments {
  double volume = 0;
  Eigen::Vector3d first = Eigen::Vector3d::Zero();
  Eigen::Matrix3d second = Eigen::Matrix3d::Zero();
};

// Sums over the signed tetrahedra of `origin` and each triangle, relative to `origin`. With the
// determinant det of the corners (a, b, c) and s = a + b + c, the integrals over the tetrahedron
// (0, a, b, c) are det / 6, det / 24 s and det / 120 (a a^T + b b^T + c c^T + s s^T).
Moments SolidMoments(const TriangleMesh& mesh, const Eigen::Vector3d& origin) {
  Moments moments;
  for (const Eigen::Vector3i& t : mesh.triangles) {
    Eigen::Matrix3d corners;
    for (int k = 0; k < 3; ++k) corners.col(k) = mesh.vertices[t[k]] - origin;
    const double det = corners.determinant();
    const Eigen::Vector3d sum = corners.rowwise().sum();
    moments.volume += det / 6;
    moments.first += det / 24 * sum;
    moments.second += det / 120 * (corners * corners.transpose() + sum * sum.transpose());
  }
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
