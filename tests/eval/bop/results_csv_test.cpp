#include "eval/bop/results_csv.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "scenes/base/error.h"
#include "scenes/base/random.h"
#include "tests/support/temporary_folder.h"

namespace pickbed::tests {
namespace {

using testing::HasSubstr;

const std::string kHeader = "scene_id,im_id,obj_id,score,R,t,time\n";
const std::string kGood = "1,2,3,0.5,1 0 0 0 1 0 0 0 1,10 -20 900.5,0.25\n";

class BopResults : public testing::Test {
 protected:
  std::vector<DatasetEstimate> Read(const std::string& text) const {
    return ReadEstimates(folder_.Write("results.csv", text));
  }
  void ExpectRefused(const std::string& text, const std::string& line, const std::string& why) {
    try {
      Read(text);
      FAIL() << "was accepted: " << text;
    } catch (const InputError& error) {
      EXPECT_THAT(error.what(), HasSubstr("results.csv" + line));
      EXPECT_THAT(error.what(), HasSubstr(why));
      EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos);
    }
  }
  const TemporaryFolder folder_;
};

TEST_F(BopResults, LineGivesTheHandWrittenValues) {
  const std::vector<DatasetEstimate> estimates = Read(kHeader + kGood);
  ASSERT_EQ(estimates.size(), 1u);
  EXPECT_EQ(estimates[0].scene_id, 1);
  EXPECT_EQ(estimates[0].image_id, 2);
  EXPECT_EQ(estimates[0].object_id, 3);
  EXPECT_EQ(estimates[0].score, 0.5);
  EXPECT_EQ(estimates[0].time_s, 0.25);
  EXPECT_TRUE(estimates[0].X_CO.linear().isIdentity(0));
  EXPECT_TRUE(estimates[0].X_CO.translation().isApprox(Eigen::Vector3d(0.01, -0.02, 0.9005)));
}

// Spreadsheets write a UTF-8 byte order mark and Windows line ends.
TEST_F(BopResults, AByteOrderMarkIsSkipped) {
  EXPECT_EQ(Read("\xEF\xBB\xBF" + kHeader + kGood).size(), 1u);
  EXPECT_EQ(Read("\xEF\xBB\xBFscene_id,im_id,obj_id,score,R,t,time\r\n" + kGood).size(), 1u);
  ExpectRefused("\xEF\xBB" + kHeader + kGood, ":1", "not with scene_id");
}

TEST_F(BopResults, RoundTripKeepsAllValues) {
  Rng rng(3);
  std::vector<DatasetEstimate> estimates;
  for (int i = 0; i < 20; ++i) {
    const Eigen::Vector3d p(rng.Normal(), rng.Normal(), 1);
    estimates.push_back(
        {i, 2 * i, 3, rng.Uniform(), MakePose(rng.Rotation().toRotationMatrix(), p), 0.1 * i});
  }
  const std::vector<DatasetEstimate> again = Read(WriteEstimates(estimates));
  ASSERT_EQ(again.size(), estimates.size());
  for (size_t i = 0; i < again.size(); ++i) {
    EXPECT_EQ(again[i].image_id, estimates[i].image_id);
    EXPECT_EQ(again[i].score, estimates[i].score);
    EXPECT_EQ(again[i].X_CO.linear(), estimates[i].X_CO.linear());
    EXPECT_TRUE(again[i].X_CO.isApprox(estimates[i].X_CO, 1e-15));
  }
}

TEST_F(BopResults, BadFilesAreRefusedWithLineNumber) {
  EXPECT_EQ(Read(kHeader + "1,2,3,0.5,1 0 0 0 1 0 0 0 1,10 -20 900,-1.0\n")[0].time_s, -1);
  ExpectRefused(kHeader + "1,2,3,0.5,1 0 0 0 1 0 0 0 1,10 -20 900,-2147483648\n", ":2",
                "time has -2147483648 s; give -1 if it is unknown");
  ExpectRefused("", "", "empty");
  ExpectRefused("scene,image,object\n", ":1", "scene_id,im_id,obj_id,score,R,t,time");
  ExpectRefused(kHeader + kGood + "1,2,3,0.5,1 0 0 0 1 0 0 0 1,10 -20 900\n", ":3", "6 columns");
  ExpectRefused(kHeader + "1,2,3,0.5,1 0 0 0 1 0 0 0,10 -20 900,1\n", ":2", "R has 8 numbers");
  ExpectRefused(kHeader + "1,2,3,0.5,1 0 0 0 1 0 0 0 1,10 nan 900,1\n", ":2", "t 'nan'");
  ExpectRefused(kHeader + "1,2,3,0.5,2 0 0 0 1 0 0 0 1,0 0 900,1\n", ":2", "no rotation");
  ExpectRefused(kHeader + "1,2,3,0.5,1 0 0 0 1 0 0 0 -1,0 0 900,1\n", ":2", "reflection");
  ExpectRefused(kHeader + "1,2.5,3,0.5,1 0 0 0 1 0 0 0 1,0 0 900,1\n", ":2", "im_id '2.5'");
  ExpectRefused(kHeader + kGood + "1,2,4,0.5,1 0 0 0 1 0 0 0 1,0 0 900,3\n", ":3", "whole image");
}

}  // namespace
}  // namespace pickbed::tests
