#include "eval/segments/labelled_cloud.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstring>
#include <limits>

#include "eval/frames/cloud_file.h"
#include "tests/support/error_of.h"
#include "tests/support/temporary_folder.h"

namespace pickbed::tests {
namespace {

using ::testing::HasSubstr;

template <typename T>
void Append(T value, std::string& bytes) {
  bytes.append(reinterpret_cast<const char*>(&value), sizeof(value));
}

// A plane with a hole, as a binary PCD of 8 x 6 points.
std::string PlaneCloud(const CameraIntrinsics& k, const std::string& fields = "x y z label rgba") {
  std::string bytes =
      "# .PCD v0.7\nVERSION 0.7\nFIELDS " + fields +
      "\nSIZE 4 4 4 4 4\nTYPE F F F U U\nCOUNT 1 1 1 1 1\nWIDTH 8\nHEIGHT 6\nPOINTS 48\n"
      "DATA binary\n";
  for (int v = 0; v < 6; ++v) {
    for (int u = 0; u < 8; ++u) {
      const float z = 0.5f + 0.01f * static_cast<float>(u);
      const bool is_hole = u == 3 && v == 2;
      const Eigen::Vector3f p = BackProject(k, u, v, z).cast<float>();
      for (int axis = 0; axis < 3; ++axis) {
        Append(is_hole ? std::numeric_limits<float>::quiet_NaN() : p[axis], bytes);
      }
      Append(static_cast<uint32_t>(u < 4 ? 20 : 30), bytes);
      Append(static_cast<uint32_t>(0x102030), bytes);
    }
  }
  return bytes;
}

const CameraIntrinsics kCamera(8, 6, 12, 13, 3.6, 2.7);

TEST(ReadLabelledCloud, FindsDepthLabelsColorAndIntrinsics) {
  const TemporaryFolder folder;
  const LabelledCloud cloud = ReadLabelledCloud(folder.Write("a.pcd", PlaneCloud(kCamera)));
  EXPECT_NEAR(cloud.frame.intrinsics.fx(), 12, 1e-3);
  EXPECT_NEAR(cloud.frame.intrinsics.fy(), 13, 1e-3);
  EXPECT_NEAR(cloud.frame.intrinsics.cx(), 3.6, 1e-3);
  EXPECT_NEAR(cloud.frame.intrinsics.cy(), 2.7, 1e-3);
  EXPECT_FLOAT_EQ(cloud.frame.depth_m(5, 1), 0.55f);
  EXPECT_EQ(cloud.frame.depth_m(3, 2), 0) << "a hole has no reading";
  EXPECT_EQ(cloud.labels(3, 0), 20);
  EXPECT_EQ(cloud.labels(4, 5), 30);
  EXPECT_EQ(cloud.frame.color(0, 0), (Rgb8{0x10, 0x20, 0x30}));
}

TEST(ReadLabelledCloud, RefusesOtherFilesInOneLine) {
  const TemporaryFolder folder;
  const auto error = [&](const std::string& bytes) {
    const auto file = folder.Write("b.pcd", bytes);
    return ErrorOf([&] { ReadLabelledCloud(file); });
  };
  EXPECT_THAT(error("no cloud"), HasSubstr("DATA"));
  EXPECT_THAT(error(PlaneCloud(kCamera, "x y z tag rgba")), HasSubstr("no field label"));
  EXPECT_THAT(error(PlaneCloud(kCamera).substr(0, 400)), HasSubstr("too short"));
  EXPECT_THAT(error(PlaneCloud(kCamera, "x y label z rgba")), HasSubstr("field z has no floats"));
  EXPECT_THAT(error("FIELDS x y z label\nWIDTH 48\nHEIGHT 1\nDATA binary\n"),
              HasSubstr("organised"));
  EXPECT_THAT(error("FIELDS x y z label\nWIDTH 8\nHEIGHT 6\nDATA ascii\n"), HasSubstr("ascii"));
}

TEST(DecompressLzf, RepeatsAndCopies) {
  // "abc", then six bytes from three back, then "d".
  const std::string packed(
      "\x02"
      "abc"
      "\x80\x02\x00"
      "d",
      8);
  EXPECT_EQ(DecompressLzf(packed, 10, "test"), "abcabcabcd");
  EXPECT_THAT(ErrorOf([&] { DecompressLzf(packed, 9, "test"); }), HasSubstr("damaged"));
  EXPECT_THAT(ErrorOf([&] { DecompressLzf(packed.substr(0, 5), 10, "test"); }),
              HasSubstr("damaged"));
  EXPECT_THAT(ErrorOf([] { DecompressLzf("\x20\x7f", 3, "test"); }), HasSubstr("damaged"));
  // A false size must not reserve memory.
  EXPECT_THAT(ErrorOf([&] { DecompressLzf(packed, size_t{1} << 60, "test"); }),
              HasSubstr("damaged"));
}

TEST(ReadLabelledCloud, ReadsTheKinectCloudsOfTheSegmentationDatabase) {
  const std::filesystem::path file = std::filesystem::path(PICKBED_TEST_DATA) / "mosd/learn8.pcd";
  if (!std::filesystem::exists(file)) GTEST_SKIP() << file << " is absent";
  const LabelledCloud cloud = ReadLabelledCloud(file);
  EXPECT_NEAR(cloud.frame.intrinsics.fx(), 525, 0.1);
  EXPECT_NEAR(cloud.frame.intrinsics.fy(), 525, 0.1);
  EXPECT_NEAR(cloud.frame.intrinsics.cx(), 319.5, 0.1);
  EXPECT_EQ(std::count(cloud.labels.pixels().begin(), cloud.labels.pixels().end(), 20), 25705);
}

}  // namespace
}  // namespace pickbed::tests
