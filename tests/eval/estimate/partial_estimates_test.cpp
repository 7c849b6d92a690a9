#include "eval/estimate/partial_estimates.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <vector>

#include "scenes/base/files.h"
#include "tests/support/error_of.h"
#include "tests/support/temporary_folder.h"

namespace pickbed::tests {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

constexpr char kIdentity[] = "seed: 1\n# model 0123\n";

class PartialEstimatesTest : public testing::Test {
 protected:
  fs::path Named(const std::string& end) const { return folder_.path() / ("ppf_set" + end); }
  PartialEstimates Begun(bool resume, const std::string& identity = kIdentity) const {
    PartialEstimates files(folder_.path(), "ppf_set");
    files.Begin(identity, resume);
    return files;
  }
  // An image with a warning of two lines, as a program of a user may give it.
  static DatasetImageNote NoteOf(int image, size_t poses) {
    return {1, image, poses, true, {"a \"quoted\" text,\nwith a second line"}};
  }
  static std::vector<DatasetEstimate> EstimatesOf(int image, size_t poses) {
    DatasetEstimate estimate;
    estimate.scene_id = 1;
    estimate.image_id = image;
    estimate.X_CO.translation() = Eigen::Vector3d(1.0 / 3, 0.1, 0.7);
    return {poses, estimate};
  }
  static void AddImages(PartialEstimates& files, int first, int last) {
    for (int image = first; image < last; ++image) {
      files.Add(NoteOf(image, image), EstimatesOf(image, image));
    }
  }

