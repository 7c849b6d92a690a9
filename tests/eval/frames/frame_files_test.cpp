#include "eval/frames/frame_files.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "eval/frames/intrinsics_file.h"
#include "scenes/image/image_io.h"
#include "scenes/image/number_image.h"
#include "tests/support/error_of.h"
#include "tests/support/temporary_folder.h"

namespace pickbed::tests {
namespace {

using ::testing::HasSubstr;

TEST(ReadIntrinsics, UnderstandsTheFilesOfUsualPrograms) {
  const TemporaryFolder folder;
  const std::vector<std::string> same{
      R"({"cx": 3, "cy": 4, "depth_scale": 0.1, "fx": 10, "fy": 11, "height": 8, "width": 6})",
      R"({"cam_K": [10, 0, 3, 0, 11, 4, 0, 0, 1], "depth_scale": 0.1})",
      // A key of its own beside the one that it resembles.
      R"({"fx": 10, "fy": 11, "cx": 3, "cy": 4, "height": 8, "width": 6, "Width": 7, "weight": 5})",
      R"({"width": 6, "height": 8, "intrinsic_matrix": [10, 0, 0, 0, 11, 0, 3, 4, 1]})",
      R"({"fx": 10, "fy": 11, "ppx": 3, "ppy": 4, "coeffs": [0, 0, 0, 0, 0], "depth_scale": 0.0001})",
      "image_width: 6\nimage_height: 8\ncamera_matrix:\n  rows: 3\n  cols: 3\n"
      "  data: [10, 0, 3, 0, 11, 4, 0, 0, 1]\n",
      "%YAML:1.0\n---\nK: !!opencv-matrix\n  rows: 3\n  cols: 3\n  dt: d\n"
      "  data: [10., 0., 3., 0., 11., 4., 0., 0., 1.]\n",
      "10 0 3\n0 11 4\n0 0 1\n"};
  for (const std::string& text : same) {
    const GivenIntrinsics k = ReadIntrinsics(folder.Write("k.txt", text).string());
    EXPECT_EQ(k.ForImage(6, 8, "k"), CameraIntrinsics(6, 8, 10, 11, 3, 4)) << text;
    EXPECT_FALSE(k.is_distorted);
    EXPECT_NEAR(k.depth_scale_mm.value_or(0.1), 0.1, 1e-12) << text;
  }
  EXPECT_EQ(ReadIntrinsics("10,11,3,4").ForImage(6, 8, "k"), CameraIntrinsics(6, 8, 10, 11, 3, 4));
  EXPECT_TRUE(ReadIntrinsics(folder
                                 .Write("d.yaml",
                                        "K: [10, 0, 3, 0, 11, 4, 0, 0, 1]\n"
                                        "D: [0.1, 0, 0, 0, 0]\n")
                                 .string())
                  .is_distorted);
}

TEST(ReadIntrinsics, RefusesOtherTextsAndOtherImages) {
  const TemporaryFolder folder;
  const auto error = [&](const std::string& text) {
    const std::string file = folder.Write("k.json", text).string();
    return ErrorOf([&] { ReadIntrinsics(file); });
  };
  EXPECT_THAT(ErrorOf([] { ReadIntrinsics("10,11,3"); }), HasSubstr("has 3 numbers"));
  EXPECT_EQ(ErrorOf([] { ReadIntrinsics("615,615,nan,240"); }),
            "intrinsics 615,615,nan,240: give four finite numbers FX,FY,CX,CY in px");
  EXPECT_THAT(ErrorOf([] { ReadIntrinsics("nowhere.json"); }), HasSubstr("nowhere.json"));
  EXPECT_THAT(error(R"({"fx": 10})"), HasSubstr("no camera matrix"));
  EXPECT_THAT(error(R"({"fx": 10, "fy": 11, "cx": 3, "cy": 4, "depth_scal3": 2})"),
              HasSubstr("unknown key 'depth_scal3'; did you mean depth_scale?"));
  EXPECT_THAT(error(R"({"0": {"cam_K": [10, 0, 3, 0, 11, 4, 0, 0, 1]}})"),
              HasSubstr("several images"));
  EXPECT_THAT(error(R"({"K": [10, 5, 3, 0, 11, 4, 0, 0, 1]})"), HasSubstr("fx 0 cx"));
  EXPECT_THAT(error(R"({"K": [10, 0, 3, 1, 11, 4, 0, 0, 1]})"), HasSubstr("fx 0 cx"));
  EXPECT_THAT(error(R"({"K": [10, 0, 3, 0, 11, 4, 0, 2, 1]})"), HasSubstr("fx 0 cx"));
  EXPECT_THAT(error(R"({"K": [10, "a", 0, 3, 0, 11, 4, 0, 0, 1]})"), HasSubstr("is no number"));
  const std::string four = R"({"fx": 10, "fy": 11, "cx": 3, "cy": 4, )";
  EXPECT_THAT(error(four + R"("coeffs": [0, ".", 0]})"), HasSubstr("k.json:1: "));
  EXPECT_THAT(error(four + R"("depth_scale": -1})"), HasSubstr("depth_scale is -1; give"));
  EXPECT_THAT(error(four + R"("depth_scale": 0})"), HasSubstr("depth_scale is 0; give"));
  EXPECT_THAT(error(four + R"("depth_scale": 0.  001})"), HasSubstr("depth_scale has 2 numbers"));
  EXPECT_THAT(error(four + R"("dePth_scale": 0.5})"), HasSubstr("did you mean depth_scale?"));
  EXPECT_THAT(error(four + R"("dgpth_scale": 0.5})"), HasSubstr("'dgpth_scale'; did you mean"));
  EXPECT_EQ(error(four + R"("png_depth_scale": 0.5, "depth_sensor": 1})"), "no error");
  const std::string matrix = "K:\n  rows: 3\n  cols: {}\n  data: [10, 0, 3, 0, 11, 4, 0, 0, 1]\n";
  EXPECT_EQ(error(fmt::format(fmt::runtime(matrix), 3) + "model:"), "no error");
  EXPECT_THAT(error(fmt::format(fmt::runtime(matrix), 3) + "distortio"),
              HasSubstr("its last line 'distortio' has no value"));
  EXPECT_THAT(error(fmt::format(fmt::runtime(matrix), 4)),
              HasSubstr("the matrix has 9 numbers, not 3 rows and 4 columns"));
  EXPECT_THAT(error(fmt::format(fmt::runtime(matrix), "1.5.2")), HasSubstr("is no number"));
  const std::string lens = fmt::format(fmt::runtime(matrix), 3) + "D:\n  rows: 1\n  cols: 5\n";
  EXPECT_EQ(error(lens + "  data: []\n"), "no error") << "not calibrated";
  EXPECT_THAT(error(lens + "  dat: [0, 0, 0, 0, 0]\n"), HasSubstr("D has no data"));
  for (const char* width : {"1e300", "-6", "6.5"}) {
    EXPECT_THAT(error(four + "\"width\": " + width + "}"), HasSubstr("whole number of pixels"));
  }
  EXPECT_EQ(error(four + R"("width": null, "depth_scale": null})"), "no error");
  for (const char* nothing : {"null", "~", "NULL", "Null", "none", "None", "\"none\"", "[]"}) {
    EXPECT_EQ(error(four + "\"dist_coeffs\": " + nothing + "}"), "no error") << nothing;
  }
  EXPECT_THAT(error(R"({"K": [10, null, 0, 3, 0, 11, 4, 0, 0, 1]})"), HasSubstr("is no number"));
  const GivenIntrinsics k{10, 11, 3, 4, 6, 8, {}, false};
  EXPECT_THAT(ErrorOf([&] { k.ForImage(12, 16, "k"); }), HasSubstr("for 6x8 px but"));
  const GivenIntrinsics of_larger{10, 11, 30, 4, 0, 0, {}, false};
  EXPECT_THAT(ErrorOf([&] { of_larger.ForImage(6, 8, "k"); }), HasSubstr("outside the image"));
}

class FrameFilesTest : public ::testing::Test {
 protected:
  FrameFilesTest() {
    WritePng(Path("color.png"), Image<Rgb8>(6, 8, {1, 2, 3}));
    Image<uint16_t> units(6, 8, 1500);
    units(0, 0) = 65535;
    units(1, 0) = 0;
    WritePng16(Path("depth.png"), units);
    WriteFloats(Path("depth.npy"), Image<float>(6, 8, 1.5f));
  }
  std::filesystem::path Path(const std::string& name) const { return folder_.path() / name; }
  std::string Error(const FrameFiles& files) const {
    return ErrorOf([&] { ReadFrameFiles(files); });
  }
  TemporaryFolder folder_;
  const std::string k_ = "10,11,3,4";
};

TEST_F(FrameFilesTest, IntegersAreMillimetresAndFloatsMetres) {
  const FrameOfFiles png = ReadFrameFiles({Path("color.png"), Path("depth.png"), k_, 0});
  EXPECT_FLOAT_EQ(png.frame.depth_m(3, 3), 1.5f);
  EXPECT_EQ(png.frame.depth_m(0, 0), 0) << "65535 is no reading";
  EXPECT_EQ(png.frame.depth_m(1, 0), 0);
  EXPECT_EQ(png.frame.color(0, 0), (Rgb8{1, 2, 3}));
  const FrameOfFiles npy = ReadFrameFiles({Path("color.png"), Path("depth.npy"), k_, 0});
  EXPECT_FLOAT_EQ(npy.frame.depth_m(3, 3), 1.5f);
  EXPECT_FLOAT_EQ(
      ReadFrameFiles({Path("color.png"), Path("depth.png"), k_, 0.1}).frame.depth_m(3, 3), 0.15f);
}

TEST_F(FrameFilesTest, DepthMayComeWithoutColor) {
  const FrameOfFiles read = ReadFrameFiles({Path("depth.png"), {}, k_, 0});
  EXPECT_TRUE(read.frame.color.empty());
  EXPECT_FLOAT_EQ(read.frame.depth_m(3, 3), 1.5f);
}

TEST_F(FrameFilesTest, BadInputGetsOneLine) {
  EXPECT_THAT(Error({Path("color.png"), {}, k_, 0}), HasSubstr("give its depth image, too"));
  EXPECT_THAT(Error({Path("color.png"), Path("depth.png"), "", 0}), HasSubstr("FX,FY,CX,CY"));
  EXPECT_THAT(Error({Path("color.png"), Path("none.png"), k_, 0}), HasSubstr("none.png"));
  WritePng(Path("large.png"), Image<Rgb8>(12, 16));
  EXPECT_THAT(Error({Path("large.png"), Path("depth.png"), k_, 0}),
              HasSubstr("is 12x16 px but the depth image"));
  WriteFileAtomically(Path("grey.png"), EncodePng(Image<uint8_t>(6, 8, 100), 1));
  EXPECT_THAT(Error({Path("color.png"), Path("grey.png"), k_, 0}), HasSubstr("8 bits per pixel"));
  Image<uint16_t> widened(6, 8);
  for (size_t i = 0; i < widened.size(); ++i) widened.data()[i] = static_cast<uint16_t>(257 * i);
  WritePng16(Path("widened.png"), widened);
  EXPECT_THAT(Error({Path("color.png"), Path("widened.png"), k_, 0}),
              HasSubstr("made from 8 bits"));
}

TEST(IsFrameFile, KnowsImagesAndCloudsByTheirNames) {
  EXPECT_TRUE(IsFrameFile("a/b.PNG"));
  EXPECT_TRUE(IsFrameFile("cloud.pcd"));
  EXPECT_FALSE(IsFrameFile("bin_rod"));
  EXPECT_FALSE(IsFrameFile("scenario.yaml"));
}

}  // namespace
}  // namespace pickbed::tests
