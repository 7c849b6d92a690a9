#include "sim/convex/piece_quality.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/sim/physics_objects.h"

namespace pickbed::tests {
namespace {

using Eigen::Vector3d;

// Returns a pipe about z, closed at both ends by rings.
TriangleMesh Tube(double inner_m, double outer_m, double length_m, int facets) {
  TriangleMesh mesh;
  for (const double z : {-length_m / 2, length_m / 2}) {
    for (const double r : {inner_m, outer_m}) {
      for (int i = 0; i < facets; ++i) {
        const double angle = 2 * M_PI * i / facets;
        mesh.vertices.emplace_back(r * std::cos(angle), r * std::sin(angle), z);
      }
    }
  }
  const auto quad = [&](int a, int b, int c, int d) {
    mesh.triangles.emplace_back(a, b, c);
    mesh.triangles.emplace_back(a, c, d);
  };
  for (int i = 0; i < facets; ++i) {
    const int j = (i + 1) % facets, n = facets;
    quad(n + i, n + j, 3 * n + j, 3 * n + i);
    quad(j, i, 2 * n + i, 2 * n + j);
    quad(2 * n + i, 3 * n + i, 3 * n + j, 2 * n + j);
    quad(i, j, n + j, n + i);
  }
  return mesh;
}

TEST(PieceQuality, PieceEqualToTheMeshHasNoError) {
  const AxisAlignedBox box{{0.01, 0, 0}, {0.05, 0.04, 0.03}};
  const PieceQuality quality = MeasurePieces(BoxMesh(box), {BoxPiece(box)});
  EXPECT_NEAR(quality.bulge_m, 0, 1e-9);
  EXPECT_NEAR(quality.missed_m, 0, 1e-9);
  EXPECT_NEAR(quality.volume_error, 0, 1e-9);
}

TEST(PieceQuality, PlantedErrorsAreMeasured) {
  const AxisAlignedBox box{{0, 0, 0}, {0.05, 0.04, 0.03}};
  const AxisAlignedBox larger{{0, 0, 0}, {0.055, 0.04, 0.03}},
      smaller{{0, 0, 0}, {0.05, 0.04, 0.027}};
  const PieceQuality bulging = MeasurePieces(BoxMesh(box), {BoxPiece(larger)});
  EXPECT_NEAR(bulging.bulge_m, 0.005, 1e-4);
  EXPECT_NEAR(bulging.missed_m, 0, 1e-9);
  EXPECT_NEAR(bulging.volume_error, 0.1, 1e-6);
  const PieceQuality missing = MeasurePieces(BoxMesh(box), {BoxPiece(smaller)});
  EXPECT_NEAR(missing.missed_m, 0.003, 1e-9);
  EXPECT_NEAR(missing.bulge_m, 0, 1e-9);
}

TEST(PieceQuality, HullOverABoreBulgesByItsRadius) {
  const TriangleMesh tube = Tube(0.016, 0.020, 0.1, 48);
  const PieceQuality quality = MeasurePieces(tube, DecomposeConvex(tube, {.max_pieces = 1}));
  EXPECT_NEAR(quality.bulge_m, 0.016, 0.001);
}

TEST(FitConvexPieces, BoreOfAThinTubeStaysOpen) {
  for (const double outer_m : {0.020, 0.040}) {
    const TriangleMesh tube = Tube(outer_m - 0.004, outer_m, 0.1, 48);
    const FittedPieces fitted = FitConvexPieces(tube);
    EXPECT_LE(fitted.quality.bulge_m, 0.002) << "more than half of the wall thickness";
    EXPECT_LE(fitted.quality.pieces, 64);
    EXPECT_LT(fitted.quality.missed_m, 1e-4);
    EXPECT_EQ(fitted.quality.pieces, static_cast<int>(fitted.pieces.size()));
  }
}

}  // namespace
}  // namespace pickbed::tests
