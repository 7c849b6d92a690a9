#include "sim/drop/object_maker.h"

#include <gtest/gtest.h>

#include "scenes/mesh_io/mesh_io.h"
#include "scenes/objects/object_catalog.h"
#include "tests/sim/physics_objects.h"
#include "tests/support/error_of.h"
#include "tests/support/temporary_folder.h"

namespace pickbed::tests {
namespace {

const AxisAlignedBox kBrick{{0.01, 0, 0.02}, {0.05, 0.03, 0.02}};

class ObjectMaker : public ::testing::Test {
 protected:
  MadeObject Make(const TriangleMesh& mesh) {
    request_.mesh = folder_.path() / "brick.obj";
    request_.density_kgpm3 = 500;
    SaveObj(request_.mesh, mesh);
    return MakeObject(request_);
  }
  const TemporaryFolder folder_;
  ObjectRequest request_{.name = "brick", .mesh = {}, .unit = "m"};
};

TEST_F(ObjectMaker, PropertiesOfABrickMatchTheFormula) {
  const MadeObject made = Make(BoxMesh(kBrick));
  const double mass_kg = 500 * 0.1 * 0.06 * 0.04;
  EXPECT_NEAR(made.model.mass.mass_kg, mass_kg, 1e-7);
  EXPECT_LT((made.model.mass.com_O - kBrick.center).norm(), 1e-9);
  const Eigen::Vector3d inertia = made.model.mass.inertia_com_O.diagonal();
  EXPECT_NEAR(inertia.x(), mass_kg * (0.06 * 0.06 + 0.04 * 0.04) / 12, 1e-10);
  EXPECT_EQ(made.quality.pieces, 1);
  EXPECT_EQ(made.model.symmetries_O.discrete_O.size(), 3u);
  ASSERT_EQ(made.resting.size(), 3u);  // the symmetries merge opposite faces
  EXPECT_GT(std::abs(made.resting[0].up_O.z()), 0.99);
}

TEST_F(ObjectMaker, DefaultDensityIsMarked) {
  EXPECT_FALSE(Make(BoxMesh(kBrick)).mass_by_default_density);
  request_.density_kgpm3 = 0;
  const MadeObject made = MakeObject(request_);
  EXPECT_TRUE(made.mass_by_default_density);
  EXPECT_NEAR(made.model.mass.mass_kg, 1000 * 0.1 * 0.06 * 0.04, 1e-7);
  request_.mass_kg = 0.2;
  EXPECT_FALSE(MakeObject(request_).mass_by_default_density);
}

TEST_F(ObjectMaker, CatalogReadsBackTheWrittenObject) {
  TriangleMesh open = BoxMesh(kBrick);
  open.triangles.pop_back();
  const MadeObject made = Make(open);
  EXPECT_TRUE(made.mass_from_hull);
  EXPECT_NEAR(made.model.mass.mass_kg, 500 * 0.1 * 0.06 * 0.04, 1e-7);
  WriteObject(made.record, folder_.path() / "parts" / "brick");
  const auto read = ObjectCatalog({folder_.path() / "parts"}).Load("brick");
  EXPECT_NEAR(read->mass.mass_kg, made.model.mass.mass_kg, 1e-9);
  EXPECT_LT((read->mass.com_O - made.model.mass.com_O).norm(), 1e-8);
  EXPECT_LT((read->mass.inertia_com_O - made.model.mass.inertia_com_O).norm(), 1e-11);
  EXPECT_EQ(read->convex_pieces_O.size(), made.model.convex_pieces_O.size());
  EXPECT_EQ(read->symmetries_O.discrete_O.size(), made.model.symmetries_O.discrete_O.size());
  ASSERT_EQ(read->resting_O.size(), made.model.resting_O.size());
  EXPECT_LT((read->resting_O[0].up_O - made.model.resting_O[0].up_O).norm(), 1e-6);
  EXPECT_NEAR(read->resting_O[0].probability, made.model.resting_O[0].probability, 1e-6);
}

// 1 m x 0.6 m x 0.4 m, at 500 kg/m3.
TEST_F(ObjectMaker, AMassOver100KilogramsIsRefused) {
  const AxisAlignedBox block{Eigen::Vector3d::Zero(), {0.5, 0.3, 0.2}};
  const std::string error = ErrorOf([&] { Make(BoxMesh(block)); });
  EXPECT_NE(error.find("would have a mass of 120 kg by its volume and density"), std::string::npos)
      << error;
}

}  // namespace
}  // namespace pickbed::tests
