#include "eval/train/page.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "eval/train/draw.h"
#include "perception/features/patch.h"
#include "scenes/base/files.h"
#include "scenes/image/image_io.h"
#include "tests/support/temporary_folder.h"

namespace pickbed::tests {
namespace {

TEST(Stretches, EachValueIsCoveredOnce) {
  const std::vector<Stretch> stretches = Stretches({1, 3, 5, 7, 2}, 2);
  ASSERT_EQ(stretches.size(), 2u);
  EXPECT_DOUBLE_EQ(stretches[0].mean, 2);
  EXPECT_DOUBLE_EQ(stretches[0].x, 1);
  EXPECT_DOUBLE_EQ(stretches[1].mean, 14.0 / 3);
  EXPECT_DOUBLE_EQ(stretches[1].minimum, 2);
  EXPECT_DOUBLE_EQ(stretches[1].maximum, 7);
  EXPECT_EQ(Stretches({1, 2}, 50).size(), 2u);
  EXPECT_TRUE(Stretches({}, 50).empty());
}

// Points of a tilted plane in space keep their distances, and the longer axis comes first.
TEST(PrincipalCoordinates, RecoverTheAxesOfATiltedPlane) {
  const Eigen::Vector3f along = Eigen::Vector3f(1, 2, 2) / 3,
                        across = Eigen::Vector3f(2, 1, -2) / 3;
  Eigen::MatrixXf rows(4, 3);
  rows.row(0) = 5 * along;
  rows.row(1) = -5 * along;
  rows.row(2) = 2 * across;
  rows.row(3) = -2 * across;
  rows.rowwise() += Eigen::RowVector3f(7, 8, 9);
  const Eigen::MatrixX2f places = PrincipalCoordinates(rows);
  EXPECT_NEAR(std::abs(places(0, 0)), 5, 1e-4);
  EXPECT_NEAR(places(0, 0) + places(1, 0), 0, 1e-4);
  EXPECT_NEAR(std::abs(places(2, 1)), 2, 1e-4);
  EXPECT_NEAR(places(2, 0), 0, 1e-4);
}

TEST(DrawPatch, BackgroundIsDarkAndSurfacesShowNormals) {
  std::vector<int8_t> patch(kPatchValues, 0);
  std::fill_n(patch.begin(), kPatchArea, 127);  // no surface
  patch[5] = 0;                                 // one surface pixel that faces the camera
  patch[3 * kPatchArea + 5] = -127;
  const Image<Rgb8> image = DrawPatch(patch, PatchChannels::kDepthNormals, 2);
  EXPECT_EQ(image.width(), 64);
  EXPECT_EQ(image(10, 0), image(11, 1)) << "a pixel is not drawn as a square";
  EXPECT_LT(image(8, 0).b, 50);
  EXPECT_GT(image(10, 0).b, 150);
  EXPECT_GT(image(10, 0).b, image(10, 0).r);
}

TEST(DrawPatch, ColorIsUnchanged) {
  std::vector<int8_t> patch(kPatchValues, 0);
  std::fill_n(patch.begin(), kPatchArea, 127);
  patch[5] = 0;
  patch[kPatchArea + 5] = 127;  // red
  patch[2 * kPatchArea + 5] = patch[3 * kPatchArea + 5] = -127;
  const Image<Rgb8> image = DrawPatch(patch, PatchChannels::kDepthColor, 1);
  EXPECT_EQ(image(5, 0), (Rgb8{255, 0, 0}));
  EXPECT_LT(image(4, 0).b, 50) << "background is dark, not medium grey";
}

PatchPairs Pairs(int count) {
  PatchPairs pairs;
  for (LabelledPatches* patches : {&pairs.anchors, &pairs.codes}) {
    patches->values.assign(count * kPatchValues, 10);
    patches->X_PO.assign(count, Pose::Identity());
  }
  return pairs;
}

TEST(WriteTrainingPage, PageHasStatisticsCurvesAndPictures) {
  const TemporaryFolder temporary;
  auto model = std::make_shared<ObjectModel>();
  model->name = "a <part>";
  const ObjectSet objects{model};
  TrainingReport report;
  report.loss_history = {0.5, 0.25};
  report.recall_history = {{0, 0.125, 0.5, {0.125}, {0.5}}, {2, 0.625, 0.75, {0.625}, {0.75}}};
  report.object_auc = {0.875};
  report.rehearsed = {0};
  report.plateau_iteration = 2;
  report.phases = {{"network", 12.5}};
  report.held_out.queries = {Pairs(3)};
  report.pairs = {Pairs(4)};
  for (int i = 0; i < 3; ++i) {
    HeldOutAnswer answer;
    answer.query = i;
    answer.view_O = Eigen::Vector3d::UnitZ();
    answer.descriptor = Eigen::VectorXf::Constant(4, static_cast<float>(i));
    answer.found.assign(kPatchValues, 3);
    answer.right = i == 0;
    report.answers.push_back(answer);
  }
  const std::filesystem::path folder = temporary.path() / "page";
  const std::string unwritten =
      WriteTrainingPage(folder, {"model", "ideal", "seed: 0\nbatch: 7", report, objects});
  // Three patches side by side in each of three tiles.
  EXPECT_GT(ReadPng(folder / "answers.png").width(), 3 * 96);
  EXPECT_EQ(ReadFileBytes(folder / "curves.csv"),
            "step,loss,recall_at_1,recall_at_8,a <part>\n0,,0.125000,0.500000,0.125000\n"
            "2,0.250000,0.625000,0.750000,0.625000\n");
  EXPECT_THAT(ReadFileBytes(folder / "timings.csv"), testing::HasSubstr("network,12.5"));
  if (!unwritten.empty()) GTEST_SKIP() << unwritten;
  const std::string html = ReadFileBytes(folder / "index.html");
  for (const char* text :
       {"a &lt;part&gt;", "0.625", "0.875", "plateau at step 2", "Held-out recall", "embedding.png",
        "answers.png", "pairs.png", "batch: 7", "12.5"}) {
    EXPECT_THAT(html, testing::HasSubstr(text));
  }
}

}  // namespace
}  // namespace pickbed::tests
