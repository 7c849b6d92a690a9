#include "grasp/plan/object_shape.h"

#include <gtest/gtest.h>

#include "tests/grasp/plan/plan_fixture.h"

namespace pickbed::tests {
namespace {

class ObjectShapeTest : public PlanFixture {
 protected:
  ObjectShape Shape(const PlanOptions& options = {}) const {
    return MakeShape({bin_, poses_, candidates_, cloud_, objects_, gripper_}, ObjectId{0}, options);
  }
};

TEST_F(ObjectShapeTest, PointsAreOnTheSurfaceAndEdgesOfTheObject) {
  const ObjectShape shape = Shape();
  EXPECT_NEAR(shape.thickness_m, 0.05, 0.001) << "a cube of 5 cm";
  // The largest coordinate of a point on the surface of the cube is half an edge.
  const auto to_surface_m = [](const Eigen::Matrix3Xd& points_O) {
    return (points_O.cwiseAbs().colwise().maxCoeff().array() - 0.025).abs().maxCoeff();
  };
  EXPECT_LT(to_surface_m(shape.points_O), 1e-6);
  EXPECT_LT(to_surface_m(shape.obstacle_O), 1e-6);
  EXPECT_GT(shape.obstacle_O.cols(), shape.points_O.cols()) << "edge points are missing";
}

TEST_F(ObjectShapeTest, CandidatesBeyondTheStrokeHaveNoOpening) {
  candidates_ = {{GraspCandidate{}, GraspCandidate{}}};
  candidates_[0][0].width_m = 0.5 * gripper_.hand.stroke_m;
  candidates_[0][1].width_m = 1.5 * gripper_.hand.stroke_m;
  const ObjectShape shape = Shape();
  ASSERT_EQ(shape.openings_m.size(), 2u);
  ASSERT_TRUE(shape.openings_m[0].has_value());
  EXPECT_GT(*shape.openings_m[0], candidates_[0][0].width_m);
  EXPECT_FALSE(shape.openings_m[1].has_value());
}

}  // namespace
}  // namespace pickbed::tests
