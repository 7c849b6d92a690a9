#include "eval/state_hash.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <set>

#include "eval/results_rows.h"
#include "eval/results_store.h"
#include "eval/trial_observer.h"
#include "eval/virtual_cell.h"
#include "tests/eval/cube_scenario.h"
#include "tests/support/temporary_folder.h"

namespace pickbed {
namespace {

Scene TwoParts() {
  Scene scene;
  scene.objects = {{0, 0, Translation({0.1, 0.2, 0.3})}, {4, 1, Pose::Identity()}};
  return scene;
}

View SmallView() {
  View view;
  view.frame.intrinsics.width = 3;
  view.frame.intrinsics.height = 2;
  view.frame.depth_m = Image<float>(3, 2, 0.5f);
  view.frame.color = Image<Rgb8>(3, 2, {1, 2, 3});
  view.ids = Image<uint16_t>(3, 2, 1);
  view.visible_fractions = {0.5, 1};
  return view;
}

PickRecord SomePick() {
  PickRecord record;
  record.hypotheses.resize(2);
  record.hypotheses[0].score = 0.9;
  record.grasp = Grasp();
  record.grasps_rejected = {{"collision", 3}};
  return record;
}

// The least change that a double can have.
void Nudge(double& value) { value = std::nextafter(value, std::numeric_limits<double>::max()); }

TEST(StateHash, EachNumberOfASceneCounts) {
  const std::vector<std::function<void(Scene&)>> changes = {
      [](Scene& s) { Nudge(s.bin.inner_size_m.z()); },
      [](Scene& s) { Nudge(s.bin.friction); },
      [](Scene& s) { Nudge(s.objects[1].X_WO.translation().y()); },
      [](Scene& s) { Nudge(s.objects[0].X_WO.matrix()(2, 0)); },
      [](Scene& s) { s.objects[1].instance = 5; },
      [](Scene& s) { s.objects[1].object = 0; },
      [](Scene& s) { std::swap(s.objects[0], s.objects[1]); },
      [](Scene& s) { s.objects.pop_back(); },
  };
  std::set<uint64_t> hashes = {HashOf(TwoParts())};
  for (const auto& change : changes) {
    Scene scene = TwoParts();
    change(scene);
    hashes.insert(HashOf(scene));
  }
  EXPECT_EQ(hashes.size(), changes.size() + 1);
  EXPECT_TRUE(hashes.contains(HashOf(TwoParts())));
}

TEST(StateHash, EachPixelCounts) {
  std::set<uint64_t> hashes = {HashOf(SmallView())};
  for (int pixel = 0; pixel < 6; ++pixel) {
    View depth = SmallView(), color = SmallView(), ids = SmallView();
    depth.frame.depth_m.data()[pixel] = std::nextafter(0.5f, 1.f);
    color.frame.color.data()[pixel].b ^= 1;
    ids.ids.data()[pixel] ^= 0x8000;
    for (const View* view : {&depth, &color, &ids}) hashes.insert(HashOf(*view));
  }
  EXPECT_EQ(hashes.size(), 1u + 3 * 6);
  View other = SmallView();
  Nudge(other.visible_fractions[1]);
  EXPECT_TRUE(hashes.insert(HashOf(other)).second);
}

// The top bits of doubles are where a hash by multiplication alone forgets.
TEST(StateHash, TwoFlippedSignsDoNotCancel) {
  Scene a = TwoParts(), b = TwoParts();
  a.objects[1].X_WO = Translation({0.25, 0.5, 0.75});
  b.objects[1].X_WO = Translation({-0.25, -0.5, 0.75});
  EXPECT_NE(HashOf(a), HashOf(b));
}

// Flipping any one bit of any word turns half of the 64 bits, as of a random function: 32 with a
// standard deviation of 4 each, so of 64 x 20 flips none is near 0 but by a fault.
TEST(StateHash, ABitTurnsHalfOfAllBits) {
  const auto hash_of = [](int word, int bit) {
    StateHash hash;
    for (int i = 0; i < 20; ++i) hash.Add(i == word ? uint64_t{1} << bit : uint64_t{0});
    return hash.Add(7).Add(7).value();
  };
  const uint64_t unchanged = hash_of(-1, 0);
  double sum = 0;
  for (int word = 0; word < 20; ++word) {
    for (int bit = 0; bit < 64; ++bit) {
      const int turned = std::popcount(hash_of(word, bit) ^ unchanged);
      EXPECT_GE(turned, 8) << word << " " << bit;
      sum += turned;
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
  } else if constexpr (std::is_same_v<T, Loss>) {
    value = value == Loss::kNone ? Loss::kNoGrasp : Loss::kNone;
  } else if constexpr (std::is_same_v<T, std::string>) {
    value += "x";
  } else {
    ++value;
  }
}

// All that the store keeps of grasp and outcome is in one of the two hashes, but for what says
// which look it was.
TEST(StateHash, EachColumnOfAPickCounts) {
  const std::set<std::string> not_state = {"trial", "pick", "executed", "target", "band"};
  PickRow row{0, SomePick(), true, Grasp()};
  const uint64_t grasp = HashOfGrasp(row.record), outcome = HashOfOutcome(row.record);
  int columns = 0;
  row.Visit([&]<typename T>(const char* name, T& value) {
    const std::string column = name;
    if (not_state.contains(column) || column.starts_with("hash_")) return;
    const T before = value;
    Change(value);
    PickRecord changed = row.record;
    changed.grasp = row.grasp;
    const bool of_grasp = column.starts_with("grasp_");
    EXPECT_EQ(HashOfGrasp(changed) != grasp, of_grasp) << column;
    EXPECT_EQ(HashOfOutcome(changed) != outcome, !of_grasp) << column;
    value = before;
    ++columns;
  });
  EXPECT_GT(columns, 20);
}

TEST(StateHash, NoGraspIsNotTheFirstGrasp) {
  PickRecord record = SomePick();
  const uint64_t with = HashOfGrasp(record);
  record.grasp.reset();
  EXPECT_NE(HashOfGrasp(record), with);
  record.grasps_rejected["collision"] = 4;
  EXPECT_NE(HashOfGrasp(record), HashOfGrasp(PickRecord()));
}

TEST(StateHash, EachHypothesisCounts) {
  const uint64_t before = HashOfHypotheses(SomePick());
  PickRecord score = SomePick(), pose = SomePick(), object = SomePick(), fewer = SomePick();
  Nudge(score.hypotheses[1].score);
  Nudge(pose.hypotheses[1].X_WO.translation().x());
  object.hypotheses[0].object = 1;
  fewer.hypotheses.pop_back();
  for (const PickRecord* changed : {&score, &pose, &object, &fewer}) {
    EXPECT_NE(HashOfHypotheses(*changed), before);
  }
}

TEST(StateHash, ARecordReadBackHasTheHashesOfTheOneWritten) {
  const TemporaryFolder folder;
  ScenarioSpec spec = CubeScenario(2);
  spec.estimator.noise_mm = 3;
  TrialResult result = TrialRunner(spec, EasyCube()).Run(0);
  ASSERT_FALSE(result.picks.empty());
  result.picks[0].outcome.slip_m = -0.0;  // SQLite keeps whole numbers as integers
  ResultsStore store(folder.path(), "seed: 1");
  store.Write(result);
  const std::vector<TrialResult> read = store.ReadAll();
  for (const PickRecord& pick : result.picks) {
    const PickRecord& again = read.at(0).picks.at(pick.pick);
    EXPECT_EQ(HashOfHypotheses(again), HashOfHypotheses(pick));
    EXPECT_EQ(HashOfGrasp(again), HashOfGrasp(pick));
    EXPECT_EQ(HashOfOutcome(again), HashOfOutcome(pick));
    EXPECT_EQ(again.hashes, pick.hashes);
  }
}

// What a trial tells of its stages.
struct Stages : TrialObserver {
  std::vector<std::pair<int, TrialStage>> seen;
  std::vector<uint64_t> scenes;
  void OnStage(TrialStage stage, const LookState& look) override {
    seen.push_back({look.record.pick, stage});
    EXPECT_NE(look.record.hashes[stage], 0u);
    if (stage == TrialStage::kScene) scenes.push_back(HashOf(look.scene));
    EXPECT_EQ(look.view != nullptr, stage >= TrialStage::kImage);
    EXPECT_EQ(look.hypotheses != nullptr, stage >= TrialStage::kHypotheses);
  }
};

TEST(TrialObserver, SeesEachStageOfEachLookInOrder) {
  Stages stages;
  const TrialResult result = TrialRunner(CubeScenario(4), EasyCube()).Run(0, &stages);
  ASSERT_GE(result.picks.size(), 2u);
  ASSERT_EQ(stages.seen.size(), 5 * result.picks.size());
  for (size_t i = 0; i < stages.seen.size(); ++i) {
    EXPECT_EQ(stages.seen[i], std::make_pair(static_cast<int>(i / 5), kTrialStages[i % 5]));
  }
  for (const PickRecord& pick : result.picks) {
    EXPECT_EQ(pick.hashes[TrialStage::kScene], stages.scenes[pick.pick]);
    EXPECT_EQ(pick.hashes[TrialStage::kHypotheses], HashOfHypotheses(pick))
        << "of the record alone";
    EXPECT_EQ(pick.hashes[TrialStage::kGrasp], HashOfGrasp(pick));
    EXPECT_EQ(pick.hashes[TrialStage::kOutcome], HashOfOutcome(pick));
  }
  EXPECT_NE(stages.scenes[0], stages.scenes[1]) << "a part less";
}

TEST(TrialObserver, HashesAreAFunctionOfSeedAndNumber) {
  const auto hashes_of = [](uint64_t seed, int trial) {
    ScenarioSpec spec = CubeScenario(2);
    spec.seed = seed;
    std::vector<StageHashes> hashes;
    for (const PickRecord& pick : TrialRunner(spec, EasyCube()).Run(trial).picks) {
      hashes.push_back(pick.hashes);
    }
    return hashes;
  };
  EXPECT_EQ(hashes_of(3, 1), hashes_of(3, 1));
  EXPECT_NE(hashes_of(3, 1).at(0), hashes_of(3, 2).at(0));
  EXPECT_NE(hashes_of(3, 1).at(0), hashes_of(4, 1).at(0));
}

}  // namespace
}  // namespace pickbed
