#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "perception/completion/completion_network.h"
#include "tests/perception/completion_networks/small_networks.h"

namespace pickbed::perception {
namespace {

std::unique_ptr<ViewedSolid> BoxSolid(const Eigen::Vector3f& half_m) {
  return std::make_unique<TracedSolid>(
      [half_m](std::span<const Eigen::Vector3f> points_O, std::span<float> distances_m) {
        for (size_t i = 0; i < points_O.size(); ++i) {
          distances_m[i] = (points_O[i].cwiseAbs() - half_m).maxCoeff();
        }
      },
      Eigen::AlignedBox3f(-half_m, half_m));
}

TEST(TrainingSample, TheVolumeHasTheTruthAtTheCentersOfTheCells) {
  const auto solid = SphereSolid(0.05f);
  Rng rng(3);
  const RandomView drawn = DrawView(*solid, {}, {}, rng);
  const CompletionSample sample = MakeSample(*solid, drawn, 16, rng, true);
  ASSERT_EQ(sample.volume.size(), static_cast<size_t>(kInputVolume));
  const CompletionInput input(drawn.view);
  const CompletionCube& cube = input.cube();
  const double cell_m = cube.side_m / kInputCells;
  double volume_m3 = 0;
  for (const int8_t value : sample.volume) volume_m3 += value > 0 ? std::pow(cell_m, 3) : 0;
  EXPECT_NEAR(volume_m3, 4.0 / 3 * std::numbers::pi * std::pow(0.05, 3), 2e-5);
}

TEST(VolumeVae, ObservedCellsKeepWhatWasSeen) {
  const CompletionNetwork network(SmallNetwork("vae"), 1);
  const CompletionInput input(UsualSphereView());
  const std::vector<int8_t> channels = input.Channels();
  const CompletionCube& cube = input.cube();
  std::vector<Eigen::Vector3f> empty_C, surface_C;
  const auto at = [&](int channel, int x, int y, int z) {
    const int cell = (z * kInputCells + y) * kInputCells + x;
    return channels[channel * kInputVolume + cell] > 64;
  };
  for (int z = 0; z < kInputCells; ++z) {
    for (int y = 0; y < kInputCells; ++y) {
      for (int x = 0; x < kInputCells; ++x) {
        const Eigen::Vector3f center = Eigen::Vector3f(x, y, z) + Eigen::Vector3f::Constant(0.5f);
        const Eigen::Vector3f p_C = cube.origin_C + cube.side_m / kInputCells * center;
        if (at(2, x, y, z)) empty_C.push_back(p_C);
        if (at(1, x, y, z)) surface_C.push_back(p_C);
      }
    }
  }
  ASSERT_GT(empty_C.size(), 100u);
  ASSERT_GT(surface_C.size(), 20u);
  for (const float p : network.Probabilities(input, empty_C)) EXPECT_LT(p, 0.01);
  for (const float p : network.Probabilities(input, surface_C)) EXPECT_GT(p, 0.99);
}

// Views are aligned, so a turned view has the turned completion without any training.
TEST(VolumeVae, ATurnedViewHasTheTurnedCompletion) {
  const CompletionNetwork network(SmallNetwork("vae"), 1);
  const auto solid = BoxSolid({0.06f, 0.03f, 0.02f});
  Rng rng(5);
  const CompletionSample sample = MakeSample(*solid, DrawView(*solid, {}, {}, rng), 128, rng, true);
  const auto completed = [&](int turn) {
    const TurnedSample turned{&sample, turn};
    return network.Probabilities(BatchOf(std::span(&turned, 1)));
  };
  const std::vector<float> expected = completed(0);
  for (int turn = 1; turn < kCubeTurns; ++turn) {
    const std::vector<float> values = completed(turn);
    for (size_t i = 0; i < values.size(); ++i) ASSERT_NEAR(values[i], expected[i], 1e-3) << turn;
  }
}

}  // namespace
}  // namespace pickbed::perception
