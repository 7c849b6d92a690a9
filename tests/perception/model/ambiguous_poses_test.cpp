#include "perception/model/ambiguous_poses.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numbers>

#include "tests/support/synthetic_depth.h"

namespace pickbed::tests {
namespace {

// A plate of 80 x 50 x 6 mm with a small stud on its upper side. Upside down and moved by the
// height of the stud, it nearly covers itself.
TriangleMesh StuddedPlate() {
  TriangleMesh mesh = BoxMesh({0.08, 0.05, 0.006}, {0, 0, 0});
  const TriangleMesh stud = BoxMesh({0.01, 0.01, 0.006}, {0.025, 0.01, 0.006});
  const int first = static_cast<int>(mesh.vertices.size());
  mesh.vertices.insert(mesh.vertices.end(), stud.vertices.begin(), stud.vertices.end());
  for (const Eigen::Vector3i& t : stud.triangles) {
    mesh.triangles.push_back(t + Eigen::Vector3i::Constant(first));
  }
  return mesh;
}

std::vector<Pose> AmbiguousPosesOf(const ObjectModel& model) {
  return AmbiguousPoses(model, MakeModelPoints(model), PoseDistance(model));
}

TEST(AmbiguousPoses, HalfTurnsOfAPlateAreFound) {
  const auto plate = ObjectOf(StuddedPlate());
  const std::vector<Pose> found = AmbiguousPosesOf(*plate);
  for (const Eigen::Vector3d& axis :
       {Eigen::Vector3d(1, 0, 0), Eigen::Vector3d(0, 1, 0), Eigen::Vector3d(0, 0, 1)}) {
    const Pose half_turn =
        MakePose(Eigen::AngleAxisd(std::numbers::pi, axis).toRotationMatrix(), {0, 0, 0});
    const bool there = std::any_of(found.begin(), found.end(), [&](const Pose& S) {
      const PoseGap gap = GapBetween(S, half_turn);
      return gap.angle_deg < 6 && gap.shift_m < 0.004;
    });
    EXPECT_TRUE(there) << "about " << axis.transpose();
  }
}

TEST(AmbiguousPoses, PosesDifferFromEachOtherAndFromIdentity) {
  const auto plate = ObjectOf(StuddedPlate());
  const PoseDistance distance(*plate);
  const std::vector<Pose> found = AmbiguousPosesOf(*plate);
  for (size_t i = 0; i < found.size(); ++i) {
    EXPECT_GE(distance(found[i], Pose::Identity()), AmbiguousPoseOptions().min_move_diameters);
    for (size_t j = 0; j < i; ++j) {
      EXPECT_GE(distance(found[i], found[j]), AmbiguousPoseOptions().min_move_diameters);
    }
  }
}

// A symmetric pose is not an ambiguous pose.
TEST(AmbiguousPoses, SymmetriesAreExcluded) {
  SymmetrySet symmetries;
  for (int axis = 0; axis < 3; ++axis) {
    symmetries.discrete_O.push_back(MakePose(
        Eigen::AngleAxisd(std::numbers::pi, Eigen::Vector3d::Unit(axis)).toRotationMatrix(),
        {0, 0, 0}));
  }
  const auto plain = ObjectOf(BoxMesh({0.10, 0.05, 0.02}, {0, 0, 0}));
  const auto box = ObjectOf(BoxMesh({0.10, 0.05, 0.02}, {0, 0, 0}), symmetries);
  const auto half_turns = [](const std::vector<Pose>& found) {
    return std::count_if(found.begin(), found.end(), [](const Pose& S) {
      return GapBetween(S, Pose::Identity()).angle_deg > 175;
    });
  };
  EXPECT_EQ(half_turns(AmbiguousPosesOf(*plain)), 3);
  EXPECT_EQ(half_turns(AmbiguousPosesOf(*box)), 0);
}

}  // namespace
}  // namespace pickbed::tests
