#include "scenes/base/message_text.h"

#include <gtest/gtest.h>

namespace pickbed::tests {
namespace {

TEST(OneLine, JoinsLinesAndCuts) {
  EXPECT_EQ(OneLine("  a:\n    b: 1\r\n\tc"), "a: b: 1 c");
  EXPECT_EQ(OneLine(std::string(200, 'x')), std::string(80, 'x') + "...");
}

TEST(Printable, ShowsWhatATerminalWouldObey) {
  EXPECT_EQ(Printable("red \x1b[31m and\nbreak \x7f"), "red \\x1b[31m and\\x0abreak \\x7f");
  EXPECT_EQ(Printable(std::string("a\0b", 3)), "a\\x00b");
  EXPECT_EQ(Printable("Größe"), "Größe");
  EXPECT_EQ(Printable("Gr\xf6\xdf"
                      "e"),
            "Gr\\xf6\\xdfe");
}

// The forms of RFC 3629: shortest and longest of each length, overlong ones, surrogates, and ends.
TEST(IsUtf8, FollowsRfc3629) {
  for (const char* text : {"", "abc", "\xc2\x80", "\xdf\xbf", "\xe0\xa0\x80", "\xed\x9f\xbf",
                           "\xee\x80\x80", "\xf0\x90\x80\x80", "\xf4\x8f\xbf\xbf"}) {
    EXPECT_TRUE(IsUtf8(text)) << Printable(text);
  }
  for (const char* text : {"\x80", "\xc1\xbf", "\xe0\x9f\xbf", "\xed\xa0\x80", "\xf0\x8f\xbf\xbf",
                           "\xf4\x90\x80\x80", "\xff", "\xc3", "\xe2\x82", "\xc3(", "a\xff"}) {
    EXPECT_FALSE(IsUtf8(text)) << Printable(text);
  }
}

TEST(Counted, OnlyOneIsSingular) {
  EXPECT_EQ(Counted(0, "pose"), "0 poses");
  EXPECT_EQ(Counted(1, "pose"), "1 pose");
  EXPECT_EQ(Counted(2, "pose"), "2 poses");
}

}  // namespace
}  // namespace pickbed::tests
