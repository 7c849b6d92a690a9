#include "grasp/suction_candidates.h"

#include <gtest/gtest.h>

#include <numbers>

#include "grasp/candidates.h"
#include "sim/cup_limit.h"
#include "tests/grasp/grasp_scenes.h"

namespace pickbed {
namespace {

using Eigen::Vector3d;

GripperSpec SmallCup() {
  GripperSpec gripper;
  gripper.name = "test cup";
  gripper.mechanism = "suction_cup";
  return gripper;
}

std::vector<GraspCandidate> Grasps(const ObjectModel& model, const GripperSpec& gripper) {
  Rng rng(1);
  SuctionOptions options;
  options.candidates = 300;
  options.max_samples = 600;
  RobustOptions robust;
  robust.samples = 8;
  return SuctionGrasps(model, gripper, rng, options, robust);
}

TEST(Suction, PlateIsHeldOnItsFacesWhereTheWholeLipIs) {
  const Vector3d size(0.10, 0.08, 0.01);
  const GripperSpec gripper = SmallCup();
  const auto grasps = Grasps(*BoxPart(size, 0.2), gripper);
  ASSERT_GT(grasps.size(), 20u);
  for (const GraspCandidate& grasp : grasps) {
    const Vector3d approach = grasp.X_OG.linear().col(2);
    EXPECT_NEAR(std::abs(approach.z()), 1, 1e-6);
    // The lip is on the face that it comes down on, pressed by as much as is aimed at.
    EXPECT_NEAR(-approach.z() * grasp.X_OG.translation().z(), 0.5 * size.z() - gripper.cup.press_m,
                1e-6);
    EXPECT_LE(std::abs(grasp.X_OG.translation().x()), 0.5 * size.x() - gripper.cup.radius_m + 1e-3);
    EXPECT_LE(std::abs(grasp.X_OG.translation().y()), 0.5 * size.y() - gripper.cup.radius_m + 1e-3);
    EXPECT_EQ(grasp.width_m, 0);
    EXPECT_GT(grasp.quality, 0);
    EXPECT_LE(grasp.quality, 1);
    EXPECT_GT(grasp.epsilon, 0);
  }
}

TEST(Suction, NearTheCentreOfMassIsBetter) {
  const auto grasps = Grasps(*BoxPart({0.20, 0.06, 0.01}, 0.8), SmallCup());
  GraspCandidate middle, end;  // with the best of each quality there
  for (const GraspCandidate& grasp : grasps) {
    const double off = std::abs(grasp.X_OG.translation().x());
    if (off > 0.02 && off < 0.07) continue;
    GraspCandidate& best = off <= 0.02 ? middle : end;
    best.quality = std::max(best.quality, grasp.quality);
    best.epsilon = std::max(best.epsilon, grasp.epsilon);
    best.robust = std::max(best.robust, grasp.robust);
  }
  EXPECT_GT(end.quality, 0);
  EXPECT_GT(middle.quality, 1.5 * end.quality);
  EXPECT_GT(middle.epsilon, 1.2 * end.epsilon);
  // At the end the part's 8 N tip it over the rim: 8 N * 0.08 m and the lift against 0.6 Nm.
  EXPECT_EQ(middle.robust, 1);
  EXPECT_LT(end.robust, 0.5);
}

TEST(Suction, NothingOnAPartSmallerThanTheLip) {
  EXPECT_TRUE(Grasps(*BoxPart({0.025, 0.025, 0.08}, 0.1), SmallCup()).empty());
}

TEST(Suction, SameSeedSameBytes) {
  const auto a = Grasps(*BracketPart(), SmallCup()), b = Grasps(*BracketPart(), SmallCup());
  ASSERT_EQ(a.size(), b.size());
  for (size_t i = 0; i < a.size(); ++i) {
    EXPECT_EQ(a[i].X_OG.matrix(), b[i].X_OG.matrix());
    EXPECT_EQ(a[i].robust, b[i].robust);
  }
}

// A cup that comes straight down on the middle of a part.
class CupHolds : public testing::Test {
 protected:
  bool Balanced(const Vector3d& force_n, const Vector3d& torque_nm) const {
    Wrench load;
    load << force_n / WrenchForce_n(*box_),
        torque_nm / (WrenchForce_n(*box_) * WrenchRadius_m(*box_));
    // The lip on the centre of mass, so that a pull has no lever.
    const Pose X_OG = FromAbove({0, 0, -cup_.press_m});
    return Balances(CupWrenches(*box_, cup_, X_OG, cup_.press_m, 1, 8), load);
  }

  const CupSpec cup_ = SmallCup().cup;
  const std::shared_ptr<const ObjectModel> box_ = BoxPart({0.05, 0.05, 0.05}, 0.2, 0.5);
};

TEST_F(CupHolds, PullUpToTheVacuum) {
  EXPECT_TRUE(Balanced({0, 0, -0.99 * cup_.vacuum_n}, Vector3d::Zero()));
  EXPECT_FALSE(Balanced({0, 0, -1.01 * cup_.vacuum_n}, Vector3d::Zero()));
}

TEST_F(CupHolds, MomentUpToItsLimit) {
  // Eight points make the rim: the limit lies between cos(22.5 degrees) and 1.
  EXPECT_TRUE(Balanced(Vector3d::Zero(), {0.92 * cup_.moment_limit_nm, 0, 0}));
  EXPECT_FALSE(Balanced(Vector3d::Zero(), {1.01 * cup_.moment_limit_nm, 0, 0}));
}

TEST_F(CupHolds, ShearUpToFrictionAndLessWhilePulled) {
  const double limit_n = 0.5 * cup_.friction * cup_.vacuum_n;
  EXPECT_TRUE(Balanced({0.92 * limit_n, 0, 0}, Vector3d::Zero()));
  EXPECT_FALSE(Balanced({1.01 * limit_n, 0, 0}, Vector3d::Zero()));
  EXPECT_FALSE(Balanced({0.92 * limit_n, 0, -0.5 * cup_.vacuum_n}, Vector3d::Zero()));
}

// The planner's polytope is the joint's limit as near as 8 points of the ring and 8 edges of a cone
// are to a circle (cos(22.5 degrees) each), and forces on the ring to the ellipsoid of shear and
// torsion: sqrt(2) of it where both use one point of the ring, 1 / sqrt(2) where bending has put
// all on one side of it.
TEST_F(CupHolds, WhatTheJointHolds) {
  Rng rng(3);
  const double friction = 0.5 * cup_.friction, radius_m = RingRadius_m(cup_);
  for (int i = 0; i < 500; ++i) {
    LipLoad load;  // of the part on the cup, in G
    const Vector3d force = rng.UnitVector(), torque = rng.UnitVector();
    load.force_n = cup_.vacuum_n * Vector3d(force.x() * friction, force.y() * friction, force.z());
    load.torque_nm = rng.Uniform(0, 1) * cup_.vacuum_n * radius_m *
                     Vector3d(torque.x(), torque.y(), torque.z() * friction);
    // Scaled to just within and just beyond; a load that presses needs no more than that.
    double low = 0, high = 1;
    for (int k = 0; k < 40; ++k) {
      const double scale = 0.5 * (low + high);
      const LipLoad scaled{scale * load.force_n, scale * load.torque_nm};
      (ShareOfLimit(cup_, friction, scaled) < 1 ? low : high) = scale;
    }
    if (high == 1) continue;  // held in full
    // x of W is x of G, y and z turn over.
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
}  // namespace pickbed
