#include "eval/bop/estimate_dataset.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "scenes/base/files.h"
#include "scenes/image/image_io.h"
#include "tests/eval/bop_small_dataset.h"
#include "tests/support/error_of.h"
#include "tests/support/temporary_folder.h"

namespace pickbed::tests {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

class EstimateDatasetTest : public testing::Test {
 protected:
  static constexpr int kImages = 3;
  static constexpr uint16_t kConstantDepth = 6000;
  // The data set is made once, because it is made in forked processes.
  static void SetUpTestSuite() {
    made_ = new TemporaryFolder;
    MakeSmall(made_->path(), 1, kImages);
  }
  static void TearDownTestSuite() { delete made_; }
  // In images of constant depth the estimator has nothing to do. Estimates that are written are
  // tested end to end.
  EstimateDatasetTest() {
    fs::copy(made_->path(), root(), fs::copy_options::recursive);
    for (int image = 0; image < kImages; ++image) FillDepth(image, kConstantDepth);
  }
  fs::path root() const { return folder_.path() / "set"; }
  fs::path scene() const { return root() / "test" / "000001"; }
  fs::path Depth(int image) const {
    return scene() / "depth" / ("00000" + std::to_string(image) + ".png");
  }
  fs::path Color(int image) const {
    return scene() / "rgb" / ("00000" + std::to_string(image) + ".png");
  }
  void FillDepth(int image, uint16_t value) const {
    Image<uint16_t> depth = ReadPng16(Depth(image));
    for (uint16_t& reading : depth.pixels()) reading = value;
    WriteFileAtomically(Depth(image), EncodePng(depth, 3));
  }
  static EstimateDatasetOptions Options() {
    EstimateDatasetOptions options;
    options.estimator.name = "ppf";
    options.estimator.min_score = 0;
    return options;
  }
  // Calls `after` with the number of images that are done.
  DatasetEstimates Run(const EstimateDatasetOptions& options = Options(),
                       const std::function<void(size_t)>& after = {}) {
    result_ = {};
    EstimateDataset(root(), "test", options, result_, [&](const EstimateDatasetProgress&) {
      if (after) after(result_.done);
    });
    return result_;
  }

  static TemporaryFolder* made_;
  TemporaryFolder folder_;
  DatasetEstimates result_;
};
TemporaryFolder* EstimateDatasetTest::made_ = nullptr;

TEST_F(EstimateDatasetTest, ImagesBeforeAFileThatBreaksAreKept) {
  EXPECT_EQ(Run().done, kImages);
  const std::string message = ErrorOf([&] {
    Run(Options(), [&](size_t done) {
      if (done == 1) WriteFileAtomically(Color(1), "");
    });
  });
  EXPECT_THAT(message, HasSubstr(Color(1).string()));
  EXPECT_EQ(result_.images, kImages);
  EXPECT_EQ(result_.done, 1);
}

TEST_F(EstimateDatasetTest, StopsBetweenImages) {
  EstimateDatasetOptions options = Options();
  options.stop = [&] { return result_.done == 2; };
  const DatasetEstimates result = Run(options);
  EXPECT_EQ(result.done, 2);
  EXPECT_EQ(result.images, kImages);
  options.stop = [] { return true; };
  EXPECT_EQ(Run(options).done, 0);
}

TEST_F(EstimateDatasetTest, AnImageWithoutReadingsIsSkippedWithAWarning) {
  FillDepth(0, 0);
  FillDepth(1, 0);
  EstimateDatasetOptions options = Options();
  std::vector<std::string> warnings;
  options.on_warning = [&](const std::string& line) { warnings.push_back(line); };
  const DatasetEstimates result = Run(options);
  EXPECT_EQ(result.done, kImages);
  EXPECT_THAT(warnings,
              testing::Contains(testing::AllOf(HasSubstr("image 1/0"), HasSubstr("2 images"))));
}

TEST_F(EstimateDatasetTest, TheNotesNameTheWarningsOfTheirImageOnly) {
  FillDepth(1, 0);
  const DatasetEstimates result = Run();
  ASSERT_EQ(result.notes.size(), kImages);
  size_t poses = 0;
  for (const DatasetImageNote& note : result.notes) {
    poses += note.poses;
    const bool is_empty = note.image_id == 1;
    const auto no_reading = testing::Contains(HasSubstr("no pixel of the depth image"));
    EXPECT_EQ(testing::Matches(no_reading)(note.warnings), is_empty) << note.image_id;
    EXPECT_EQ(note.has_background, !is_empty) << note.image_id;
  }
  EXPECT_EQ(poses, result.estimates.size());
  EXPECT_THAT(DatasetImagesCsv(result.notes),
              testing::StartsWith("scene_id,im_id,poses,background_recognised,warnings\n1,0,"));
}

TEST_F(EstimateDatasetTest, ARegionWithoutReadingsIsReported) {
  EstimateDatasetOptions options = Options();
  options.region = ParseRegion("camera:9,9,9,10,10,10");
  std::vector<std::string> warnings;
  options.on_warning = [&](const std::string& line) { warnings.push_back(line); };
  const DatasetEstimates outside = Run(options);
  EXPECT_TRUE(outside.estimates.empty());
  EXPECT_THAT(outside.notes.at(0).warnings,
              testing::Contains("the region of interest has no depth reading"));
  EXPECT_THAT(warnings, testing::Contains(HasSubstr(
                            fmt::format("has no depth reading in {0} of {0} images", kImages))));
  warnings.clear();
  options.region = ParseRegion("camera:-9,-9,0.01,9,9,9");
  Run(options);
  EXPECT_THAT(warnings, testing::Not(testing::Contains(HasSubstr("has no depth reading"))));
}

TEST_F(EstimateDatasetTest, AnErrorInEveryImageIsRefusedWithTheFolder) {
  for (int image = 0; image < kImages; ++image) FillDepth(image, 1);  // 0.1 mm
  EXPECT_THAT(ErrorOf([&] { Run(); }), HasSubstr((root() / "test").string() + ": image 1/0"));
}

}  // namespace
}  // namespace pickbed::tests
