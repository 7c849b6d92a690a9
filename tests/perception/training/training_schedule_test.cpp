#include "perception/training/training_schedule.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <stdexcept>

#include "tests/support/layer.h"

namespace pickbed::tests {
namespace {

TEST(TakeTurns, EqualWeightsAlternate) {
  EXPECT_THAT(TakeTurns({1, 1, 1}, 7), testing::ElementsAre(0, 1, 2, 0, 1, 2, 0));
  EXPECT_THAT(TakeTurns({0.1, 0.1, 0.1}, 4), testing::ElementsAre(0, 1, 2, 0));
}

TEST(TakeTurns, FrequencyIsProportionalToTheWeightAndEven) {
  const std::vector<ObjectId> turns = TakeTurns({1, 0.25, 0.25}, 600);
  EXPECT_EQ(std::count(turns.begin(), turns.end(), 0), 400);
  EXPECT_EQ(std::count(turns.begin(), turns.end(), 1), 100);
  for (size_t i = 0; i + 6 <= turns.size(); i += 6) {
    EXPECT_EQ(std::count(turns.begin() + i, turns.begin() + i + 6, 2), 1) << "from position " << i;
  }
  EXPECT_THROW(TakeTurns({1, 0}, 3), std::logic_error);
  EXPECT_THROW(TakeTurns({}, 3), std::logic_error);
}

TrainingOptions Options() {
  TrainingOptions options;
  options.clutter_scenes = 100;
  options.iterations = 1000;
  options.views_share = 0.5;
  options.held_out.every = 100;
  options.held_out.patience = 2;
  options.held_out.gain = 0.01;
  options.held_out.cooling = 0.1;
  return options;
}

HeldOutRecall At(int iteration, double at_1) { return {iteration, at_1, at_1, {at_1}, {at_1}}; }

TEST(TrainingSchedule, RehearsedObjectsGetTheirShareOfScenesAndSteps) {
  const TrainingSchedule schedule({1, 0.1, 0.1}, Options());
  EXPECT_EQ(schedule.iterations(), 1200);
  EXPECT_EQ(schedule.clutter_scenes(), 120);
  EXPECT_EQ(schedule.measure_every(), 120);
  const std::vector<ObjectId>& clutter_scenes = schedule.scene_objects();
  EXPECT_EQ(std::count(clutter_scenes.begin(), clutter_scenes.end(), 1), 10);
}

TEST(TrainingSchedule, EveryObjectIsInAScene) {
  TrainingOptions options = Options();
  options.clutter_scenes = 2;
  const std::vector<ObjectId> clutter_scenes =
      TrainingSchedule({1, 0.01, 0.01}, options).scene_objects();
  EXPECT_EQ(clutter_scenes.size(), 4u);
  for (ObjectId object{0}; object < 3; ++object) {
    EXPECT_EQ(std::count(clutter_scenes.begin(), clutter_scenes.end(), object),
              object == 0 ? 2 : 1);
  }
}

TEST(TrainingSchedule, ScenesArriveUntilTheirShareOfTheSteps) {
  const TrainingSchedule schedule({1}, Options());
  EXPECT_EQ(schedule.WantedScenes(0), 8);
  EXPECT_EQ(schedule.WantedScenes(0.25), 50);
  EXPECT_EQ(schedule.WantedScenes(0.5), 100);
  EXPECT_EQ(schedule.WantedScenes(1), 100);
  for (double share = 0; share < 1; share += 0.01) {
    EXPECT_LE(schedule.WantedScenes(share), schedule.WantedScenes(share + 0.01));
  }
}

TEST(TrainingSchedule, PlateauShortensTheRemainingSchedule) {
  TrainingSchedule schedule({1}, Options());
  std::vector<HeldOutRecall> history{At(0, 0.1), At(100, 0.5), At(200, 0.505)};
  schedule.Watch(history);
  EXPECT_EQ(schedule.plateau_iteration(), -1);
  history.push_back(At(300, 0.509));
  schedule.Watch(history);
  EXPECT_EQ(schedule.plateau_iteration(), 300);
  EXPECT_DOUBLE_EQ(schedule.Share(300), 0.3);
  EXPECT_DOUBLE_EQ(schedule.Share(350), 0.65);
  EXPECT_DOUBLE_EQ(schedule.Share(400), 1);
  EXPECT_EQ(schedule.WantedScenes(0.9), 60) << "no more scenes after the plateau";
  // Measurements during cooling do not move the plateau.
  history.push_back(At(400, 0.9));
  schedule.Watch(history);
  EXPECT_EQ(schedule.plateau_iteration(), 300);
}

TEST(TrainingSchedule, LatePlateauDoesNotLengthenTheSchedule) {
  TrainingSchedule schedule({1}, Options());
  schedule.Watch({At(0, 0.5), At(500, 0.5), At(980, 0.5)});
  EXPECT_EQ(schedule.plateau_iteration(), 980);
  EXPECT_DOUBLE_EQ(schedule.Share(1000), 1);
}

TEST(PlateauOf, SlowGainsAddUpAndPatienceZeroNeverStops) {
  HeldOutOptions options;
  options.patience = 3;
  options.gain = 0.01;
  std::vector<HeldOutRecall> creeping, flat;
  for (int i = 0; i < 30; ++i) {
    creeping.push_back(At(i, 0.006 * i));
    flat.push_back(At(i, 0.3));
  }
  EXPECT_EQ(PlateauOf(creeping, options), -1);
  EXPECT_EQ(PlateauOf(flat, options), 3);
  options.patience = 0;
  EXPECT_EQ(PlateauOf(flat, options), -1);
}

}  // namespace
}  // namespace pickbed::tests