  TemporaryFolder folder_;
};

// A process can be killed after any byte that it writes.
TEST_F(PartialEstimatesTest, AResumedRunHasTheBytesOfAnUndisturbedOne) {
  constexpr int kImages = 4;
  PartialEstimates whole = Begun(false);
  AddImages(whole, 0, kImages);
  whole.Finish();
  const std::string csv = ReadFileBytes(Named(".csv")),
                    images = ReadFileBytes(Named(".images.csv"));
  PartialEstimates stopped = Begun(false);
  AddImages(stopped, 0, 3);
  const std::string partial = ReadFileBytes(Named(".partial.csv"));
  const std::string partial_images = ReadFileBytes(Named(".partial.images.csv"));
  const std::string third = csv.substr(partial.size());
  std::vector<std::pair<std::string, std::string>> states;  // of both files
  for (size_t i = 0; i <= third.size(); ++i) {
    states.emplace_back(partial + third.substr(0, i), partial_images);
  }
  for (size_t i = partial_images.size(); i < images.size(); ++i) {
    states.emplace_back(csv, images.substr(0, i));
  }
  for (const auto& [estimates, notes] : states) {
    WriteFileAtomically(Named(".partial.csv"), estimates);
    WriteFileAtomically(Named(".partial.images.csv"), notes);
    WriteFileAtomically(Named(".partial.yaml"), kIdentity);
    PartialEstimates resumed = Begun(true);
    ASSERT_EQ(resumed.finished(), (std::set<ListedImage>{{1, 0}, {1, 1}, {1, 2}}));
    AddImages(resumed, 3, kImages);
    resumed.Finish();
    ASSERT_EQ(ReadFileBytes(Named(".csv")), csv);
    ASSERT_EQ(ReadFileBytes(Named(".images.csv")), images);
    ASSERT_EQ(resumed.poses(), 0 + 1 + 2 + 3);
    ASSERT_FALSE(fs::exists(Named(".partial.yaml")));
  }
}

TEST_F(PartialEstimatesTest, ARunThatEndedBetweenTheRenamesIsComplete) {
  PartialEstimates stopped = Begun(false);
  AddImages(stopped, 0, 3);
  const std::string csv = ReadFileBytes(Named(".partial.csv"));
  fs::rename(Named(".partial.csv"), Named(".csv"));
  PartialEstimates resumed = Begun(true);
  EXPECT_EQ(resumed.finished().size(), 3u);
  resumed.Finish();
  EXPECT_EQ(ReadFileBytes(Named(".csv")), csv);
  EXPECT_TRUE(fs::exists(Named(".images.csv")));
  EXPECT_FALSE(fs::exists(Named(".partial.yaml")));
}

TEST_F(PartialEstimatesTest, TheResultsOfAnEarlierRunAreNotTaken) {
  PartialEstimates complete = Begun(false);
  AddImages(complete, 1, 4);
  complete.Finish();
  PartialEstimates stopped = Begun(false);
  AddImages(stopped, 1, 3);
  fs::remove(Named(".partial.csv"));
  const std::string csv = ReadFileBytes(Named(".csv"));
  EXPECT_THAT(ErrorOf([&] { Begun(true); }), HasSubstr("do not fit each other"));
  EXPECT_EQ(ReadFileBytes(Named(".csv")), csv);
}

TEST_F(PartialEstimatesTest, ARunThatEndedAfterTheRenamesIsNotInterrupted) {
  PartialEstimates complete = Begun(false);
  AddImages(complete, 0, 3);
  complete.Finish();
  const std::string csv = ReadFileBytes(Named(".csv"));
  WriteFileAtomically(Named(".partial.yaml"), kIdentity);
  EXPECT_THAT(ErrorOf([&] { Begun(true); }), HasSubstr("no " + Named(".partial.yaml").string()));
  EXPECT_FALSE(fs::exists(Named(".partial.yaml")));
  EXPECT_EQ(ReadFileBytes(Named(".csv")), csv);
}

TEST_F(PartialEstimatesTest, ABegunRunWritesNothingBeforeItsFirstImage) {
  PartialEstimates files = Begun(false);
  EXPECT_TRUE(fs::is_empty(folder_.path()));
  files.Finish();
  EXPECT_TRUE(fs::exists(Named(".csv")));
}

TEST_F(PartialEstimatesTest, AnotherRunDoesNotTakeTheImagesOfAnInterruptedOne) {
  EXPECT_THAT(ErrorOf([&] { Begun(true); }), HasSubstr("no " + Named(".partial.yaml").string()));
  PartialEstimates stopped = Begun(false);
  AddImages(stopped, 0, 2);
  const std::string before = ReadFileBytes(Named(".partial.csv"));
  EXPECT_THAT(ErrorOf([&] { Begun(false); }), HasSubstr("(images: 2)"));
  EXPECT_THAT(ErrorOf([&] { Begun(true, "seed: 2\n# model 0123\n"); }),
              HasSubstr("(seed: 1 before, 2 now)"));
  EXPECT_THAT(ErrorOf([&] { Begun(true, "seed: 1\n# model 0124\n"); }),
              HasSubstr("(trained model has changed)"));
  EXPECT_EQ(ReadFileBytes(Named(".partial.csv")), before);
}

TEST_F(PartialEstimatesTest, FilesThatDoNotFitEachOtherAreRefused) {
  PartialEstimates stopped = Begun(false);
  AddImages(stopped, 1, 3);
  const std::string csv = ReadFileBytes(Named(".partial.csv"));
  const std::string images = ReadFileBytes(Named(".partial.images.csv"));
  const auto message = [&](const std::string& estimates, const std::string& notes) {
    WriteFileAtomically(Named(".partial.csv"), estimates);
    WriteFileAtomically(Named(".partial.images.csv"), notes);
    return ErrorOf([&] { Begun(true); });
  };
  const auto refused = HasSubstr("do not fit each other");
  EXPECT_THAT(message("", images), refused);
  EXPECT_THAT(message(csv, ""), refused);
  EXPECT_THAT(message(csv, "scene,image\n"), refused);
  // An estimate is missing, or belongs to another image.
  EXPECT_THAT(message(csv.substr(0, csv.rfind('\n', csv.size() - 2) + 1), images), refused);
  std::string other = csv;
  other.replace(other.rfind("\n1,2,") + 1, 3, "1,9");
  EXPECT_THAT(message(other, images), refused);
  // An image twice.
  EXPECT_THAT(message(csv, images + images.substr(images.find('\n') + 1)), refused);
  EXPECT_EQ(message(csv, images), "no error");
}

}  // namespace
}  // namespace pickbed::tests
