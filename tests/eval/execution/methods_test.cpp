#include "eval/execution/methods.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/eval/execution/executed_dataset.h"

namespace pickbed::tests {
namespace {

DatasetEstimate Scored(int image_id, double score) {
  DatasetEstimate estimate;
  estimate.scene_id = 1;
  estimate.image_id = image_id;
  estimate.object_id = 1;
  estimate.score = score;
  return estimate;
}

TEST(MethodOf, ConfidenceIsTheShareOfLowerScores) {
  const Method method =
      MethodOf("m", {Scored(0, -5), Scored(0, 300), Scored(1, 300), Scored(0, 40)});
  const std::vector<MethodPose>& image = method.images.at({1, 0});
  ASSERT_EQ(image.size(), 3u);
  EXPECT_EQ(image[0].score, 300) << "highest first";
  EXPECT_DOUBLE_EQ(image[0].confidence, (2 + 0.5 * 2) / 4);
  EXPECT_DOUBLE_EQ(image[1].confidence, (1 + 0.5) / 4);
  EXPECT_DOUBLE_EQ(image[2].confidence, 0.5 / 4);
  EXPECT_DOUBLE_EQ(method.images.at({1, 1})[0].confidence, image[0].confidence)
      << "equal scores in different images";
}

TEST(TrueEstimates, PassThroughAResultsFile) {
  const ExecutedDataset set(1, 2);
  const std::vector<DatasetEstimate> truth = set.Truth();
  ASSERT_GT(truth.size(), 2u);
  const std::vector<DatasetEstimate> read = ReadEstimates(set.Write("truth.csv", truth));
  ASSERT_EQ(read.size(), truth.size());
  for (size_t i = 0; i < truth.size(); ++i) {
    EXPECT_EQ(read[i].image_id, truth[i].image_id);
    EXPECT_EQ(read[i].score, truth[i].score);
    EXPECT_TRUE(read[i].X_CO.isApprox(truth[i].X_CO, 1e-14));
    EXPECT_GE(truth[i].score, 0.1);
  }
}

}  // namespace
}  // namespace pickbed::tests
