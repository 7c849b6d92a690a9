#include "eval/frames/cloud_file.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstring>
#include <limits>

#include "eval/frames/ply_rows.h"
#include "tests/support/error_of.h"
#include "tests/support/temporary_folder.h"

namespace pickbed::tests {
namespace {

using ::testing::HasSubstr;

const CameraIntrinsics kCamera(8, 6, 12, 13, 3.6, 2.7);

// A slanted plane with a hole. `size` gives the width and the height of the image.
std::string PlyCloud(const std::string& size, bool is_ascii) {
  std::string bytes = "ply\nformat " + std::string(is_ascii ? "ascii" : "binary_little_endian") +
                      " 1.0\n" + size +
                      "element vertex 48\nproperty float x\nproperty float y\nproperty double z\n"
                      "property uchar red\nproperty uchar green\nproperty uchar blue\nend_header\n";
  for (int v = 0; v < 6; ++v) {
    for (int u = 0; u < 8; ++u) {
      Eigen::Vector3d p = BackProject(kCamera, u, v, 0.5 + 0.01 * u);
      if (u == 3 && v == 2) p.setConstant(std::numeric_limits<double>::quiet_NaN());
      if (is_ascii) {
        bytes += std::to_string(p.x()) + " " + std::to_string(p.y()) + " " + std::to_string(p.z()) +
                 " 16 32 48\n";
        continue;
      }
      const Eigen::Vector2f xy = p.head<2>().cast<float>();
      bytes.append(reinterpret_cast<const char*>(xy.data()), sizeof(xy));
      bytes.append(reinterpret_cast<const char*>(&p.z()), sizeof(double));
      bytes += "\x10\x20\x30";
    }
  }
  return bytes;
}

TEST(CloudFile, PlyGivesDepthColorAndIntrinsics) {
  const TemporaryFolder folder;
  const std::string size = "obj_info num_cols 8\nobj_info num_rows 6\n";
  for (const bool is_ascii : {false, true}) {
    const auto file = folder.Write("a.ply", PlyCloud(size, is_ascii));
    const RgbdFrame frame = FrameOfCloud(ReadCloudFile(file), "a.ply");
    EXPECT_NEAR(frame.intrinsics.fx(), 12, 1e-2);
    EXPECT_NEAR(frame.intrinsics.cy(), 2.7, 1e-2);
    EXPECT_NEAR(frame.depth_m(5, 1), 0.55f, 1e-6);
    EXPECT_EQ(frame.depth_m(3, 2), 0) << "a hole has no reading";
    EXPECT_EQ(frame.color(7, 5), (Rgb8{0x10, 0x20, 0x30}));
    EXPECT_NEAR(FrameOfCloud(ReadCloudFile(file), "a.ply", 1e-3).depth_m(5, 1), 0.55e-3f, 1e-8);
  }
}

TEST(CloudFile, ColorsThatAreNotWholeAreRefused) {
  const TemporaryFolder folder;
  const auto frame = [&](const std::string& from, const std::string& to) {
    std::string bytes = PlyCloud("", true);
    const size_t at = bytes.find(from);
    bytes.replace(at, from.size(), to);
    const auto file = folder.Write("a.ply", bytes);
    return FrameOfCloud(ReadCloudFile(file, {8, 6}), "a.ply");
  };
  for (const auto& [from, to] :
       {std::pair("uchar green", "uchar paint"), std::pair("uchar red", "float red"),
        std::pair("uchar blue", "float blue")}) {
    EXPECT_THAT(ErrorOf([&] { frame(from, to); }), HasSubstr("a.ply: a color needs the fields red"))
        << to;
  }
  const std::string colors = "uchar red\nproperty uchar green\nproperty uchar blue";
  EXPECT_TRUE(frame(colors, "uchar r\nproperty uchar g\nproperty uchar b").color.empty());
}

TEST(CloudFile, CameraElementOfPclGivesTheSize) {
  std::string bytes = PlyCloud("", true);
  const size_t at = bytes.find("end_header");
  bytes.insert(at,
               "element camera 1\nproperty float view_px\nproperty int viewportx\n"
               "property int viewporty\n");
  const PlyRows rows = ReadPlyRows(bytes + "0 8 6\n", "pcl.ply");
  EXPECT_EQ(rows.width, 8);
  EXPECT_EQ(rows.height, 6);
  EXPECT_EQ(rows.rows, 48u);
  for (const char* size : {"-8 6", "8 2000000"}) {
    EXPECT_THAT(ErrorOf([&] { ReadPlyRows(fmt::format("{}0 {}\n", bytes, size), "pcl.ply"); }),
                HasSubstr("pcl.ply: the camera has a viewport of"));
  }
}

TEST(CloudFile, TheImageGivesTheSizeThatTheFileDoesNotHave) {
  const TemporaryFolder folder;
  const auto file = folder.Write("a.ply", PlyCloud("", false));
  EXPECT_THAT(ErrorOf([&] { ReadCloudFile(file); }), HasSubstr("no width and height"));
  EXPECT_EQ(ReadCloudFile(file, {8, 6}).width, 8);
  EXPECT_THAT(ErrorOf([&] { ReadCloudFile(file, {9, 6}); }), HasSubstr("48 points"));
}

TEST(CloudFile, RefusesDamagedFilesInOneLine) {
  const TemporaryFolder folder;
  const auto error = [&](const std::string& bytes) {
    const auto file = folder.Write("b.ply", bytes);
    return ErrorOf([&] { ReadCloudFile(file, {8, 6}); });
  };
  EXPECT_THAT(error("solid"), HasSubstr("no PLY file"));
  EXPECT_THAT(error("ply\nformat ascii 1.0\n"), HasSubstr("does not end"));
  EXPECT_THAT(error("ply\nformat binary_big_endian 1.0\nend_header\n"), HasSubstr("big_endian"));
  EXPECT_THAT(error(PlyCloud("", false).substr(0, 400)), HasSubstr("too short"));
  EXPECT_THAT(
      error("ply\nformat ascii 1.0\nelement face 1\nproperty list uchar int i\nend_header\n"),
      HasSubstr("list"));
}

TEST(CloudFile, NumbersOfATextPlyMustHaveTheirTypes) {
  const TemporaryFolder folder;
  const auto error = [&](const std::string& color) {
    std::string ply = PlyCloud("", true);
    const std::string known = "16 32 48\n";
    const auto file = folder.Write("b.ply", ply.replace(ply.find(known), known.size(), color));
    return ErrorOf([&] { ReadCloudFile(file, {8, 6}); });
  };
  EXPECT_EQ(error("255 0 48.0\r\n"), "no error");
  for (const char* number : {"-1e300", "256", "-1", "1.5", "nan"}) {
    EXPECT_THAT(error(number + std::string(" 32 48\n")),
                HasSubstr("the PLY file has the number " + std::string(number) + " of the type"));
  }
  EXPECT_THAT(error("16 3x 48\n"), HasSubstr("damaged"));
  EXPECT_THAT(error("16 32 48\xb6\n"), HasSubstr("damaged"));
}

TEST(CloudFile, APcdHasAsManyBytesAsItsHeaderSays) {
  const TemporaryFolder folder;
  std::string pcd =
      "VERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH 8\nHEIGHT "
      "6\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS 48\nDATA binary\n";
  for (int i = 0; i < 48; ++i) {
    const float point[3] = {0.01f * static_cast<float>(i % 8), 0.01f * static_cast<float>(i / 8),
                            1};
    pcd.append(reinterpret_cast<const char*>(point), sizeof(point));
  }
  EXPECT_EQ(ReadCloudFile(folder.Write("a.pcd", pcd)).width, 8);
  const auto error = [&](const std::string& bytes) {
    const auto file = folder.Write("b.pcd", bytes);
    return ErrorOf([&] { ReadCloudFile(file); });
  };
  EXPECT_THAT(error(pcd.substr(0, pcd.size() - 1)), HasSubstr("too short"));
  EXPECT_THAT(error(pcd + "1"), HasSubstr("longer than its header says"));
}

TEST(CloudFile, DamagedHeadersOfPcdFilesAreRefused) {
  const TemporaryFolder folder;
  const auto error = [&](const std::string& type, const std::string& viewpoint) {
    const std::string pcd = "VERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE " + type +
                            "\nCOUNT 1 1 1\nWIDTH 8\nHEIGHT 6\nVIEWPOINT " + viewpoint +
                            "\nPOINTS 48\nDATA binary\n";
    const auto file = folder.Write("a.pcd", pcd);
    return ErrorOf([&] { ReadCloudFile(file); });
  };
  const std::string pose = "0 0 0 1 0 0 0";
  EXPECT_THAT(error("F F F", pose), HasSubstr("too short"));  // the header is right
  EXPECT_THAT(error("F F F", "0 0 0 0 0 0 0"), HasSubstr("too short"));
  EXPECT_THAT(error("F F", pose), HasSubstr("TYPE of the PCD file is 'F F', but needs F, I or U"));
  EXPECT_THAT(error("F F F<", pose), HasSubstr("TYPE of the PCD file is 'F F F<'"));
  EXPECT_THAT(error("F F F", "0 0 0 1 0 0 1"), HasSubstr("a quaternion of length 1.41, not 1"));
  EXPECT_THAT(error("F F F", "0 0 0 1 0 0"), HasSubstr("no seven numbers"));
}

TEST(CloudFile, APropertyTwiceIsRefused) {
  const TemporaryFolder folder;
  const auto file = folder.Write("a.ply",
                                 "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\n"
                                 "property float x\nend_header\n0 0\n");
  EXPECT_THAT(ErrorOf([&] { ReadCloudFile(file); }),
              HasSubstr("the header names the property x twice"));
}

// As MeshLab writes a mesh.
TEST(CloudFile, AnElementCanHaveTwoLists) {
  const TemporaryFolder folder;
  std::string ply = PlyCloud("", false);
  const std::string end = "end_header";
  ply.replace(ply.find(end), 0,
              "element face 0\nproperty list uchar int vertex_indices\n"
              "property list uchar float texcoord\n");
  EXPECT_GT(ReadCloudFile(folder.Write("a.ply", ply), {8, 6}).width, 0);
}

}  // namespace
}  // namespace pickbed::tests
