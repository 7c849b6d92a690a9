#include "perception/networks/descriptor_network.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "perception/features/patch.h"
#include "perception/networks/patch_network.h"
#include "scenes/base/error.h"
#include "scenes/base/random.h"
#include "tests/support/layer.h"

namespace pickbed::tests {
namespace {

std::vector<int8_t> RandomPatches(int count, uint64_t seed) {
  Rng rng(seed);
  std::vector<int8_t> values(count * kPatchValues);
  for (int8_t& value : values) value = static_cast<int8_t>(rng.Index(255) - 127);
  return values;
}

// Pairs that show the same tilt of a plane. The poses are on a circle, and their distance is half
// the chord.
TrainingBatch TiltedPlanes(int count, uint64_t seed) {
  Rng rng(seed);
  TrainingBatch batch;
  batch.count = count;
  std::vector<double> angles;
  const auto append = [&](double angle, std::vector<int8_t>& values) {
    for (int channel = 0; channel < kPatchChannels; ++channel) {
      for (int i = 0; i < kPatchArea; ++i) {
        const double x = i % kPatchPixels / 16.0 - 1, y = i / kPatchPixels / 16.0 - 1;
        const double depth = 0.5 * (std::cos(angle) * x + std::sin(angle) * y);
        const double value[] = {depth, -0.5 * std::cos(angle), -0.5 * std::sin(angle), -0.7};
        values.push_back(static_cast<int8_t>(127 * 0.9 * value[channel] + rng.Uniform(-6, 6)));
      }
    }
  };
  for (int i = 0; i < count; ++i) {
    angles.push_back(rng.Uniform(0, 6.28));
    append(angles.back(), batch.anchors);
    append(angles.back(), batch.codes);
  }
  for (const double a : angles) {
    for (const double b : angles) batch.pose_distance.push_back(std::abs(std::sin(0.5 * (a - b))));
  }
  return batch;
}

class EveryNetwork : public testing::TestWithParam<const char*> {};

TEST_P(EveryNetwork, RowsAreIndependentOfTheBatch) {
  const DescriptorNetwork network({GetParam(), 16}, 3);
  const std::vector<int8_t> patches = RandomPatches(70, 1);
  const std::vector<float> all = network.Describe(patches);
  ASSERT_EQ(all.size(), 70u * 16u);
  for (int i = 0; i < 70; ++i) {
    double squared = 0;
    for (int d = 0; d < 16; ++d) squared += all[i * 16 + d] * all[i * 16 + d];
    if (FindPatchNetwork(GetParam()).unit_rows) {
      EXPECT_NEAR(squared, 1, 1e-4);
    }
  }
  const std::vector<float> last =
      network.Describe({patches.data() + 69 * kPatchValues, kPatchValues});
  for (int d = 0; d < 16; ++d) EXPECT_NEAR(last[d], all[69 * 16 + d], 1e-4);
}

TEST_P(EveryNetwork, SeedDeterminesTheWeights) {
  const NetworkOptions options{GetParam(), 16};
  EXPECT_EQ(DescriptorNetwork(options, 5).Weights(), DescriptorNetwork(options, 5).Weights());
  EXPECT_NE(DescriptorNetwork(options, 5).Weights(), DescriptorNetwork(options, 6).Weights());
}

INSTANTIATE_TEST_SUITE_P(Table, EveryNetwork, testing::ValuesIn([] {
                           std::vector<const char*> names;
                           for (const auto& row : PatchNetworkTable()) names.push_back(row.name);
                           return names;
                         }()));

class EveryLoss : public testing::TestWithParam<const char*> {};

TEST_P(EveryLoss, LossFallsAndPosesSeparate) {
  DescriptorNetwork network({"convolutional", 8}, 1);
  LossOptions loss;
  loss.kind = GetParam();
  double first = 0, last = 0;
  for (int i = 0; i < 60; ++i) {
    const double value = network.TrainStep(TiltedPlanes(24, i), loss, 2e-3);
    if (i < 5) first += value;
    if (i >= 55) last += value;
  }
  EXPECT_LT(last, 0.7 * first);

  // New pairs: the partner is nearer than poses that are a quarter rotation away.
  const TrainingBatch batch = TiltedPlanes(24, 1000);
  const std::vector<float> anchors = network.Describe(batch.anchors);
  const std::vector<float> codes = network.Describe(batch.codes);
  int right = 0, compared = 0;
  for (int i = 0; i < 24; ++i) {
    const auto similarity = [&](int j) {
      double sum = 0;
      for (int d = 0; d < 8; ++d) sum += anchors[i * 8 + d] * codes[j * 8 + d];
      return sum;
    };
    for (int j = 0; j < 24; ++j) {
      if (batch.pose_distance[i * 24 + j] < 0.7) continue;
      ++compared;
      right += similarity(i) > similarity(j);
    }
  }
  EXPECT_GT(right, 0.95 * compared);
}

INSTANTIATE_TEST_SUITE_P(Kinds, EveryLoss, testing::Values("triplet", "infonce"));

TEST(DescriptorNetwork, RestoredTrainingStateContinuesIdentically) {
  const LossOptions loss;
  DescriptorNetwork straight({"convolutional", 8}, 1), stopped({"convolutional", 8}, 1);
  for (int i = 0; i < 3; ++i) straight.TrainStep(TiltedPlanes(8, i), loss, 1e-3);
  for (int i = 0; i < 3; ++i) stopped.TrainStep(TiltedPlanes(8, i), loss, 1e-3);
  DescriptorNetwork resumed({"convolutional", 8}, 77);
  resumed.RestoreTrainingState(stopped.TrainingState());
  for (int i = 3; i < 6; ++i) {
    EXPECT_EQ(straight.TrainStep(TiltedPlanes(8, i), loss, 1e-3),
              resumed.TrainStep(TiltedPlanes(8, i), loss, 1e-3));
  }
  EXPECT_EQ(straight.Weights(), resumed.Weights());
}

TEST(DescriptorNetwork, WrongWeightsStatesAndKindsAreRefused) {
  DescriptorNetwork network({"convolutional", 8}, 1);
  EXPECT_THROW(network.SetWeights(std::vector<float>(7)), InputError);
  EXPECT_THROW(network.RestoreTrainingState("not an archive"), InputError);
  try {
    DescriptorNetwork({"convolutionl", 8}, 1);
    FAIL() << "an unknown network was made";
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr("did you mean 'convolutional'"));
  }
}

TEST(DescriptorNetwork, RoundTripKeepsTheWeights) {
  const DescriptorNetwork from({"convolutional", 8}, 1);
  DescriptorNetwork to({"convolutional", 8}, 2);
  to.SetWeights(from.Weights());
  const std::vector<int8_t> patches = RandomPatches(3, 4);
  EXPECT_EQ(from.Describe(patches), to.Describe(patches));
}

}  // namespace
}  // namespace pickbed::tests
