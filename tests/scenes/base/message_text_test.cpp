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
}

}  // namespace
}  // namespace pickbed::tests
