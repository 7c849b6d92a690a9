#include "perception/networks/tensor_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "scenes/base/byte_blocks.h"
#include "tests/support/error_of.h"

namespace pickbed::tests {
namespace {

using testing::HasSubstr;

TensorFile Example() {
  TensorFile file("test file", 3);
  file.PutText("note", "two\nlines: \"quoted\"\tend \xc3\xa9");
  file.Put("weights", std::vector<float>{1, -2, 3.5f, 1e-30f, 5, 6}, {2, 3});
  file.Put("steps", std::vector<int64_t>{int64_t{1} << 60}, {});
  file.Put("empty", std::vector<float>{});
  return file;
}

TensorFile Parse(const std::string& bytes) { return TensorFile::Parse(bytes, "test file", 2, 4); }

TEST(TensorFile, RoundTripKeepsEverything) {
  const TensorFile file = Parse(Example().Bytes());
  EXPECT_EQ(file.version(), 3);
  EXPECT_EQ(file.Text("note"), Example().Text("note"));
  EXPECT_EQ(file.Floats("weights"), Example().Floats("weights"));
  EXPECT_EQ(file.Shape("weights"), (TensorShape{2, 3}));
  EXPECT_EQ(file.Integers("steps"), std::vector{int64_t{1} << 60});
  EXPECT_EQ(file.Shape("steps"), TensorShape{});
  EXPECT_TRUE(file.Floats("empty").empty());
  EXPECT_EQ(file.Bytes(), Example().Bytes());
}

TEST(TensorFile, TextsWithOtherBytesAreRefused) {
  for (const std::string& text :
       {std::string("a\0b", 3), std::string("a\x08"), std::string("\xff")}) {
    TensorFile file("test file", 3);
    file.PutText("note", text);
    EXPECT_THAT(ErrorOf([&] { Parse(file.Bytes()).Text("note"); }),
                HasSubstr("'note' has bytes that are no text"));
  }
}

TEST(TensorFile, EveryCutAndEveryFlippedBitIsNoticed) {
  const std::string bytes = Example().Bytes();
  for (size_t size = 0; size < bytes.size(); ++size) {
    EXPECT_NE(ErrorOf([&] { Parse(bytes.substr(0, size)); }), "no error") << size;
  }
  for (size_t bit = 0; bit < 8 * bytes.size(); ++bit) {
    std::string damaged = bytes;
    damaged[bit / 8] ^= 1 << bit % 8;
    const size_t version = 8, end_of_version = 16;
    if (bit / 8 >= version && bit / 8 < end_of_version && damaged[8] == 0) continue;
    EXPECT_NE(ErrorOf([&] { Parse(damaged); }), "no error") << bit;
  }
}

// Files with a right check sum that were not written by this program.
TEST(TensorFile, CraftedHeadersAreRefused) {
  const auto error_of = [](const std::string& entries, const std::string& values) {
    BlockWriter writer;
    writer.Put("kind: test file\nversion: 3\nentries: " + entries + "\n");
    writer.Put(values);
    const std::string bytes = writer.Bytes("PICKTENS", 1);
    return ErrorOf([&] { Parse(bytes); });
  };
  EXPECT_EQ(error_of("[{name: w, type: float32, shape: 1}]", "1234"), "no error");
  EXPECT_THAT(error_of("[{name: w, type: float32, shape: 2}]", "1234"),
              HasSubstr("entry 'w' has 4 bytes, its shape 2 needs 8"));
  EXPECT_THAT(error_of("[{name: w, type: float32, shape: -1x-1}]", "1234"), HasSubstr("too large"));
  EXPECT_THAT(error_of("[{name: w, type: float32, shape: 4294967296x4294967296x4294967296}]", ""),
              HasSubstr("too large"));
  EXPECT_THAT(error_of("[{name: w, type: float32, shape: 99999999999999999999}]", ""),
              HasSubstr("is not a shape"));
  EXPECT_THAT(error_of("[{name: w, type: float32, shape: 1y1}]", "1234"),
              HasSubstr("'1y1' is not a shape"));
  EXPECT_THAT(error_of("[{name: w, type: object, shape: 1}]", "1234"), HasSubstr("object"));
  EXPECT_THAT(
      error_of("[{name: w, type: text, shape: 4}, {name: v, type: text, shape: 4}]", "1234"),
      HasSubstr("cut short"));
}

TEST(TensorFile, BytesAfterTheLastEntryAreRefused) {
  BlockWriter writer;
  writer.Put("kind: test file\nversion: 3\nentries: []\n");
  EXPECT_EQ(ErrorOf([&] { Parse(writer.Bytes("PICKTENS", 1)); }), "no error");
  writer.Put("");
  EXPECT_THAT(ErrorOf([&] { Parse(writer.Bytes("PICKTENS", 1)); }), HasSubstr("is longer"));
}

TEST(TensorFile, NamesTypesAndValuesAreChecked) {
  EXPECT_THAT(ErrorOf([] { Example().Floats("bias"); }), HasSubstr("it has no entry 'bias'"));
  EXPECT_THAT(ErrorOf([] { Example().Floats("note"); }),
              HasSubstr("entry 'note' is text, not float32"));
  EXPECT_THAT(ErrorOf([] { Example().PutText("note", ""); }), HasSubstr("twice"));
  TensorFile file("test file", 3);
  file.Put("weights", {1, std::numeric_limits<float>::quiet_NaN()});
  EXPECT_THAT(ErrorOf([&] { file.Floats("weights"); }),
              HasSubstr("a value of 'weights' is not finite"));
  file.Put("bias", {1, -2e7f});
  EXPECT_THAT(ErrorOf([&] { file.Floats("bias"); }), HasSubstr("over 1e+06"));
}

TEST(TensorFile, KindAndVersionAreChecked) {
  const std::string bytes = Example().Bytes();
  EXPECT_THAT(ErrorOf([&] { TensorFile::Parse(bytes, "model", 1, 9); }),
              HasSubstr("it is not a model but a test file"));
  EXPECT_THAT(ErrorOf([&] { TensorFile::Parse(bytes, "test file", 4, 9); }),
              HasSubstr("it is of version 3, older than 4"));
  EXPECT_THAT(ErrorOf([&] { TensorFile::Parse(bytes, "test file", 1, 2); }),
              HasSubstr("newer than this program"));
}

}  // namespace
}  // namespace pickbed::tests
