#include "eval/draw/object_sheet.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <numbers>

#include "tests/support/layer.h"

namespace pickbed::tests {
namespace {

using testing::HasSubstr;

// n-fold about z, with or without half turns across it.
SymmetrySet FoldAboutZ(int order, bool flips) {
  SymmetrySet set;
  for (int i = 0; i < order; ++i) {
    const double angle = std::numbers::pi * i / order;
    const Eigen::Vector3d across(std::cos(angle), std::sin(angle), 0);
    if (i > 0) {
      set.discrete_O.push_back(
          TurnAbout({Eigen::Vector3d::UnitZ(), Eigen::Vector3d::Zero()}, 2 * angle));
    }
    if (flips) {
      set.discrete_O.push_back(TurnAbout({across, Eigen::Vector3d::Zero()}, std::numbers::pi));
    }
  }
  return set;
}

TEST(SymmetryText, NamesOrderAxisAndFlips) {
  EXPECT_EQ(SymmetryText(FoldAboutZ(6, true)), "6-fold about z, and flips");
  EXPECT_EQ(SymmetryText(FoldAboutZ(5, false)), "5-fold about z");
  EXPECT_EQ(SymmetryText(FoldAboutZ(2, false)), "2-fold about z");
  EXPECT_EQ(SymmetryText({}), "no symmetry");
  SymmetrySet broken = FoldAboutZ(6, true);
  broken.discrete_O.pop_back();
  EXPECT_EQ(SymmetryText(broken), "10 rotations") << "no such group";
}

TEST(ObjectText, SaysThatTheMassIsAGuess) {
  MadeObject made;
  made.model.mesh_O.vertices = {{0, 0, 0}, {0.1, 0, 0}, {0, 0.1, 0}};
  made.model.mesh_O.triangles = {{0, 1, 2}};
  EXPECT_THAT(ObjectText(made), testing::Not(HasSubstr("default density")));
  made.mass_by_default_density = true;
  EXPECT_THAT(ObjectText(made),
              HasSubstr("mass from the default density 1000 kg/m3 (plastic); steel is 7850"));
}

TEST(ObjectText, ShowsNoRoundingErrors) {
  MadeObject made;
  made.model.mesh_O.vertices = {{0, 0, 0}, {0.1, 0, 0}, {0, 0.1, 0}};
  made.model.mesh_O.triangles = {{0, 1, 2}};
  made.model.mass.inertia_com_O << 2e-5, -2.3e-22, 3e-7, -2.3e-22, 3e-5, 0, 3e-7, 0, 4e-5;
  made.quality.volume_error = -1e-12;
  EXPECT_THAT(ObjectText(made), HasSubstr("zz 4e-05 xy 0 xz 3e-07 yz 0 kg m2"));
  EXPECT_THAT(ObjectText(made), HasSubstr("volume +0.0 %"));
}

}  // namespace
}  // namespace pickbed::tests
