#include "scenes/plugin/message.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <functional>
#include <limits>

#include "tests/support/layer.h"

namespace pickbed::tests {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

std::string BytesOf(const MessageWriter& message) {
  std::string bytes;
  for (const auto& chunk : message.Chunks()) {
    bytes.append(reinterpret_cast<const char*>(chunk.data()), chunk.size());
  }
  EXPECT_EQ(bytes.size(), message.size());
  return bytes;
}

MessageValue Read(const std::string& bytes) {
  return ReadMessageValue(std::as_bytes(std::span(bytes.data(), bytes.size())));
}

std::string FaultOf(const std::function<void()>& read) {
  try {
    read();
  } catch (const MessageError& error) {
    return error.what();
  }
  return "no error";
}

std::string Text(std::initializer_list<int> bytes) { return {bytes.begin(), bytes.end()}; }

// Bytes from the examples and tables of the specification.
TEST(Message, WritesTheBytesOfTheSpecification) {
  MessageWriter message;
  message.BeginMap(2);
  message.Text("compact");
  message.Bool(true);
  message.Text("schema");
  message.Integer(0);
  EXPECT_EQ(BytesOf(message),
            Text({0x82, 0xa7}) + "compact" + Text({0xc3, 0xa6}) + "schema" + std::string(1, '\0'));
  MessageWriter numbers;
  numbers.BeginList(4);
  numbers.Nil();
  numbers.Integer(-2);
  numbers.Unsigned(300);
  numbers.Real(1);
  EXPECT_EQ(BytesOf(numbers),
            Text({0x94, 0xc0, 0xd3}) + std::string(7, '\xff') + "\xfe" +
                Text({0xcf, 0, 0, 0, 0, 0, 0, 1, 0x2c, 0xcb, 0x3f, 0xf0, 0, 0, 0, 0, 0, 0}));
}

TEST(Message, ReadsEveryTypeOfTheSpecification) {
  EXPECT_EQ(Read(Text({0x7f})).Integer(""), 127);
  EXPECT_EQ(Read(Text({0xe0})).Integer(""), -32);
  EXPECT_EQ(Read(Text({0xcc, 0xff})).Integer(""), 255);
  EXPECT_EQ(Read(Text({0xcd, 1, 0})).Integer(""), 256);
  EXPECT_EQ(Read(Text({0xce, 0, 1, 0, 0})).Integer(""), 65536);
  EXPECT_EQ(Read(Text({0xd0, 0x80})).Integer(""), -128);
  EXPECT_EQ(Read(Text({0xd1, 0xff, 0})).Integer(""), -256);
  EXPECT_EQ(Read(Text({0xd2, 0xff, 0xff, 0xff, 0xfe})).Integer(""), -2);
  EXPECT_EQ(Read(Text({0xcf}) + std::string(8, '\xff')).Real(""), std::ldexp(1.0, 64));
  EXPECT_EQ(Read(Text({0xca, 0x3f, 0xc0, 0, 0})).Real(""), 1.5);
  EXPECT_TRUE(Read(Text({0xc0})).is_nil());
  EXPECT_EQ(Read(Text({0xd9, 2}) + "ab").Text(""), "ab");
  EXPECT_EQ(Read(Text({0xda, 0, 2}) + "ab").Text(""), "ab");
  EXPECT_EQ(Read(Text({0xdb, 0, 0, 0, 2}) + "ab").Text(""), "ab");
  EXPECT_EQ(Read(Text({0xc4, 1, 9})).binary()->bytes, "\t");
  EXPECT_EQ(Read(Text({0xdc, 0, 2, 1, 2})).Items("").size(), 2u);
  EXPECT_EQ(Read(Text({0xdd, 0, 0, 0, 1, 5})).Items("")[0].Integer(""), 5);
  EXPECT_EQ(Read(Text({0xde, 0, 1, 0xa1}) + "k" + Text({7})).At("k").Integer(""), 7);
  EXPECT_EQ(Read(Text({0xdf, 0, 0, 0, 1, 0xa1}) + "k" + Text({7})).At("k").Integer(""), 7);
}

TEST(Message, LongTextsListsAndMapsComeBackAsTheyWere) {
  for (const size_t size : {0, 15, 16, 31, 32, 65535, 65536}) {
    MessageWriter text;
    text.Text(std::string(size, 'x'));
    EXPECT_EQ(Read(BytesOf(text)).Text(""), std::string(size, 'x')) << size;
    MessageWriter list;
    list.BeginList(size);
    for (size_t i = 0; i < size; ++i) list.Unsigned(i);
    const MessageValue read = Read(BytesOf(list));
    ASSERT_EQ(read.Items("").size(), size);
    for (size_t i = 0; i < size; ++i) ASSERT_EQ(read.Items("")[i].Integer(""), static_cast<int>(i));
  }
  for (const int64_t number :
       {int64_t{0}, int64_t{127}, int64_t{128}, int64_t{-1}, std::numeric_limits<int64_t>::min(),
        std::numeric_limits<int64_t>::max()}) {
    MessageWriter message;
    message.Integer(number);
    EXPECT_EQ(Read(BytesOf(message)).Integer(""), number);
  }
}

TEST(Message, ArraysKeepTheirElementsAndAreNotCopiedForSending) {
  const std::vector<float> depth{0.5f, 1.25f, 2, 3, 4, 5};
  const size_t shape[] = {2, 3};
  MessageWriter message;
  message.BeginMap(2);
  message.Text("depth");
  message.Array("float32", shape, std::as_bytes(std::span(depth)));
  message.Text("after");
  message.Integer(1);
  bool refers = false;
  for (const auto& chunk : message.Chunks()) {
    refers |= chunk.data() == reinterpret_cast<const std::byte*>(depth.data());
  }
  EXPECT_TRUE(refers);
  const MessageValue read = Read(BytesOf(message));
  EXPECT_THAT(read.At("depth").Numbers(""), ElementsAre(0.5, 1.25, 2, 3, 4, 5));
  EXPECT_EQ(read.At("depth").At("dtype").Text(""), "float32");
  EXPECT_EQ(read.At("after").Integer(""), 1);
}

TEST(Message, NumbersAreReadFromNestedListsAndKeepNan) {
  MessageWriter message;
  message.BeginList(2);
  message.BeginList(2);
  message.Integer(1);
  message.Real(0.5);
  message.Real(std::nan(""));
  const std::vector<double> numbers = Read(BytesOf(message)).Numbers("");
  ASSERT_EQ(numbers.size(), 3u);
  EXPECT_EQ(numbers[1], 0.5);
  EXPECT_TRUE(std::isnan(numbers[2]));
}

TEST(Message, ShapesThatDoNotFitTheirDataAreRefused) {
  const double values[] = {1, 2, 3};
  for (const size_t wrong : {size_t{0}, size_t{2}, size_t{4}, SIZE_MAX / 2}) {
    const size_t shape[] = {wrong};
    MessageWriter message;
    message.Numbers(values, shape);
    EXPECT_THAT(FaultOf([&] { Read(BytesOf(message)).Numbers("R"); }),
                HasSubstr("R: shape does not fit"))
        << wrong;
  }
  const size_t shape[] = {3};
  MessageWriter message;
  message.Array("float16", shape, std::as_bytes(std::span(values)));
  EXPECT_THAT(FaultOf([&] { Read(BytesOf(message)).Numbers("R"); }),
              HasSubstr("unknown dtype 'float16'"));
}

// A message that is cut anywhere is an error, and reads nothing beyond its end.
TEST(Message, EveryTruncationIsAnError) {
  MessageWriter message;
  message.BeginMap(3);
  message.Text("list");
  message.BeginList(2);
  message.Real(1.5);
  message.Text("a longer text than the short form of texts can hold");
  message.Text("R");
  const double values[] = {1, 2, 3};
  const size_t shape[] = {3};
  message.Numbers(values, shape);
  message.Text("n");
  message.Integer(-7);
  const std::string bytes = BytesOf(message);
  for (size_t size = 0; size < bytes.size(); ++size) {
    const std::string cut(bytes, 0, size);
    EXPECT_THAT(FaultOf([&] { Read(cut); }), HasSubstr("ends within")) << size;
  }
  EXPECT_NO_THROW(Read(bytes));
  EXPECT_THAT(FaultOf([&] { Read(bytes + "xy"); }), HasSubstr("2 bytes after"));
}

TEST(Message, CountsThatPromiseTooMuchAllocateNothing) {
  EXPECT_THAT(FaultOf([] {
                Read(Text({0xdd, 0xff, 0xff, 0xff, 0xff}));
              }),
              HasSubstr("ends within"));
  EXPECT_THAT(FaultOf([] {
                Read(Text({0xdf, 0xff, 0xff, 0xff, 0xff}));
              }),
              HasSubstr("ends within"));
  EXPECT_THAT(FaultOf([] {
                Read(Text({0xc6, 0xff, 0xff, 0xff, 0xff}));
              }),
              HasSubstr("ends within"));
  const std::string deep(1000, '\x91');
  EXPECT_THAT(FaultOf([&] { Read(deep); }), HasSubstr("nested"));
  std::string many = Text({0xdd, 0, 0x40, 0, 0}) + std::string(0x400000, '\0');
  EXPECT_THAT(FaultOf([&] { Read(many); }), HasSubstr("2000000 values"));
  EXPECT_THAT(FaultOf([] { Read(Text({0xc7, 0, 0})); }), HasSubstr("unknown type, 0xc7"));
  EXPECT_THAT(FaultOf([] { Read(Text({0x81, 1, 1})); }), HasSubstr("a key must be a text"));
}

// Binary data may have any bytes.
TEST(Message, KeysAndTextsThatAreNotUtf8AreRefusedInOneLine) {
  const std::string umlaut = Text({0x81, 0xa2, 0xc3, 0xb6, 0xa2, 0xc3, 0xb6});
  EXPECT_EQ(Read(umlaut).At("\xc3\xb6").Text(""), "\xc3\xb6");
  EXPECT_EQ(Read(Text({0xc4, 1, 0xff})).binary()->bytes, "\xff");
  EXPECT_EQ(FaultOf([] {
              Read(Text({0x81, 0xa3}) + "R\n\xff" + Text({1}));
            }),
            "has a key or text that is not UTF-8: 'R \\xff'");
  EXPECT_THAT(FaultOf([] {
                Read(Text({0x81, 0xd9, 2}) + "\xc3(" + Text({1}));
              }),
              HasSubstr("is not UTF-8: '\\xc3('"));
  EXPECT_THAT(FaultOf([] {
                Read(Text({0x81, 0xa1}) + "R" + Text({0xa1, 0x80}));
              }),
              HasSubstr("is not UTF-8: '\\x80'"));
}

TEST(Message, MissingKeysAndWrongKindsAreNamed) {
  const MessageValue map = Read(Text({0x82, 0xa1}) + "a" + Text({1, 0xa1}) + "n" + Text({0xc0}));
  EXPECT_EQ(map.Find("n"), nullptr) << "nil counts as missing";
  EXPECT_THAT(FaultOf([&] { map.At("b"); }), HasSubstr("has no 'b'"));
  EXPECT_THAT(FaultOf([&] { map.At("a").Text("name"); }),
              HasSubstr("name must be a text, but is a whole number"));
  EXPECT_THAT(FaultOf([&] { map.At("a").At("b"); }), HasSubstr("is a whole number and no map"));
}

}  // namespace
}  // namespace pickbed::tests
