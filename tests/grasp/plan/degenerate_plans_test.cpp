// Planners on degenerate clouds, poses and objects.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "grasp/grippers/suction_cup.h"
#include "grasp/plan/hold_factor.h"
#include "grasp/plan/image_picks.h"
#include "grasp/plan/object_shape.h"
#include "grasp/plan/plan_stir.h"
#include "tests/grasp/plan/plan_fixture.h"
#include "tests/scenes/geometry/degenerate_meshes.h"
#include "tests/support/error_of.h"

namespace pickbed::tests {
namespace {

using Eigen::Vector3d;

class DegenerateInputs : public PlanFixture {
 protected:
  // Plans with the first pose as the only target.
  PlanResult RunForFirst() const {
    const std::vector<int> targets{0};
    return PlanGrasps({bin_, poses_, candidates_, cloud_, objects_, gripper_, targets, nullptr});
  }
  static void ExpectSame(const PlanResult& a, const PlanResult& b) {
    ASSERT_EQ(a.grasps.size(), b.grasps.size());
    for (size_t i = 0; i < a.grasps.size(); ++i) {
      EXPECT_EQ(a.grasps[i].X_WG.matrix(), b.grasps[i].X_WG.matrix());
      EXPECT_EQ(a.grasps[i].score, b.grasps[i].score);
    }
    EXPECT_EQ(a.rejected, b.rejected);
  }
};

TEST_F(DegenerateInputs, PointsThatAreNotFiniteChangeNothing) {
  constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
  constexpr double kInf = std::numeric_limits<double>::infinity();
  AddPose({0.03, 0.02, 0.025});
  cloud_ = {{0.03, 0.02, 0.0505}};
  const PlanResult before = Run();
  EXPECT_FALSE(before.grasps.empty());
  cloud_.insert(cloud_.end(), {{kNaN, 0, 0.05},
                               {0.03, kNaN, 0.05},
                               {0.03, 0.02, kNaN},
                               {kInf, -kInf, 0.05},
                               {0.03, 0.02, kInf}});
  ExpectSame(Run(), before);
}

TEST_F(DegenerateInputs, EqualPointsAreOnePoint) {
  AddPose({0, 0, 0.025});
  cloud_ = {{0.034, 0, 0.03}};  // where a finger would be
  const PlanResult before = Run();
  cloud_.resize(500, cloud_[0]);
  ExpectSame(Run(), before);
}

// A wrong pose, for example in millimetres. It is no obstacle near the bin.
TEST_F(DegenerateInputs, PosesFarAwayDoNotChangeTheGraspsInTheBin) {
  AddPose({0.03, 0.02, 0.025});
  AddPose({0.03, -0.08, 0.025});
  const PlanResult before = RunForFirst();
  ASSERT_FALSE(before.grasps.empty());
  for (const Vector3d& far_W : {Vector3d(85, 120, 0.025), Vector3d(-3e6, 2e6, 0.025)}) {
    AddPose(far_W);
    const PlanResult result = RunForFirst();
    ASSERT_EQ(result.grasps.size(), before.grasps.size());
    for (size_t i = 0; i < before.grasps.size(); ++i) {
      EXPECT_EQ(result.grasps[i].X_WG.matrix(), before.grasps[i].X_WG.matrix());
      EXPECT_NEAR(result.grasps[i].score, before.grasps[i].score, 1e-9);
    }
  }
}

TEST_F(DegenerateInputs, EqualPosesAreOneInstance) {
  AddPose({0.03, 0.02, 0.025});
  const PlanResult before = RunForFirst();
  ASSERT_FALSE(before.grasps.empty());
  for (int copies = 0; copies < 3; ++copies) AddPose({0.03, 0.02, 0.025});
  const PlanResult result = RunForFirst();
  ASSERT_FALSE(result.grasps.empty());
  EXPECT_EQ(result.grasps[0].X_WG.matrix(), before.grasps[0].X_WG.matrix());
}

TEST_F(DegenerateInputs, NothingIsReachableWithoutPosesOrWishes) {
  const auto reachable = [&](int wanted) {
    const PlanInput input{bin_, poses_, candidates_, cloud_, objects_, gripper_, {}, nullptr};
    return CountReachable({&input, 1}, wanted);
  };
  EXPECT_EQ(reachable(3), 0);
  AddPose({0, 0, 0.025});
  EXPECT_EQ(reachable(0), 0);
  EXPECT_EQ(reachable(3), 1);
}

TEST_F(DegenerateInputs, ShapesOfObjectsAreFiniteOrRefused) {
  for (const DegenerateMesh& test : DegenerateMeshes()) {
    if (test.name == "a huge box") continue;  // no bin holds it, so scenarios with it are refused
    auto model = std::make_shared<ObjectModel>();
    model->mesh_O = test.mesh;
    const ObjectSet objects{model};
    const std::vector<std::vector<GraspCandidate>> candidates(1, std::vector<GraspCandidate>(1));
    const PlanInput input{bin_, {}, candidates, {}, objects, gripper_, {}, nullptr};
    if (!test.has_area) {
      EXPECT_THAT(ErrorOf([&] { MakeShape(input, ObjectId{0}, {}); }),
                  testing::HasSubstr("a mesh without area"))
          << test.name;
      continue;
    }
    const ObjectShape shape = MakeShape(input, ObjectId{0}, {});
    EXPECT_GE(shape.points_O.cols(), PlanOptions().min_object_points) << test.name;
    EXPECT_GE(shape.obstacle_O.cols(), shape.points_O.cols()) << test.name;
    EXPECT_TRUE(shape.obstacle_O.allFinite()) << test.name;
    EXPECT_TRUE(std::isfinite(shape.band_radius_m)) << test.name;
    EXPECT_TRUE(shape.thickness_m >= 0 && (test.has_volume || shape.thickness_m < 1e-9))
        << test.name;
    EXPECT_TRUE(shape.band.Contains(shape.points_O.col(0))) << test.name;
    EXPECT_EQ(shape.openings_m.at(0), 2 * gripper_.clearance_m) << "a width of 0";
  }
}

TEST_F(DegenerateInputs, PicksOfFlatObjectsAreIndependentOnlyWhenApart) {
  for (const DegenerateMesh& test : DegenerateMeshes()) {
    if (test.name == "a huge box" || test.name == "a far box") continue;
    auto model = std::make_shared<ObjectModel>();
    model->mesh_O = test.mesh;
    model->diameter_m = Diameter(test.mesh);
    const ObjectSet objects{model};
    ImagePicks picks(objects);
    const EstimatedPose here{ObjectId{0}, Translation({-0.1, 0, 0.02})};
    EstimatedPose there = here;
    there.X_WO.translation().x() += 2;
    Grasp grasp, other;
    grasp.X_WG = FromAbove({-0.1, 0, 0.02});
    other.X_WG = FromAbove({1.9, 0, 0.02});
    EXPECT_TRUE(picks.IsApart(here)) << "without a pick";
    if (!test.has_area) {
      EXPECT_THAT(ErrorOf([&] { picks.Add(grasp, here, gripper_); }),
                  testing::HasSubstr("a mesh without area"))
          << test.name;
      EXPECT_TRUE(picks.empty());
      continue;
    }
    picks.Add(grasp, here, gripper_);
    EXPECT_FALSE(picks.IsApart(here)) << test.name;
    EXPECT_FALSE(picks.IsIndependent(grasp, here, gripper_)) << test.name;
    EXPECT_TRUE(picks.IsApart(there)) << test.name;
    EXPECT_TRUE(picks.IsIndependent(other, there, gripper_)) << test.name;
  }
}

TEST_F(DegenerateInputs, AnObjectWithoutWeightIsHeldFully) {
  SuctionCup cup;
  ObjectModel object = *BoxObject({0.05, 0.05, 0.05}, 0.2);
  const Pose X_OG = FromAbove({0.02, 0, 0.025});
  const auto factor = [&](double lift_load) {
    return HoldFactor(cup, object, X_OG, Pose::Identity(), lift_load);
  };
  EXPECT_EQ(factor(0), 1);
  const double held = factor(2), hardly_held = factor(1e3);
  EXPECT_TRUE(held > hardly_held && hardly_held >= 0 && held <= 1) << held << " " << hardly_held;
  object.mass.mass_kg = 0;
  EXPECT_EQ(factor(2), 1);
}

TEST_F(DegenerateInputs, StirsOfFewPointsStayInTheBin) {
  constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
  std::vector<Vector3d> upright, along_a_wall;
  for (int i = 0; i < 100; ++i) {
    upright.emplace_back(0.05, 0.05, 0.01 + 0.001 * i);
    along_a_wall.emplace_back(-0.15 + 0.003 * i, 0.5 * bin_.inner_size_m.y() - 0.012, 0.02);
  }
  const std::vector<std::vector<Vector3d>> clouds{{},
                                                  {{0, 0, 0.02}},
                                                  std::vector<Vector3d>(50, Vector3d(0, 0, 0.02)),
                                                  {{kNaN, 0, 0.02}, {0, 0, kNaN}},
                                                  upright,
                                                  along_a_wall};
  const Eigen::Vector2d room_m = 0.5 * bin_.inner_size_m.head<2>();
  for (size_t k = 0; k < clouds.size(); ++k) {
    for (int number = 0; number < 9; ++number) {
      const StirPath path = PlanStir(bin_, clouds[k], gripper_, number);
      for (const Pose& X_WG : {path.X_WG_from, path.X_WG_to}) {
        const Vector3d p_W = X_WG.translation();
        EXPECT_TRUE((p_W.head<2>().cwiseAbs().array() < room_m.array()).all()) << k;
        EXPECT_GE(p_W.z(), PlanStirOptions().floor_m) << k;
        EXPECT_EQ(X_WG.linear().col(2), -Vector3d::UnitZ()) << k;
        EXPECT_NEAR(X_WG.linear().determinant(), 1, 1e-12) << k;
      }
      const double above_m = path.X_WG_from.translation().z() + path.rise_m;
      EXPECT_GE(above_m, bin_.inner_size_m.z()) << k << ": the hand begins above the rim";
      EXPECT_LT(above_m, 0.6) << k;
    }
  }
}

}  // namespace
}  // namespace pickbed::tests
