#include "scenes/bin/bin_shape.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "scenes/bin/bin.h"
#include "scenes/geometry/mesh_query.h"
#include "scenes/mesh_io/mesh_io.h"
#include "scenes/scenario/load_objects.h"
#include "scenes/scenario/scenario_spec.h"
#include "tests/scenes/shapes.h"
#include "tests/support/tapered_bin.h"

namespace pickbed::tests {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using ::testing::HasSubstr;

constexpr double kPrecision_m = 1e-5;

TEST(BinShape, BoxBinIsMeasuredExactly) {
  Bin box;
  box.inner_size_m = {0.4, 0.3, 0.15};
  box.wall_m = 0.004;
  const Pose X_FB = Translation({1.2, -0.4, 0.7});  // an arbitrary position in the file
  const BinShape shape = MakeBinShape(Transformed(BinMesh(box), X_FB), "box");
  EXPECT_LT((shape.inner_size_m - box.inner_size_m).norm(), kPrecision_m);
  EXPECT_LT((shape.opening_m - Vector2d(0.4, 0.3)).norm(), kPrecision_m);
  EXPECT_NEAR(shape.wall_m, 0.004, kPrecision_m);
  const Bounds bounds = MeshBounds(shape.mesh_B);
  EXPECT_LT((bounds.min - Vector3d(-0.204, -0.154, -0.004)).norm(), kPrecision_m);
  EXPECT_LT((bounds.max - Vector3d(0.204, 0.154, 0.15)).norm(), kPrecision_m);
}

TEST(BinShape, SlopedWallsGiveInnerSizeNearTheFloor) {
  // 0.3 x 0.2 m at the floor, 0.4 x 0.28 m at the rim, 0.12 m high.
  const BinShape shape = MakeBinShape(TaperedBin(), "tapered");
  const double twentieth = 0.05;
  EXPECT_NEAR(shape.inner_size_m.x(), 0.3 + twentieth * 0.1, kPrecision_m);
  EXPECT_NEAR(shape.inner_size_m.y(), 0.2 + twentieth * 0.08, kPrecision_m);
  EXPECT_NEAR(shape.inner_size_m.z(), 0.12, kPrecision_m);
  const double under_rim = (0.12 - 0.001) / 0.12;
  EXPECT_NEAR(shape.opening_m.x(), 0.3 + under_rim * 0.1, kPrecision_m);
  EXPECT_NEAR(shape.opening_m.y(), 0.2 + under_rim * 0.08, kPrecision_m);
  Bin bin;
  bin.inner_size_m = shape.inner_size_m;
  bin.shape = std::make_shared<const BinShape>(shape);
  EXPECT_TRUE(bin.Holds({0.19, 0, 0.11})) << "above the sloped wall";
  EXPECT_FALSE(bin.Holds({0.21, 0, 0.11}));
}

TEST(BinShape, CompartmentWallsDoNotReduceTheInnerSize) {
  TriangleMesh mesh = BinMesh(Bin{});
  Append(BoxShape({0.003, 0.2999, 0.08}, {0, 0, 0.0399}), mesh);
  Append(BoxShape({0.1, 0.003, 0.08}, {0.1, 0, 0.0399}), mesh);
  const BinShape shape = MakeBinShape(mesh, "compartments");
  EXPECT_LT((shape.inner_size_m - Bin{}.inner_size_m).norm(), kPrecision_m);
}

TEST(BinShape, SolidBlockBecomesATable) {
  const BinShape shape = MakeBinShape(BoxShape({0.6, 0.5, 0.3}), "block");
  EXPECT_LT((shape.inner_size_m - Vector3d(0.6, 0.5, 0)).norm(), 2 * kPrecision_m);
}

// No piece extends beyond the solid: a line from a point just inside a piece crosses the surface an
// odd number of times.
TEST(BinShape, PiecesStayInsideTheSolid) {
  const BinShape shape = MakeBinShape(TaperedBin(), "tapered");
  // Floor, four inner and four outer walls, underside, and the rim in eight triangles.
  EXPECT_EQ(shape.pieces_B.size(), 18u);
  const MeshQuery surface(shape.mesh_B);
  for (const std::vector<Vector3d>& piece : shape.pieces_B) {
    Vector3d center = Vector3d::Zero();
    for (const Vector3d& p : piece) center += p / static_cast<double>(piece.size());
    for (const Vector3d& p : piece) {
      if (p.z() < -0.01) continue;  // pieces extend below the floor
      const Vector3d inside = p + 0.02 * (center - p);
      if (inside.z() < -0.004) continue;
      int above = 0;
      for (const SurfaceHit& hit : surface.AllHits(inside, Vector3d(0.3, 0.2, 0.93).normalized())) {
        above += hit.distance > 0;
      }
      EXPECT_EQ(above % 2, 1) << "a piece extends beyond the solid at " << p.transpose();
    }
  }
}

TEST(BinShape, MeshesThatAreNoBinAreRefused) {
  const auto error = [](const TriangleMesh& mesh) {
    return InputErrorOf([&] { MakeBinShape(mesh, "my_bin.stl"); });
  };
  TriangleMesh frame = BinMesh(Bin{});
  TriangleMesh open = frame;
  open.triangles.pop_back();
  EXPECT_THAT(error(open), HasSubstr("my_bin.stl: the bin's mesh is open at 3 edges"));
  EXPECT_THAT(error(WallsWithoutFloor()), HasSubstr("my_bin.stl: the bin has no floor"));
  const Pose upside_down = MakePose(Vector3d(1, -1, -1).asDiagonal().toDenseMatrix(), {0, 0, 0});
  EXPECT_THAT(error(Transformed(frame, upside_down)), HasSubstr("opens downwards"));
  EXPECT_THAT(error(Scaled(frame, 1000)), HasSubstr("check bin.unit"));
}

class MeshBinScenario : public ::testing::Test {
 protected:
  MeshBinScenario() {
    SaveObj(folder_.path() / "bin.obj", Scaled(TaperedBin(), 1000));
    folder_.Write("bins/tote.yaml", "{mesh: ../bin.obj, unit: mm, friction: 0.3}");
  }
  ScenarioSpec Load(const std::string& bin, const std::vector<std::string>& set = {}) {
    const std::string yaml = "objects: [{name: rod, count: 2}]\nbin: " + bin + "\n";
    return LoadScenario(folder_.Write("scenario.yaml", yaml), set);
  }
  std::string ErrorOf(const std::string& bin, const std::vector<std::string>& set = {}) {
    return InputErrorOf([&] { Load(bin, set); });
  }
  const TemporaryFolder folder_;
};

TEST_F(MeshBinScenario, MissingSizesAreMeasured) {
  const ScenarioSpec measured = Load("{mesh: bin.obj, unit: mm}");
  ASSERT_TRUE(measured.bin.shape);
  EXPECT_NEAR(measured.bin.inner_size_m.x(), 0.305, kPrecision_m);
  EXPECT_TRUE(BinOf(measured).shape);
  const ScenarioSpec given = Load("{mesh: bin.obj, unit: mm, inner_size_m: [0.25, 0.2, 0.12]}");
  EXPECT_EQ(given.bin.inner_size_m.x(), 0.25);
  const ScenarioSpec named =
      Load("{name: " + (folder_.path() / "bins/tote.yaml").string() + ", wall_m: 0.05}");
  ASSERT_TRUE(named.bin.shape);
  EXPECT_EQ(named.bin.friction, 0.3);
  EXPECT_EQ(named.bin.wall_m, 0.05);
  EXPECT_NEAR(named.bin.inner_size_m.x(), 0.305, kPrecision_m);
}

TEST_F(MeshBinScenario, WrittenScenarioReadsBack) {
  ScenarioSpec spec = Load("{mesh: bin.obj, unit: mm}");
  const std::string text = WriteSettings([&](SettingsVisitor& v) { spec.Visit(v); });
  const ScenarioSpec copy = LoadScenario(folder_.Write("written.yaml", text));
  EXPECT_EQ(copy.bin.inner_size_m, spec.bin.inner_size_m);
  EXPECT_EQ(copy.bin.wall_m, spec.bin.wall_m);
  ASSERT_TRUE(copy.bin.shape);
}

TEST_F(MeshBinScenario, InvalidBinsAreRefusedWithAReason) {
  EXPECT_THAT(ErrorOf("{mesh: none.stl}"), HasSubstr("scenario.yaml:2: bin.mesh: "));
  EXPECT_THAT(ErrorOf("{mesh: none.stl}"), HasSubstr("none.stl"));
  EXPECT_THAT(ErrorOf("{mesh: bin.obj, unit: mm, inner_size_m: [0.5, 0.2, 0.1]}"),
              HasSubstr("larger than the opening"));
  EXPECT_THAT(ErrorOf("{mesh: bin.obj, unit: mm}", {"camera.eye_m=[0.16, 0, 0.05]"}),
              HasSubstr("inside the bin"));
  const ScenarioSpec tiny = Load("{mesh: bin.obj, unit: mm}");
  ScenarioSpec shrunk = tiny;
  shrunk.bin.inner_size_m *= 0.1;
  const ObjectCatalog catalog({AssetsDir() / "objects"});
  EXPECT_THAT(InputErrorOf([&] { LoadObjects(shrunk, catalog); }),
              HasSubstr("larger than the bin"));
}

}  // namespace
}  // namespace pickbed::tests
