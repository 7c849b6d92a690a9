#include "grasp/completed/success_network.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "grasp/completed/grasp_rater.h"
#include "scenes/base/byte_blocks.h"
#include "scenes/base/files.h"
#include "scenes/base/random.h"
#include "tests/grasp/cloud/cloud_scene.h"
#include "tests/grasp/completed/shape_source.h"
#include "tests/grasp/grasp_scenes.h"
#include "tests/support/error_of.h"
#include "tests/support/temporary_folder.h"

namespace pickbed::tests {
namespace {

using Eigen::Vector3d;
using ::testing::HasSubstr;

SuccessNetwork RandomNetwork(const std::vector<int>& outputs) {
  Rng rng(3);
  const auto draw = [&](Eigen::Index rows, Eigen::Index columns) -> Eigen::MatrixXf {
    Eigen::MatrixXf values(rows, columns);
    for (Eigen::Index i = 0; i < values.size(); ++i) {
      values.data()[i] = static_cast<float>(0.3 * rng.Normal());
    }
    return values;
  };
  SuccessNetwork network;
  network.training = "made by a test";
  network.mean = draw(kSuccessInputs, 1);
  network.scale = draw(kSuccessInputs, 1).cwiseAbs().array() + 0.1f;
  int inputs = kSuccessInputs;
  for (const int count : outputs) {
    network.layers.push_back({draw(count, inputs), draw(count, 1)});
    inputs = count;
  }
  return network;
}

std::vector<float> RandomInputs(uint64_t seed) {
  Rng rng(seed);
  std::vector<float> inputs;
  for (int i = 0; i < kSuccessInputs; ++i) inputs.push_back(static_cast<float>(rng.Normal()));
  return inputs;
}

// The same sums, one by one, in double precision.
TEST(SuccessNetwork, IsAPerceptronWithRectifiedLayersAndClampedInputs) {
  const SuccessNetwork network = RandomNetwork({5, 3, 1});
  for (const uint64_t seed : {1, 2, 3}) {
    const std::vector<float> inputs = RandomInputs(seed);
    std::vector<double> values;
    for (int i = 0; i < kSuccessInputs; ++i) {
      values.push_back(std::clamp((inputs[i] - network.mean[i]) / network.scale[i], -4.0f, 4.0f));
    }
    for (size_t k = 0; k < network.layers.size(); ++k) {
      std::vector<double> next;
      for (Eigen::Index row = 0; row < network.layers[k].bias.size(); ++row) {
        double sum = network.layers[k].bias[row];
        for (size_t i = 0; i < values.size(); ++i) {
          sum += network.layers[k].weights(row, static_cast<Eigen::Index>(i)) * values[i];
        }
        next.push_back(k + 1 < network.layers.size() ? std::max(0.0, sum) : sum);
      }
      values = next;
    }
    EXPECT_NEAR(network.Chance(inputs), 1 / (1 + std::exp(-values[0])), 1e-5);
  }
}

TEST(SuccessNetwork, AFileGivesTheSameChances) {
  const TemporaryFolder folder;
  const std::filesystem::path file = folder.path() / "a.net";
  const SuccessNetwork network = RandomNetwork({4, 2, 1});
  SaveSuccessNetwork(file, network);
  const SuccessNetwork loaded = LoadSuccessNetwork(file);
  EXPECT_EQ(loaded.training, network.training);
  EXPECT_EQ(loaded.Chance(RandomInputs(1)), network.Chance(RandomInputs(1)));
  EXPECT_NE(loaded.Chance(RandomInputs(1)), network.Chance(RandomInputs(2)));
}

TEST(SuccessNetwork, RefusesMissingAndDamagedFiles) {
  const TemporaryFolder folder;
  const std::filesystem::path file = folder.path() / "a.net";
  const auto error = [&] { return ErrorOf([&] { LoadSuccessNetwork(file); }); };
  EXPECT_THAT(error(), HasSubstr("pickbed train grasps"));
  SaveSuccessNetwork(file, RandomNetwork({4, 1}));
  const std::string bytes = ReadFileBytes(file);
  for (const size_t size : {size_t{0}, size_t{30}, bytes.size() / 2, bytes.size() - 1}) {
    WriteFileAtomically(file, bytes.substr(0, size));
    EXPECT_THAT(error(), HasSubstr("a.net")) << size;
  }
  WriteFileAtomically(file, bytes + "x");
  EXPECT_THAT(error(), HasSubstr("damaged"));
  std::string flipped = bytes;
  flipped[bytes.size() - 9] ^= 0x40;
  WriteFileAtomically(file, flipped);
  EXPECT_THAT(error(), HasSubstr("damaged"));
  WriteFileAtomically(file, "PICKCOMP" + bytes.substr(8));
  EXPECT_THAT(error(), HasSubstr("not a network for grasps"));
}

// Such files have a right check sum, but no program of ours writes them.
TEST(SuccessNetwork, RefusesNetworksThatDoNotFit) {
  const TemporaryFolder folder;
  const std::filesystem::path file = folder.path() / "a.net";
  const auto error_of = [&](const SuccessNetwork& network) {
    SaveSuccessNetwork(file, network);
    return ErrorOf([&] { LoadSuccessNetwork(file); });
  };
  EXPECT_THAT(error_of(RandomNetwork({4, 2})), HasSubstr("one output"));
  EXPECT_THAT(error_of(RandomNetwork({})), HasSubstr("one output"));
  SuccessNetwork network = RandomNetwork({1});
  network.layers[0].weights(0, 7) = std::nanf("");
  EXPECT_THAT(error_of(network), HasSubstr("not finite"));
  network.layers[0].weights(0, 7) = 2e19f;
  EXPECT_THAT(error_of(network), HasSubstr("over 10000"));
  network = RandomNetwork({1});
  network.scale[5] = 0;
  EXPECT_THAT(error_of(network), HasSubstr("positive"));
  network = RandomNetwork({1});
  network.mean.conservativeResize(kSuccessInputs - 1);
  EXPECT_THAT(error_of(network), HasSubstr("inputs"));
  network = RandomNetwork({2, 1});
  network.layers[1].weights.resize(1, 3);
  network.layers[1].weights.setZero();
  EXPECT_THAT(error_of(network), HasSubstr("more weights"));
  network.layers[1].weights.resize(1, 1);
  network.layers[1].weights.setZero();
  EXPECT_THAT(error_of(network), HasSubstr("missing"));
}

// The weight of a long bar turns it out of a hand that holds one end.
TEST(SuccessNetwork, TheShippedOnePrefersTheMiddleOfABarToItsEnd) {
  const Vector3d size_m(0.025, 0.16, 0.03);
  const Pose pose = OnFloor(0, 0, size_m.z(), 0);
  CloudScene scene;
  scene.AddBox(size_m, pose);
  const PlannerInput input = scene.Input();
  ImageSegments segments{{scene.frame().depth_m.width(), scene.frame().depth_m.height(), 0}, {{}}};
  const ImageSegments halves = LeftAndRight(scene);
  ForEachDepthPoint(scene.frame().intrinsics, scene.frame().depth_m,
                    [&](int u, int v, const Vector3d&) {
                      if (halves.labels(u, v) != 0) segments.labels(u, v) = 1;
                    });
  segments.segments[0].center_C = scene.camera().X_CW() * pose.translation();
  const PlanOptions plan;
  const std::vector<OccupancyShape> shapes{BoxShape(size_m, pose)};
  const GraspRater rater(input, Pose::Identity(), segments, shapes, plan);
  const SuccessNetwork network = *SuccessNetworkNamed("grasps");
  const auto chance = [&](double y_m) {
    Grasp grasp;
    grasp.X_WG = FromAbove({0, y_m, size_m.z() - 0.018});
    grasp.width_m = size_m.x();
    return network.Chance(rater.Inputs(grasp, SmallJaw(), GraspedSurface::kCompleted));
  };
  EXPECT_GT(chance(0), 0.8);
  EXPECT_GT(chance(0), chance(0.065) + 0.05);
}

}  // namespace
}  // namespace pickbed::tests
