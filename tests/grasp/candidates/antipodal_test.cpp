#include "grasp/candidates/antipodal.h"

#include <gtest/gtest.h>

#include "grasp/candidates/pad_contact.h"
#include "tests/grasp/grasp_scenes.h"

namespace pickbed::tests {
namespace {

using Eigen::Vector3d;

std::shared_ptr<const ObjectModel> SphereObject(double radius_m, double friction) {
  auto model = std::make_shared<ObjectModel>();
  model->mesh_O = SphereMesh(radius_m);
  model->mass = UniformMassProperties(model->mesh_O, 0.1);
  model->friction = friction;
  model->diameter_m = 2 * radius_m;
  model->mesh_hash = MeshHash(model->mesh_O);
  return model;
}

// Fewer candidates than by default: enough for these tests, in a tenth of the time.
const AntipodalOptions kQuick{.candidates = 300, .max_pairs = 150};

std::vector<GraspCandidate> Grasps(const ObjectModel& model, const ParallelJaw& jaw = SmallJaw()) {
  Rng rng(1);
  return AntipodalGrasps(model, jaw.hand, jaw.clearance_m, rng, kQuick);
}

TEST(Antipodal, BoxIsGraspedByOppositeFaces) {
  const double friction = 0.5;
  const auto box = BoxObject({0.05, 0.05, 0.05}, 0.2, friction);
  const auto grasps = Grasps(*box);
  ASSERT_GT(grasps.size(), 100u);
  for (const GraspCandidate& grasp : grasps) {
    // The closing axis is inside the friction cone of a face normal, which limits the width.
    const Vector3d axis = grasp.X_OG.linear().col(0);
    const double cosine = axis.cwiseAbs().maxCoeff();
    EXPECT_LE(std::acos(std::min(1.0, cosine)), std::atan(friction));
    EXPECT_GT(grasp.width_m, 0.049);
    EXPECT_LT(grasp.width_m, 0.074);
    EXPECT_GT(grasp.quality, 0);
    EXPECT_LE(grasp.quality, 1);
    // The center of the pads is beside the box, and the closing line passes through both faces.
    const Vector3d center = grasp.X_OG * Vector3d(0, 0, -0.010);
    int along = 0;
    axis.cwiseAbs().maxCoeff(&along);
    for (int i = 0; i < 3; ++i) {
      if (i != along) {
        EXPECT_LT(std::abs(center[i]), 0.025 + 0.012);
      }
    }
  }
}

TEST(Antipodal, BestGraspOfABoxIsNormalToItsFaces) {
  const auto grasps = Grasps(*BoxObject({0.05, 0.05, 0.05}, 0.2));
  const auto best = std::max_element(grasps.begin(), grasps.end(),
                                     [](auto& a, auto& b) { return a.quality < b.quality; });
  EXPECT_GT(best->X_OG.linear().col(0).cwiseAbs().maxCoeff(), 0.9999);
  EXPECT_NEAR(best->width_m, 0.05, 0.0005);
}

TEST(Antipodal, ClosingLinePassesThroughTheSphereCenter) {
  const double radius = 0.025, friction = 0.4;
  const auto grasps = Grasps(*SphereObject(radius, friction));
  ASSERT_GT(grasps.size(), 50u);
  for (const GraspCandidate& grasp : grasps) {
    const Vector3d center_G = grasp.X_OG.inverse() * Vector3d::Zero();
    EXPECT_NEAR(center_G.x(), 0, 0.0005);
    EXPECT_NEAR(center_G.y(), 0, 0.004);
    EXPECT_LT(center_G.z(), 0.001);  // the pads reach to the equator
    EXPECT_NEAR(grasp.width_m, 2 * radius, 0.0015);
  }
}

TEST(Antipodal, NoGraspIfEveryWidthExceedsTheStroke) {
  EXPECT_TRUE(Grasps(*BoxObject({0.12, 0.13, 0.14}, 0.5)).empty());
}

TEST(Antipodal, PlateIsGraspedOnlyAcrossItsThickness) {
  const auto grasps = Grasps(*BoxObject({0.12, 0.10, 0.02}, 0.3));
  ASSERT_FALSE(grasps.empty());
  for (const auto& grasp : grasps) EXPECT_GT(std::abs(grasp.X_OG.linear()(2, 0)), 0.9);
}

TEST(Antipodal, HandDoesNotIntersectTheObject) {
  // Between the bars of the tee there is room for the closing line of a pair, but not for the palm.
  const auto object = TeeObject();
  const ParallelJaw gripper = SmallJaw();
  Rng rng(5);
  const SurfacePoints surface = SpreadPoints(object->mesh_O, 0.001, 1000, 50000, rng);
  const auto grasps = Grasps(*object, gripper);
  ASSERT_GT(grasps.size(), 50u);
  for (const auto& grasp : grasps) {
    const auto boxes = HandBoxes(gripper.hand, grasp.width_m + 2 * gripper.clearance_m);
    const PointColumns rotated = Rotated(surface.points_O, grasp.X_OG.linear());
    EXPECT_TRUE(HandClearsObject(rotated, grasp.X_OG, boxes, 0));
  }
}

TEST(Antipodal, LowFrictionNarrowsTheCone) {
  const double friction = 0.1;
  for (const auto& grasp : Grasps(*BoxObject({0.05, 0.05, 0.05}, 0.2, friction))) {
    const double cosine = grasp.X_OG.linear().col(0).cwiseAbs().maxCoeff();
    EXPECT_LE(std::acos(std::min(1.0, cosine)), 0.8 * std::atan(friction) + 1e-9);
  }
}

TEST(Antipodal, GraspNearTheCenterOfMassIsBetter) {
  const auto bar = BoxObject({0.15, 0.03, 0.02}, 0.4);
  double near_center = 0, near_end = 0;
  for (const auto& grasp : Grasps(*bar)) {
    const double off = std::abs(grasp.X_OG.translation().x());
    if (off < 0.01) near_center = std::max(near_center, grasp.quality);
    if (off > 0.05) near_end = std::max(near_end, grasp.quality);
  }
  EXPECT_GT(near_end, 0);
  EXPECT_GT(near_center, 1.3 * near_end);
}

TEST(Antipodal, CandidatesAreLimitedAndSpaced) {
  AntipodalOptions options = kQuick;
  options.candidates = 60;
  Rng rng(2);
  const ParallelJaw jaw = SmallJaw();
  const auto grasps = AntipodalGrasps(*TeeObject(), jaw.hand, jaw.clearance_m, rng, options);
  EXPECT_EQ(grasps.size(), 60u);
  for (size_t i = 0; i < grasps.size(); ++i) {
    for (size_t k = 0; k < i; ++k) {
      const Pose& a = grasps[i].X_OG;
      const Pose& b = grasps[k].X_OG;
      EXPECT_TRUE((a.translation() - b.translation()).norm() > options.spacing_m ||
                  RotationAngleRad(a.linear(), b.linear()) > options.spacing_rad);
    }
  }
}

TEST(Antipodal, SameSeedGivesSameBytes) {
  const auto a = Grasps(*TeeObject());
  const auto b = Grasps(*TeeObject());
  ASSERT_EQ(a.size(), b.size());
  for (size_t i = 0; i < a.size(); ++i) {
    EXPECT_EQ(a[i].X_OG.matrix(), b[i].X_OG.matrix());
    EXPECT_EQ(a[i].quality, b[i].quality);
  }
}

}  // namespace
}  // namespace pickbed::tests
