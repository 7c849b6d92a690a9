// Values that are not finite do not pass from one stage to the next. The timings count them.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

#include "eval/trial/trial.h"
#include "eval/trial/trial_setup.h"
#include "scenes/base/finite_counts.h"
#include "tests/eval/cube_scenario.h"
#include "tests/sim/physics_objects.h"

namespace pickbed::tests {
namespace {

// Returns three grasps that no hand can reach.
class BrokenPlanner : public Planner {
 public:
  PlanResult Plan(const PlannerInput&) override {
    constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
    PlanResult plan;
    Grasp grasp;
    grasp.hypothesis = kNoHypothesis;
    plan.grasps.assign(3, grasp);
    plan.grasps[0].X_WG.translation().x() = kNaN;
    plan.grasps[1].width_m = std::numeric_limits<double>::infinity();
    plan.grasps[2].score = kNaN;
    return plan;
  }
};

TEST(NotFinite, GraspsAreDroppedAndCounted) {
  ScenarioSpec spec = CubeScenario(2);
  spec.planner.name = "cloud_antipodal";
  TrialSetup setup(spec, EasyCube(), {}, {});
  setup.planner = std::make_unique<BrokenPlanner>();
  TakeNotFiniteCounts();
  const TrialResult result = RunTrial(setup, BinIndex(0), nullptr);
  ASSERT_FALSE(result.attempts.empty());
  for (const AttemptRecord& attempt : result.attempts) EXPECT_FALSE(attempt.grasp.has_value());
  ASSERT_TRUE(result.seconds.contains("not_finite/grasps"));
  EXPECT_EQ(result.seconds.at("not_finite/grasps"),
            3 * static_cast<double>(result.attempts.size()));
  EXPECT_TRUE(TakeNotFiniteCounts().empty());
}

}  // namespace
}  // namespace pickbed::tests
