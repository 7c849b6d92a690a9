#include "scenes/image/image_check.h"

#include <gmock/gmock.h>

#include "scenes/base/random.h"
#include "scenes/image/image_io.h"
#include "scenes/image/number_image.h"
#include "tests/scenes/shapes.h"

namespace pickbed::tests {
namespace {

constexpr size_t kHeight = 23;  // lowest byte of the height in the header of a PNG

using testing::AllOf;
using testing::HasSubstr;

// Noise, whose JPEG has long codes, so that damage hits them.
Image<Rgb8> Noise() {
  Rng rng(3);
  Image<Rgb8> image(64, 48);
  for (Rgb8& p : image.pixels()) {
    p = {static_cast<uint8_t>(rng.Next()), static_cast<uint8_t>(rng.Next()), 40};
  }
  return image;
}

// A description of the image, which decoders do not need: the part tEXt before the end.
std::string PngWithText(const std::string& crc) {
  std::string png = EncodePng(Noise(), 3);
  const std::string text = std::string("\0\0\0\x03tEXta\0b", 11) + crc;
  return png.insert(png.size() - 12, text);
}

TEST(FaultOfImage, WholeImagesHaveNone) {
  EXPECT_EQ(FaultOfImage(EncodePng(Noise(), 3)), "");
  EXPECT_EQ(FaultOfImage(EncodePng(Image<uint16_t>(5, 4), 3)), "");
  EXPECT_EQ(FaultOfImage(EncodeJpeg(Noise(), 90)), "");
  EXPECT_EQ(FaultOfImage("BM, another format"), "");
}

// As some cameras write it.
TEST(FaultOfImage, FillBytesBeforeTheEndMarkOfAJpegAreNoFault) {
  std::string jpeg = EncodeJpeg(Noise(), 90);
  EXPECT_EQ(FaultOfImage(jpeg.insert(jpeg.size() - 2, 3, '\0')), "");
}

TEST(FaultOfImage, BytesBeforeOtherMarksOfAJpegAreNoticed) {
  std::string jpeg = EncodeJpeg(Noise(), 90);
  const size_t tables = jpeg.find("\xff\xc4");
  ASSERT_NE(tables, std::string::npos);
  EXPECT_THAT(FaultOfImage(jpeg.insert(tables, 3, '\0')), HasSubstr("3 extraneous bytes"));
}

TEST(FaultOfImage, EveryFlippedBitAndEveryCutOfAPngIsNoticed) {
  const std::string png = EncodePng(Image<uint16_t>(5, 4), 3);
  const size_t magic = 4;  // without it, the bytes are no PNG
  for (size_t bit = 8 * magic; bit < 8 * png.size(); ++bit) {
    std::string damaged = png;
    damaged[bit / 8] ^= static_cast<char>(1 << bit % 8);
    EXPECT_NE(FaultOfImage(damaged), "") << bit;
  }
  for (size_t size = magic; size < png.size(); ++size) {
    EXPECT_NE(FaultOfImage(png.substr(0, size)), "") << size;
  }
}

TEST(FaultOfImage, PartsAndBytesThatDecodersSkipAreChecked) {
  EXPECT_EQ(FaultOfImage(PngWithText("\x98\xb2\xd3\xee")).find("tEXt") != std::string::npos, true)
      << "another check sum";
  EXPECT_THAT(FaultOfImage(EncodePng(Noise(), 3) + "abc"), HasSubstr("3 bytes after its end"));
}

// Returns the PNG with another height and the right check sum of its header.
std::string WithHeight(std::string png, char height) {
  constexpr size_t kHeader = 12, kHeaderBytes = 17;
  png[kHeight] = height;
  const uint32_t sum = PngCheckSum(std::string_view(png).substr(kHeader, kHeaderBytes));
  for (size_t i = 0; i < 4; ++i) {
    png[kHeader + kHeaderBytes + i] = static_cast<char>(sum >> (24 - 8 * i));
  }
  return png;
}

TEST(FaultOfImage, DataOfAPngThatDoesNotFitItsHeaderIsNoticed) {
  const std::string png = EncodePng(Image<uint16_t>(5, 4), 3);
  EXPECT_EQ(FaultOfImage(WithHeight(png, 4)), "");
  EXPECT_THAT(FaultOfImage(WithHeight(png, 3)), HasSubstr("more data than the 5 x 3 pixels"));
  EXPECT_THAT(FaultOfImage(WithHeight(png, 5)), HasSubstr("less data than the 5 x 5 pixels"));
  EXPECT_THAT(FaultOfImage(WithHeight(png, 0)), HasSubstr("damaged header"));
}

// One invalid value each of depth, color type, compression, filter and interlace, and a width of
// 2,100 million pixels.
TEST(FaultOfImage, InvalidHeadersOfPngsAreNoticed) {
  const std::string png = EncodePng(Image<uint16_t>(5, 4), 3);
  const auto with = [&](size_t at, char value) {
    std::string changed = png;
    changed[at] = value;
    return WithHeight(changed, changed[kHeight]);  // with the check sum that fits
  };
  constexpr size_t kDepth = kHeight + 1;
  ASSERT_EQ(FaultOfImage(with(kDepth, 16)), "");
  for (const auto& [at, value] : {std::pair(kDepth, 3),
                                  {kDepth + 1, 1},
                                  {kDepth + 1, 9},
                                  {kDepth + 2, 1},
                                  {kDepth + 3, 1},
                                  {kDepth + 4, 2},
                                  {kHeight - 7, 127}}) {
    EXPECT_THAT(FaultOfImage(with(at, static_cast<char>(value))), HasSubstr("damaged header"))
        << at;
  }
}

// 5 x 3 pixels of 4 bits in seven interlaced passes.
TEST(FaultOfImage, InterlacedPngsAreChecked) {
  const std::string png(
      "\211PNG\015\012\032\012\000\000\000\015IHDR"
      "\000\000\000\005\000\000\000\003\004\000\000\000\001\314\252G\263"
      "\000\000\000\025IDATx\332c\340"
      "b\000A99\006\021 422\002\000\006\013\001\031"
      "\134d.\327\000\000\000\000IEND\256B`\202",
      78);
  EXPECT_EQ(FaultOfImage(png), "");
  EXPECT_THAT(FaultOfImage(WithHeight(png, 2)), HasSubstr("more data"));
}

TEST(FaultOfImage, EveryCutOfAJpegIsNoticed) {
  const std::string jpeg = EncodeJpeg(Noise(), 90);
  for (size_t size = 2; size + 1 < jpeg.size(); size += 7) {
    EXPECT_NE(FaultOfImage(jpeg.substr(0, size)), "") << size;
  }
  // Only its end mark is missing.
  EXPECT_THAT(FaultOfImage(jpeg.substr(0, jpeg.size() - 2)), HasSubstr("the JPEG is damaged"));
}

// The symbols of the standard tables that EncodeJpeg() writes: 12 of DC coefficients, and 162 of AC
// coefficients (ITU T.81, annex K.3).
TEST(FaultOfImage, SymbolsOfAJpegThatAreNoneAreNoticed) {
  const std::string jpeg = EncodeJpeg(Noise(), 90);
  const auto with = [&](std::string_view symbols, size_t at, char symbol) {
    std::string damaged = jpeg;
    const size_t table = jpeg.find(symbols);
    EXPECT_NE(table, std::string::npos);
    damaged[table + at] = symbol;
    return FaultOfImage(damaged);
  };
  constexpr std::string_view kDc("\0\1\2\3\4\5\6\7\x8\x9\xa\xb", 12),
      kAc("\x11\x05\x12\x21\x31\x41");
  EXPECT_THAT(with(kDc, 11, 0xc), HasSubstr("a table of codes has the symbol 0x0c, which is none"));
  EXPECT_THAT(with(kDc, 11, 0xa), HasSubstr("a table of codes has a symbol twice"));
  EXPECT_THAT(with(kAc, 4, 0x2e), HasSubstr("has the symbol 0x2e, which is none"));
  EXPECT_THAT(with(kAc, 4, 0x30), HasSubstr("has the symbol 0x30, which is none"));
}

// 24 x 16 grey pixels. Its tables have the symbol 0x20, which ends several blocks.
TEST(FaultOfImage, AProgressiveJpegHasNone) {
  const std::string_view jpeg(
      "\377\330\377\340\000\020JFIF\000\001\001\000\000\001\000\001\000\000\377\333\000C\000"
      "\020\013\014\016\014\012\020\016\015\016\022\021\020\023\030(\032\030\026\026\0301#%"
      "\035(:3=<9387@H\134N@DWE78PmQW_bghg>Mqypdx\134egc\377\302\000\013\010\000\020\000\030"
      "\001\001\021\000\377\304\000\025\000\001\001\000\000\000\000\000\000\000\000\000\000"
      "\000\000\000\000\004\005\377\332\000\010\001\001\000\000\000\001\216\367Hs\377\000\377"
      "\304\000\026\020\000\003\000\000\000\000\000\000\000\000\000\000\000\000\000\000\000"
      "\001\002\377\332\000\010\001\001\000\001\005\002\204J!\020\210D#\377\304\000\024\020"
      "\001\000\000\000\000\000\000\000\000\000\000\000\000\000\000\000 \377\332\000\010\001"
      "\001\000\006\077\002_\377\304\000\024\020\001\000\000\000\000\000\000\000\000\000\000"
      "\000\000\000\000\000 \377\332\000\010\001\001\000\001\077!D\001\377\332\000\010\001"
      "\001\000\000\000\020\233\377\304\000\027\020\001\001\001\001\000\000\000\000\000\000"
      "\000\000\000\000\000\000\0001\021A\377\332\000\010\001\001\000\001\077\020\213<\352("
      "\242\213\377\331",
      303);
  EXPECT_EQ(FaultOfImage(jpeg), "");
}

TEST(FaultOfImage, DamagedDataOfAJpegIsNoticed) {
  const std::string jpeg = EncodeJpeg(Noise(), 90);
  std::string zeros = jpeg, short_data = jpeg;
  zeros.replace(jpeg.size() / 2, 200, 200, '\xff');
  short_data.erase(jpeg.size() / 2, 300);
  EXPECT_NE(FaultOfImage(zeros), "");
  EXPECT_NE(FaultOfImage(short_data), "");
}

TEST(FaultOfImage, ReadersNameFileAndFault) {
  const TemporaryFolder folder;
  const std::string depth = EncodePng(Image<uint16_t>(5, 4), 3) + "x";
  const std::string file = folder.Write("a.png", depth);
  const auto named = AllOf(HasSubstr(file), HasSubstr("1 bytes after its end"));
  EXPECT_THAT(InputErrorOf([&] { ReadPng(file); }), named);
  EXPECT_THAT(InputErrorOf([&] { ReadPng16(file); }), named);
  EXPECT_THAT(InputErrorOf([&] { ReadPng8(file); }), named);
  EXPECT_THAT(InputErrorOf([&] { ReadNumberImage(file); }), named);
}

}  // namespace
}  // namespace pickbed::tests
