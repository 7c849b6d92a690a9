#include "eval/trial/stage_hash.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <set>

#include "eval/cell/simulated_cell.h"
#include "eval/store/results_store.h"
#include "eval/store/schema.h"
#include "eval/trial/observer.h"
#include "tests/eval/cube_scenario.h"
#include "tests/support/temporary_folder.h"

namespace pickbed::tests {
namespace {

Scene TwoInstances() {
  Scene scene;
  scene.objects = {{InstanceId{0}, ObjectId{0}, Translation({0.1, 0.2, 0.3})},
                   {InstanceId{4}, ObjectId{1}, Pose::Identity()}};
  return scene;
}

Observation SmallView() {
  Observation view;
  view.frame.intrinsics = {3, 2, 680, 680, 319.5, 239.5};
  view.frame.depth_m = Image<float>(3, 2, 0.5f);
  view.frame.color = Image<Rgb8>(3, 2, {1, 2, 3});
  view.ids = Image<uint16_t>(3, 2, 1);
  view.visible_fractions = {0.5, 1};
  return view;
}

AttemptRecord SomePick() {
  AttemptRecord record;
  record.hypotheses.resize(2);
  record.hypotheses[0].score = 0.9;
  record.grasp = Grasp();
  record.grasps_rejected = {{"collision", 3}};
  return record;
}

// Changes a double by one unit in the last place.
void Nudge(double& value) { value = std::nextafter(value, std::numeric_limits<double>::max()); }

TEST(StateHash, DependsOnEveryNumberOfAScene) {
  const std::vector<std::function<void(Scene&)>> changes = {
      [](Scene& s) { Nudge(s.bin.inner_size_m.z()); },
      [](Scene& s) { Nudge(s.bin.friction); },
      [](Scene& s) { Nudge(s.objects[1].X_WO.translation().y()); },
      [](Scene& s) { Nudge(s.objects[0].X_WO.matrix()(2, 0)); },
      [](Scene& s) { s.objects[1].instance = InstanceId{5}; },
      [](Scene& s) { s.objects[1].object = ObjectId{0}; },
      [](Scene& s) { std::swap(s.objects[0], s.objects[1]); },
      [](Scene& s) { s.objects.pop_back(); },
  };
  std::set<uint64_t> hashes = {HashOf(TwoInstances())};
  for (const auto& change : changes) {
    Scene scene = TwoInstances();
    change(scene);
    hashes.insert(HashOf(scene));
  }
  EXPECT_EQ(hashes.size(), changes.size() + 1);
  EXPECT_TRUE(hashes.contains(HashOf(TwoInstances())));
}

TEST(StateHash, DependsOnEveryPixel) {
  std::set<uint64_t> hashes = {HashOf(SmallView())};
  for (int pixel = 0; pixel < 6; ++pixel) {
    Observation depth = SmallView(), color = SmallView(), ids = SmallView();
    depth.frame.depth_m.data()[pixel] = std::nextafter(0.5f, 1.f);
    color.frame.color.data()[pixel].b ^= 1;
    ids.ids.data()[pixel] ^= 0x8000;
    for (const Observation* view : {&depth, &color, &ids}) hashes.insert(HashOf(*view));
  }
  EXPECT_EQ(hashes.size(), 1u + 3 * 6);
  Observation other = SmallView();
  Nudge(other.visible_fractions[1]);
  EXPECT_TRUE(hashes.insert(HashOf(other)).second);
}

// A hash that only multiplies loses the top bits of doubles, such as the sign.
TEST(StateHash, TwoFlippedSignsDoNotCancel) {
  Scene a = TwoInstances(), b = TwoInstances();
  a.objects[1].X_WO = Translation({0.25, 0.5, 0.75});
  b.objects[1].X_WO = Translation({-0.25, -0.5, 0.75});
  EXPECT_NE(HashOf(a), HashOf(b));
}

// As for a random function, flipping one input bit flips about half of the 64 output bits: 32 with
// a standard deviation of 4. In a sound hash, none of the 64 x 20 flips comes near 0.
TEST(StateHash, OneInputBitFlipsHalfOfTheOutputBits) {
  const auto hash_of = [](int word, int bit) {
    StateHash hash;
    for (int i = 0; i < 20; ++i) hash.Add(i == word ? uint64_t{1} << bit : uint64_t{0});
    return hash.Add(7).Add(7).value();
  };
  const uint64_t unchanged = hash_of(-1, 0);
  double sum = 0;
  for (int word = 0; word < 20; ++word) {
    for (int bit = 0; bit < 64; ++bit) {
      const int flipped = std::popcount(hash_of(word, bit) ^ unchanged);
      EXPECT_GE(flipped, 8) << word << " " << bit;
      sum += flipped;
    }
  }
  EXPECT_NEAR(sum / (20 * 64), 32, 1);
}

template <typename T>
void Change(T& value) {
  if constexpr (std::is_same_v<T, bool>) {
    value = !value;
  } else if constexpr (std::is_same_v<T, double>) {
    Nudge(value);
  } else if constexpr (std::is_same_v<T, Pose>) {
    Nudge(value.matrix()(1, 2));
  } else if constexpr (std::is_same_v<T, FailureReason>) {
    value = value == FailureReason::kNone ? FailureReason::kNoGrasp : FailureReason::kNone;
  } else if constexpr (std::is_same_v<T, std::string>) {
    value += "x";
  } else {
    ++value;
  }
}

// Every stored column of grasp and outcome enters one of the two hashes, except the columns that
// identify the attempt or its image, or follow from the scene, which has its own hash.
TEST(StateHash, DependsOnEveryStoredColumnOfAnAttempt) {
  const std::set<std::string> not_state = {
      "trial",      "attempt", "executed",        "target",          "band",     "pick_of_image",
      "fill_level", "layer",   "instances_above", "instances_below", "pose_free"};
  AttemptRow row{0, SomePick(), true, Grasp()};
  const uint64_t grasp = HashOfGrasp(row.record), outcome = HashOfOutcome(row.record);
  int columns = 0;
  row.Visit([&]<typename T>(const char* name, T& value) {
    const std::string column = name;
    if (not_state.contains(column) || column.starts_with("hash_")) return;
    const T before = value;
    Change(value);
    AttemptRecord changed = row.record;
    changed.grasp = row.grasp;
    const bool of_grasp = column.starts_with("grasp_");
    EXPECT_EQ(HashOfGrasp(changed) != grasp, of_grasp) << column;
    EXPECT_EQ(HashOfOutcome(changed) != outcome, !of_grasp) << column;
    value = before;
    ++columns;
  });
  EXPECT_GT(columns, 20);
}

TEST(StateHash, MissingGraspDiffersFromADefaultGrasp) {
  AttemptRecord record = SomePick();
  const uint64_t with = HashOfGrasp(record);
  record.grasp.reset();
  EXPECT_NE(HashOfGrasp(record), with);
  record.grasps_rejected["collision"] = 4;
  EXPECT_NE(HashOfGrasp(record), HashOfGrasp(AttemptRecord()));
}

TEST(StateHash, RenamedCausesKeepTheHashOfTheirFormerName) {
  AttemptRecord now = SomePick(), before = SomePick();
  for (const RenamedCause& cause : kRenamedCauses) {
    now.grasps_rejected[std::string(cause.is)] = 2;
    before.grasps_rejected[std::string(cause.was)] = 2;
  }
  EXPECT_EQ(HashOfGrasp(now), HashOfGrasp(before));
  EXPECT_NE(HashOfGrasp(now), HashOfGrasp(SomePick()));
}

TEST(StateHash, DependsOnEveryHypothesis) {
  const uint64_t before = HashOfHypotheses(SomePick());
  AttemptRecord score = SomePick(), pose = SomePick(), object = SomePick(), fewer = SomePick();
  Nudge(score.hypotheses[1].score);
  Nudge(pose.hypotheses[1].X_WO.translation().x());
  object.hypotheses[0].object = ObjectId{1};
  fewer.hypotheses.pop_back();
  for (const AttemptRecord* changed : {&score, &pose, &object, &fewer}) {
    EXPECT_NE(HashOfHypotheses(*changed), before);
  }
}

TEST(StateHash, RecordReadBackHasTheSameHashes) {
  const TemporaryFolder folder;
  ScenarioSpec spec = CubeScenario(2);
  spec.estimator.noise_mm = 3;
  TrialResult result = TrialRunner(spec, EasyCube()).Run(BinIndex{0});
  ASSERT_FALSE(result.attempts.empty());
  result.attempts[0].outcome.slip_m = -0.0;  // SQLite keeps whole numbers as integers
  ResultsStore store(folder.path(), "seed: 1");
  store.Write(result);
  const std::vector<TrialResult> read = store.ReadAll();
  for (const AttemptRecord& attempt : result.attempts) {
    const AttemptRecord& again = read.at(0).attempts.at(attempt.attempt);
    EXPECT_EQ(HashOfHypotheses(again), HashOfHypotheses(attempt));
    EXPECT_EQ(HashOfGrasp(again), HashOfGrasp(attempt));
    EXPECT_EQ(HashOfOutcome(again), HashOfOutcome(attempt));
    EXPECT_EQ(again.hashes, attempt.hashes);
  }
}

// Records the stages that a trial reports to its observer.
struct Stages : TrialObserver {
  std::vector<std::pair<int, TrialStage>> seen;
  std::vector<uint64_t> scenes;
  void OnStage(TrialStage stage, const AttemptState& state) override {
    seen.push_back({state.record.attempt, stage});
    EXPECT_NE(state.record.hashes[stage], 0u);
    if (stage == TrialStage::kScene) scenes.push_back(HashOf(state.scene));
    EXPECT_EQ(state.view != nullptr, stage >= TrialStage::kImage);
    EXPECT_EQ(state.hypotheses != nullptr, stage >= TrialStage::kHypotheses);
  }
};

TEST(TrialObserver, IsNotifiedOfEachStageOfEachAttemptInOrder) {
  Stages stages;
  const TrialResult result = TrialRunner(CubeScenario(4), EasyCube()).Run(BinIndex{0}, &stages);
  ASSERT_GE(result.attempts.size(), 2u);
  ASSERT_EQ(stages.seen.size(), 5 * result.attempts.size());
  for (size_t i = 0; i < stages.seen.size(); ++i) {
    EXPECT_EQ(stages.seen[i], std::make_pair(static_cast<int>(i / 5), kTrialStages[i % 5]));
  }
  for (const AttemptRecord& attempt : result.attempts) {
    EXPECT_EQ(attempt.hashes[TrialStage::kScene], stages.scenes[attempt.attempt]);
    EXPECT_EQ(attempt.hashes[TrialStage::kHypotheses], HashOfHypotheses(attempt))
        << "depends only on the record";
    EXPECT_EQ(attempt.hashes[TrialStage::kGrasp], HashOfGrasp(attempt));
    EXPECT_EQ(attempt.hashes[TrialStage::kOutcome], HashOfOutcome(attempt));
  }
  EXPECT_NE(stages.scenes[0], stages.scenes[1]) << "one instance fewer";
}

TEST(TrialObserver, HashesDependOnlyOnSeedAndTrialNumber) {
  const auto hashes_of = [](uint64_t seed, int trial) {
    ScenarioSpec spec = CubeScenario(2);
    spec.seed = seed;
    std::vector<StageHashes> hashes;
    for (const AttemptRecord& attempt :
         TrialRunner(spec, EasyCube()).Run(BinIndex(trial)).attempts) {
      hashes.push_back(attempt.hashes);
    }
    return hashes;
  };
  EXPECT_EQ(hashes_of(3, 1), hashes_of(3, 1));
  EXPECT_NE(hashes_of(3, 1).at(0), hashes_of(3, 2).at(0));
  EXPECT_NE(hashes_of(3, 1).at(0), hashes_of(4, 1).at(0));
}

}  // namespace
}  // namespace pickbed::tests
