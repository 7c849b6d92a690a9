#include "grasp/candidates/suction.h"

#include <gtest/gtest.h>

#include <numbers>

#include "grasp/candidates/candidates.h"
#include "sim/hands/suction_hand.h"
#include "tests/grasp/grasp_scenes.h"

namespace pickbed::tests {
namespace {

using Eigen::Vector3d;

std::vector<GraspCandidate> CupGrasps(const ObjectModel& model) {
  Rng rng(1);
  SuctionOptions options;
  options.candidates = 300;
  options.max_samples = 600;
  RobustOptions robust;
  robust.samples = 8;
  return SuctionGrasps(model, CupSpec{}, rng, options, robust);
}

TEST(Suction, PlateIsGraspedWhereTheWholeLipTouches) {
  const Vector3d size(0.10, 0.08, 0.01);
  const CupSpec cup;
  const auto grasps = CupGrasps(*BoxObject(size, 0.2));
  ASSERT_GT(grasps.size(), 20u);
  for (const GraspCandidate& grasp : grasps) {
    const Vector3d approach = grasp.X_OG.linear().col(2);
    EXPECT_NEAR(std::abs(approach.z()), 1, 1e-6);
    // The lip is pressed into the face by press_m.
    EXPECT_NEAR(-approach.z() * grasp.X_OG.translation().z(), 0.5 * size.z() - cup.press_m, 1e-6);
    EXPECT_LE(std::abs(grasp.X_OG.translation().x()), 0.5 * size.x() - cup.radius_m + 1e-3);
    EXPECT_LE(std::abs(grasp.X_OG.translation().y()), 0.5 * size.y() - cup.radius_m + 1e-3);
    EXPECT_EQ(grasp.width_m, 0);
    EXPECT_GT(grasp.quality, 0);
    EXPECT_LE(grasp.quality, 1);
    EXPECT_GT(grasp.epsilon, 0);
  }
}

TEST(Suction, GraspNearTheCenterOfMassIsBetter) {
  const auto grasps = CupGrasps(*BoxObject({0.20, 0.06, 0.01}, 0.8));
  GraspCandidate center, end;  // hold the best value of each quality in their region
  for (const GraspCandidate& grasp : grasps) {
    const double off = std::abs(grasp.X_OG.translation().x());
    if (off > 0.02 && off < 0.07) continue;
    GraspCandidate& best = off <= 0.02 ? center : end;
    best.quality = std::max(best.quality, grasp.quality);
    best.epsilon = std::max(best.epsilon, grasp.epsilon);
    best.robust = std::max(best.robust, grasp.robust);
  }
  EXPECT_GT(end.quality, 0);
  EXPECT_GT(center.quality, 1.5 * end.quality);
  EXPECT_GT(center.epsilon, 1.2 * end.epsilon);
  // At the end, the weight of 8 N at 0.08 m and the lift exceed the moment limit of 0.6 Nm.
  EXPECT_EQ(center.robust, 1);
  EXPECT_LT(end.robust, 0.5);
}

TEST(Suction, NoGraspOnABoxSmallerThanTheLip) {
  EXPECT_TRUE(CupGrasps(*BoxObject({0.025, 0.025, 0.08}, 0.1)).empty());
}

TEST(Suction, SameSeedGivesSameBytes) {
  const auto a = CupGrasps(*BracketObject()), b = CupGrasps(*BracketObject());
  ASSERT_EQ(a.size(), b.size());
  for (size_t i = 0; i < a.size(); ++i) {
    EXPECT_EQ(a[i].X_OG.matrix(), b[i].X_OG.matrix());
    EXPECT_EQ(a[i].robust, b[i].robust);
  }
}

// A cup that approaches the center of a box from straight above.
class CupHolds : public testing::Test {
 protected:
  bool Balanced(const Vector3d& force_n, const Vector3d& torque_nm) const {
    Wrench load;
    load << force_n / WrenchForce_n(*box_),
        torque_nm / (WrenchForce_n(*box_) * WrenchRadius_m(*box_));
    // The lip is at the center of mass, so that a pull has no lever arm.
    const Pose X_OG = FromAbove({0, 0, -cup_.press_m});
    return Balances(CupWrenches(*box_, cup_, X_OG, cup_.press_m, 1, 8), load);
  }

