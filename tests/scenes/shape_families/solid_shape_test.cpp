#include "scenes/shape_families/solid_shape.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <numbers>

#include "scenes/base/error.h"
#include "scenes/base/random.h"
#include "scenes/shape_families/solid_bounds.h"
#include "scenes/shape_families/solid_builder.h"
#include "scenes/shape_families/solid_program.h"
#include "tests/support/error_of.h"

// The programs of solid_program.cpp against occupancy written down independently, one primitive and
// one combination at a time.

namespace pickbed::tests {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3f;

// A solid whose bounding box is centered at the origin, and its occupancy at a point in mm.
struct OccupancyCase {
  const char* name;
  Solid solid;
  std::function<bool(const Vector3d&)> contains;
  Vector3d half_mm;  // of the bounding box
};

double Radius(const Vector3d& p) { return std::hypot(p.x(), p.y()); }

bool InBox(const Vector3d& p, const Vector3d& half) { return (p.cwiseAbs() - half).maxCoeff() < 0; }

std::vector<OccupancyCase> OccupancyCases() {
  const auto in_hexagon = [](const Vector3d& p) {
    const Vector3d q = p.cwiseAbs();
    return std::max(q.x(), 0.5 * q.x() + 0.5 * std::sqrt(3.0) * q.y()) < 15;
  };
  return {
      {"box",
       Box({20, 40, 60}),
       [](const Vector3d& p) {
         return InBox(p, {10, 20, 30});
       },
       {10, 20, 30}},
      {"cylinder",
       Cylinder(20, 50),
       [](const Vector3d& p) { return Radius(p) < 20 && std::abs(p.z()) < 25; },
       {20, 20, 25}},
      {"frustum",
       Frustum(10, 30, 40),
       [](const Vector3d& p) { return Radius(p) < 20 + 0.5 * p.z() && std::abs(p.z()) < 20; },
       {30, 30, 20}},
      {"capsule",
       Capsule(10, 30),
       [](const Vector3d& p) {
         return std::hypot(Radius(p), std::max(std::abs(p.z()) - 15, 0.0)) < 10;
       },
       {10, 10, 25}},
      {"torus",
       Torus(30, 8),
       [](const Vector3d& p) { return std::hypot(Radius(p) - 30, p.z()) < 8; },
       {38, 38, 8}},
      {"ellipsoid",
       Superquadric({10, 20, 30}, 1, 1),
       [](const Vector3d& p) { return p.cwiseQuotient(Vector3d(10, 20, 30)).squaredNorm() < 1; },
       {10, 20, 30}},
      {"octahedron",
       Superquadric({20, 20, 30}, 1.9, 1.9),
       [](const Vector3d& p) {
         const Vector3d q = p.cwiseAbs().cwiseQuotient(Vector3d(20, 20, 30));
         const double n = 2 / 1.9;
         return std::pow(q.x(), n) + std::pow(q.y(), n) + std::pow(q.z(), n) < 1;
       },
       {20, 20, 30}},
      {"boxlike superquadric",
       Superquadric({20, 10, 30}, 0.2, 0.4),
       [](const Vector3d& p) {
         const Vector3d q = p.cwiseAbs().cwiseQuotient(Vector3d(20, 10, 30));
         const double section = std::pow(q.x(), 10) + std::pow(q.y(), 10);
         return std::pow(section, 0.5) + std::pow(q.z(), 5) < 1;
       },
       {20, 10, 30}},
      {"L profile",
       Moved(Extruded({{0, 0}, {30, 0}, {30, 10}, {10, 10}, {10, 20}, {0, 20}}, 40), {-15, -10, 0}),
       [](const Vector3d& p) {
         const double x = p.x() + 15, y = p.y() + 10;
         return std::abs(p.z()) < 20 && x > 0 && y > 0 &&
                ((x < 30 && y < 10) || (x < 10 && y < 20));
       },
       {15, 10, 20}},
      {"hexagonal prism",
       RegularPrism(6, 30, 20),
       [in_hexagon](const Vector3d& p) { return in_hexagon(p) && std::abs(p.z()) < 10; },
       {15, 15 / std::cos(std::numbers::pi / 6), 10}},
      {"half torus",
       Union(Bend(30, 8, 180), Moved(Sphere(1), {-30, 0, 0})),
       [](const Vector3d& p) {
         return (p.x() > 0 && std::hypot(Radius(p) - 30, p.z()) < 8) ||
                (p + Vector3d(30, 0, 0)).norm() < 1;
       },
       {0, 38, 8}},
      {"cut",
       Cut(Box({40, 40, 40}), Cylinder(15, 50)),
       [](const Vector3d& p) {
         return InBox(p, {20, 20, 20}) && Radius(p) > 15;
       },
       {20, 20, 20}},
      {"turned box",
       Turned(Box({20, 20, 60}), Vector3d::UnitX(), 90),
       [](const Vector3d& p) {
         return InBox(p, {10, 30, 10});
       },
       {10, 30, 10}},
      {"five posts",
       Copies(Moved(Cylinder(4, 20), {20, 0, 0}), 5),
       [](const Vector3d& p) {
         for (int k = 0; k < 5; ++k) {
           const double a = 2 * std::numbers::pi * k / 5;
           const Vector3d center(20 * std::cos(a), 20 * std::sin(a), p.z());
           if (std::abs(p.z()) < 10 && (p - center).norm() < 4) return true;
         }
         return false;
       },
       {0, 20 * std::sin(0.4 * std::numbers::pi) + 4, 10}},
      {"mirrored",
       Mirrored(Moved(Box({10, 10, 10}), {20, 0, 30}), true, false, true),
       [](const Vector3d& p) {
         return InBox(Vector3d(std::abs(p.x()) - 20, p.y(), std::abs(p.z()) - 30), {5, 5, 5});
       },
       {25, 5, 35}},
      {"shell",
       Shelled(Sphere(30), 3),
       [](const Vector3d& p) { return p.norm() < 30 && p.norm() > 27; },
       {30, 30, 30}},
      {"grown",
       Grown(Sphere(20), 5),
       [](const Vector3d& p) { return p.norm() < 25; },
       {25, 25, 25}},
  };
}

TEST(SolidShape, HasTheOccupancyOfItsFormula) {
  for (const OccupancyCase& c : OccupancyCases()) {
    SCOPED_TRACE(c.name);
    const SolidShape shape = CompiledSolid(c.solid, 2);
    Rng rng(1);
    // The two solids that are not centered in x are shifted by the center of their box.
    const bool centered = c.half_mm.x() > 0;
    const double shift = centered ? 0 : 1e3 * shape.box_O().sizes().x() / 2;
    int inside = 0;
    for (int i = 0; i < 4000; ++i) {
      Vector3d p_mm(rng.Uniform(-1, 1), rng.Uniform(-1, 1), rng.Uniform(-1, 1));
      p_mm = 1.2 * p_mm.cwiseProduct(centered ? c.half_mm
                                              : Vector3d(shift, c.half_mm.y(), c.half_mm.z()));
      const float d_mm = 1e3f * shape.SignedDistance_m((1e-3 * p_mm).cast<float>());
      if (std::abs(d_mm) < 0.05f) continue;
      Vector3d formula_mm = p_mm;
      if (!centered) formula_mm.x() += (c.name[0] == 'h' ? 38 : 24) - shift;
      EXPECT_EQ(d_mm < 0, c.contains(formula_mm)) << p_mm.transpose() << " mm";
      inside += d_mm < 0;
    }
    EXPECT_GT(inside, 40);
  }
}

TEST(SolidShape, BoxIsTight) {
  for (const OccupancyCase& c : OccupancyCases()) {
    const Eigen::AlignedBox3f box = CompiledSolid(c.solid, 2).box_O();
    for (int axis = c.half_mm.x() > 0 ? 0 : 1; axis < 3; ++axis) {
      EXPECT_NEAR(1e3 * box.max()[axis], c.half_mm[axis], 0.1) << c.name << " axis " << axis;
    }
    EXPECT_NEAR(box.center().norm(), 0, 1e-6) << c.name;
  }
}

TEST(SolidShape, ChangesByAtMostTheDistance) {
  Rng rng(2);
  for (const OccupancyCase& c : OccupancyCases()) {
    const SolidShape shape = CompiledSolid(c.solid, 2);
    const float half = 0.7f * shape.box_O().sizes().maxCoeff();
    for (int i = 0; i < 3000; ++i) {
      const Vector3f p =
          half * Vector3d(rng.Uniform(-1, 1), rng.Uniform(-1, 1), rng.Uniform(-1, 1)).cast<float>();
      const float step = static_cast<float>(rng.Uniform(1e-3, 2e-2));
      const Vector3f q = p + step * rng.UnitVector().cast<float>();
      const float change = std::abs(shape.SignedDistance_m(p) - shape.SignedDistance_m(q));
      EXPECT_LE(change, 1.001f * step + 1e-6f) << c.name << " at " << p.transpose();
    }
  }
}

// A fillet adds material near the seam only.
TEST(SolidShape, SmoothUnionAddsAFillet) {
  const Solid plate = Box({60, 60, 10}), post = Cylinder(10, 60);
  const SolidShape sharp = CompiledSolid(Union(plate, post), 10);
  const SolidShape smooth = CompiledSolid(SmoothUnion(plate, post, 8), 10);
  const Vector3f seam(0.0105f, 0, 0.0055f), far(0.025f, 0, 0.0055f);
  EXPECT_FALSE(sharp.Contains(seam));
  EXPECT_TRUE(smooth.Contains(seam));
  EXPECT_FALSE(smooth.Contains(far));
}

TEST(SolidShape, ManyPointsGetTheValuesOfSinglePoints) {
  const SolidShape shape = CompiledSolid(Gear(15, 25, 30, 12), 4);
  Rng rng(3);
  std::vector<Vector3f> points(777);
  for (Vector3f& p : points) p = 0.035f * rng.UnitVector().cast<float>();
  std::vector<float> distances(points.size());
  shape.SignedDistances_m(points, distances);
  for (size_t i = 0; i < points.size(); ++i) {
    EXPECT_EQ(distances[i], shape.SignedDistance_m(points[i]));
  }
}

TEST(SolidShape, NormalPointsOutwards) {
  const SolidShape sphere = CompiledSolid(Sphere(25), 5);
  Rng rng(4);
  for (int i = 0; i < 50; ++i) {
    const Vector3f direction = rng.UnitVector().cast<float>();
    const std::vector<Vector3f> points{0.025f * direction};
    EXPECT_GT(sphere.Normals(points)[0].dot(direction), 0.9999f);
  }
}

TEST(SolidShape, HashDependsOnEveryParameter) {
  const auto hash = [](const Solid& solid) { return CompiledSolid(solid, 2).hash(); };
  EXPECT_EQ(hash(Box({20, 30, 40})), hash(Box({20, 30, 40})));
  EXPECT_NE(hash(Box({20, 30, 40})), hash(Box({20, 30, 41})));
  EXPECT_NE(hash(Box({20, 30, 40})), hash(Box({20, 30, 40}, 1)));
  EXPECT_NE(hash(Extruded({{0, 0}, {9, 0}, {0, 9}}, 8)),
            hash(Extruded({{0, 0}, {9, 0}, {9, 9}}, 8)));
}

TEST(SolidShape, EmptyShapeContainsNothing) {
  EXPECT_EQ(SolidShape().SignedDistance_m(Vector3f::Zero()),
            std::numeric_limits<float>::infinity());
}

TEST(SolidBuilder, RefusesEmptyAndInfiniteSolids) {
  EXPECT_EQ(ErrorOf([] { CompiledSolid(Cut(Sphere(10), Sphere(20)), 1); }),
            "a solid is empty; check its cuts and intersections");
  EXPECT_EQ(ErrorOf([] { CompiledSolid(HalfSpace(Vector3d::UnitX(), 0), 1); }),
            "a solid is empty or larger than 2000 mm; intersect it with a box");
}

TEST(SolidBuilder, RefusesADeepTree) {
  Solid right = Sphere(10);
  for (int i = 0; i < kSolidValues; ++i) right = Union(Sphere(9), right);
  EXPECT_EQ(ErrorOf([&] { CompiledSolid(right, 1); }),
            "a solid is nested too deeply; combine fewer solids at once");
}

}  // namespace
}  // namespace pickbed::tests
