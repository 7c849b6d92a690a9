#include "eval/success/grasp_examples.h"

#include <gtest/gtest.h>

#include "grasp/completed/success_network.h"
#include "tests/support/layer.h"

namespace pickbed::tests {
namespace {

ExampleOptions OneImage() {
  ExampleOptions options;
  options.shallow_rounds = 1;
  options.shallow_attempts = 1;
  options.best = 2;
  options.random = 1;
  return options;
}

TEST(GraspExamples, AreTheBestAndARandomGraspOfAnImage) {
  int images = 0;
  const GraspExamples examples = MakeGraspExamples(2, OneImage(), [&] { ++images; });
  EXPECT_EQ(images, 1);
  ASSERT_EQ(examples.success.size(), 3u);
  EXPECT_EQ(examples.image, std::vector<int32_t>(3, 0));
  ASSERT_EQ(examples.inputs.size(), 3u * grasp::kSuccessInputs);
  const auto input = [&](int i, int k) { return examples.inputs[i * grasp::kSuccessInputs + k]; };
  for (int i = 0; i < 3; ++i) {
    EXPECT_TRUE(input(i, 0) == 0 || input(i, 0) == 1) << "surface";
    EXPECT_GT(input(i, 3), input(i, 2)) << "an open hand is wider than the object";
    EXPECT_LE(input(i, 3), 20 * 0.0801) << "stroke of the hand";
  }
  const GraspExamples again = MakeGraspExamples(2, OneImage(), [] {});
  EXPECT_EQ(again.inputs, examples.inputs);
  EXPECT_EQ(again.success, examples.success);
}

}  // namespace
}  // namespace pickbed::tests