  const CupSpec cup_;
  const std::shared_ptr<const ObjectModel> box_ = BoxObject({0.05, 0.05, 0.05}, 0.2, 0.5);
};

TEST_F(CupHolds, HoldsPullUpToTheVacuumForce) {
  EXPECT_TRUE(Balanced({0, 0, -0.99 * cup_.vacuum_n}, Vector3d::Zero()));
  EXPECT_FALSE(Balanced({0, 0, -1.01 * cup_.vacuum_n}, Vector3d::Zero()));
}

TEST_F(CupHolds, HoldsMomentUpToItsLimit) {
  // The rim has eight points, so the limit is between cos(22.5 degrees) and 1 times the formula.
  EXPECT_TRUE(Balanced(Vector3d::Zero(), {0.92 * cup_.moment_limit_nm, 0, 0}));
  EXPECT_FALSE(Balanced(Vector3d::Zero(), {1.01 * cup_.moment_limit_nm, 0, 0}));
}

TEST_F(CupHolds, HoldsShearUpToFrictionAndLessUnderPull) {
  const double limit_n = 0.5 * cup_.friction * cup_.vacuum_n;
  EXPECT_TRUE(Balanced({0.92 * limit_n, 0, 0}, Vector3d::Zero()));
  EXPECT_FALSE(Balanced({1.01 * limit_n, 0, 0}, Vector3d::Zero()));
  EXPECT_FALSE(Balanced({0.92 * limit_n, 0, -0.5 * cup_.vacuum_n}, Vector3d::Zero()));
}

// The planner's polytope approximates the limit of the physics joint. 8 points of the ring and 8
// edges of a cone each approximate a circle to cos(22.5 degrees). Ring forces approximate the
// ellipsoid of shear and torsion: by sqrt(2) if both act on one point of the ring, by 1 / sqrt(2)
// if bending loads only one side.
TEST_F(CupHolds, PolytopeApproximatesTheJointLimit) {
  Rng rng(3);
  const double friction = 0.5 * cup_.friction, radius_m = RingRadius_m(cup_);
  for (int i = 0; i < 500; ++i) {
    LipLoad load;  // of the box on the cup, in G
    const Vector3d force = rng.UnitVector(), torque = rng.UnitVector();
    load.force_n = cup_.vacuum_n * Vector3d(force.x() * friction, force.y() * friction, force.z());
    load.torque_nm = rng.Uniform(0, 1) * cup_.vacuum_n * radius_m *
                     Vector3d(torque.x(), torque.y(), torque.z() * friction);
    // Scales the load to just below and just above the limit. A load that presses is held at any
    // scale.
    double low = 0, high = 1;
    for (int k = 0; k < 40; ++k) {
      const double scale = 0.5 * (low + high);
      const LipLoad scaled{scale * load.force_n, scale * load.torque_nm};
      (ShareOfLimit(cup_, friction, scaled) < 1 ? low : high) = scale;
    }
    if (high == 1) continue;  // held at full scale
    // x of W is x of G; y and z are reversed.
    const auto planned = [&](double scale) {
      const Vector3d flip(1, -1, -1);
      return Balanced(scale * load.force_n.cwiseProduct(flip),
                      scale * load.torque_nm.cwiseProduct(flip));
    };
    EXPECT_TRUE(planned(0.55 * low))
        << i << ": " << load.force_n.transpose() << "; " << load.torque_nm.transpose();
    EXPECT_FALSE(planned(1.45 * high))
        << i << ": " << load.force_n.transpose() << "; " << load.torque_nm.transpose();
  }
}

}  // namespace
}  // namespace pickbed::tests
