#include "scenes/image/number_image.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

#include "scenes/base/files.h"
#include "scenes/image/image_io.h"
#include "tests/support/error_of.h"
#include "tests/support/temporary_folder.h"

namespace pickbed::tests {
namespace {

using ::testing::HasSubstr;

Image<float> Ramp() {
  Image<float> image(5, 3);
  for (int y = 0; y < 3; ++y) {
    for (int x = 0; x < 5; ++x) image(x, y) = 0.25f * static_cast<float>(x + 10 * y);
  }
  image(2, 1) = std::numeric_limits<float>::quiet_NaN();
  return image;
}

TEST(NumberImage, FloatsSurviveEachFormat) {
  const TemporaryFolder folder;
  for (const char* name : {"a.exr", "a.tiff", "a.npy"}) {
    WriteFloats(folder.path() / name, Ramp());
    const NumberImage read = ReadNumberImage(folder.path() / name);
    EXPECT_TRUE(read.is_float) << name;
    ASSERT_EQ(read.values.width(), 5) << name;
    EXPECT_EQ(read.values(4, 2), 6) << name;
    EXPECT_EQ(read.values(0, 1), 2.5f) << name;
    EXPECT_NE(read.values(2, 1), read.values(2, 1)) << name << " loses the NaN";
  }
}

TEST(NumberImage, IntegersKeepTheirValuesAndBits) {
  const TemporaryFolder folder;
  Image<uint16_t> image(2, 1);
  image(1, 0) = 65535;
  WritePng16(folder.path() / "d.png", image);
  const NumberImage read = ReadNumberImage(folder.path() / "d.png");
  EXPECT_EQ(read.bits, 16);
  EXPECT_FALSE(read.is_float);
  EXPECT_EQ(read.values(1, 0), 65535);
}

// The library of OpenEXR would take its default in place of a missing attribute.
TEST(NumberImage, DamagedHeadersOfExrFilesAreRefused) {
  const TemporaryFolder folder;
  const std::filesystem::path file = folder.path() / "a.exr";
  WriteFloats(file, Ramp());
  const std::string exr = ReadFileBytes(file);
  const auto error = [&](const std::string& name, size_t at, char byte) {
    std::string damaged = exr;
    const size_t begin = exr.find(name + '\0');
    EXPECT_NE(begin, std::string::npos) << name;
    damaged[begin + at] = byte;
    folder.Write("a.exr", damaged);
    return ErrorOf([&] { ReadNumberImage(file); });
  };
  for (const std::string name : {"channels", "compression", "dataWindow", "displayWindow",
                                 "lineOrder", "screenWindowCenter", "screenWindowWidth"}) {
    EXPECT_THAT(error(name, 2, 'X'), HasSubstr("the EXR has no attribute '" + name + "'"));
    EXPECT_THAT(error(name, name.size() + 1, 'X'),
                HasSubstr("the EXR has the attribute '" + name + "' of type 'X"));
  }
  const size_t size = 2 * std::string("lineOrder ").size();
  EXPECT_THAT(error("lineOrder", size, '\2'), HasSubstr("of type 'lineOrder' with 2 bytes"));
  EXPECT_THAT(error("lineOrder", size + 2, '\4'), HasSubstr("with 262145 bytes"));
  folder.Write("a.exr", exr.substr(0, 40));
  EXPECT_THAT(ErrorOf([&] { ReadNumberImage(file); }), HasSubstr("header"));
}

// The library reads the first directory only.
TEST(NumberImage, BrokenDirectoriesOfATiffAreRefused) {
  const TemporaryFolder folder;
  const std::filesystem::path file = folder.path() / "a.tiff";
  WriteFloats(file, Ramp());
  const std::string tiff = ReadFileBytes(file);
  ASSERT_EQ(tiff.substr(tiff.size() - 4), std::string(4, '\0')) << "the end of the directories";
  const auto error = [&](const std::string& bytes) {
    folder.Write("a.tiff", bytes);
    return ErrorOf([&] { ReadNumberImage(file); });
  };
  EXPECT_EQ(error(tiff), "no error");
  const std::string first = tiff.substr(4, 4), rest = tiff.substr(0, tiff.size() - 4);
  const std::string beyond("\0\0\0\2", 4);
  for (const std::string& next : {first, beyond, std::string()}) {
    EXPECT_THAT(error(rest + next), HasSubstr("a directory that is not within the file"));
  }
}

std::string Numpy(const std::string& header, const std::string& data) {
  return std::string("\x93NUMPY\x01\x00", 8) + static_cast<char>(header.size()) + '\0' + header +
         data;
}

TEST(NumberImage, ReadsIntegerArraysOfNumpy) {
  const TemporaryFolder folder;
  const auto file = folder.Write(
      "a.npy", Numpy("{'descr': '<u2', 'fortran_order': False, 'shape': (1, 2, 1), }\n",
                     std::string("\x02\x01\x00\x80", 4)));
  const NumberImage read = ReadNumberImage(file);
  EXPECT_EQ(read.values(0, 0), 258);
  EXPECT_EQ(read.values(1, 0), 32768);
}

TEST(NumberImage, RefusesOtherFilesInOneLine) {
  const TemporaryFolder folder;
  const auto error = [&](const std::string& bytes) {
    const auto file = folder.Write("b.npy", bytes);
    return ErrorOf([&] { ReadNumberImage(file); });
  };
  EXPECT_THAT(error("text"), HasSubstr("no PNG, TIFF, OpenEXR or NumPy"));
  EXPECT_THAT(error("\x93NUMPY"), HasSubstr("header"));
  EXPECT_THAT(
      error(Numpy("{'descr': '|u1', 'fortran_order': False, 'shape': (1, 2), }  \xf9 \n", "ab")),
      HasSubstr("more than a dictionary"));
  EXPECT_THAT(error(Numpy("{'descr': '<f4', 'fortran_order': True, 'shape': (1, 2), }\n", "")),
              HasSubstr("ascontiguousarray"));
  EXPECT_THAT(error(Numpy("{'descr': '>f4', 'fortran_order': False, 'shape': (1, 2), }\n", "")),
              HasSubstr("little-endian"));
  EXPECT_THAT(error(Numpy("{'descr': '<c8', 'fortran_order': False, 'shape': (1, 2), }\n", "")),
              HasSubstr("type <c8"));
  EXPECT_THAT(error(Numpy("{'descr': '<f4', 'fortran_order': False, 'shape': (4, 2, 3), }\n", "")),
              HasSubstr("(4, 2, 3)"));
  EXPECT_THAT(error(Numpy("{'descr': '<f4', 'fortran_order': False, 'shape': (4, 2), }\n", "abc")),
              HasSubstr("too short"));
  EXPECT_THAT(
      error(Numpy("{'descr': '<u1', 'fortran_order': False, 'shape': (4, 2), }\n", "abcdefghi")),
      HasSubstr("longer than its header says"));
  WritePng(folder.path() / "c.png", Image<Rgb8>(2, 2));
  EXPECT_THAT(ErrorOf([&] { ReadNumberImage(folder.path() / "c.png"); }), HasSubstr("3 channels"));
  EXPECT_TRUE(HasColorChannels(folder.path() / "c.png"));
}

}  // namespace
}  // namespace pickbed::tests
