#include "scenes/base/yaml.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "tests/support/error_of.h"

namespace pickbed::tests {
namespace {

using testing::HasSubstr;

std::string ErrorFor(const std::string& text) {
  return ErrorOf([&] { ParseYaml(text, "a.yaml"); });
}

TEST(ParseYaml, ReadsAliases) {
  const YAML::Node node = ParseYaml("a: &x [1, 2]\nb: *x\n", "a.yaml");
  EXPECT_EQ(node["b"][1].as<int>(), 2);
}

TEST(ParseYaml, NamesTheLineOfAFault) {
  EXPECT_THAT(ErrorFor("a: 1\nb: [\n"), HasSubstr("a.yaml:3: not valid YAML"));
  // The library shows an unknown escape as it is.
  EXPECT_EQ(ErrorFor("a: \"x\\\ny: 1\n").find('\n'), std::string::npos);
  EXPECT_EQ(ErrorFor("b: \"\\\x01\"\n").find('\n'), std::string::npos);
}

TEST(ParseYaml, RefusesANodeWithinItself) {
  EXPECT_THAT(ErrorFor("x: &a [*a]\n"), HasSubstr("a.yaml:1: is nested more than 64 levels"));
}

TEST(ParseYaml, RefusesAliasesOfAliases) {
  std::string bomb = "a0: &a0 [x, x, x, x, x, x, x, x, x, x]\n";
  for (int i = 1; i < 10; ++i) {
    std::string list;
    for (int k = 0; k < 10; ++k) list += (k > 0 ? ", *a" : "*a") + std::to_string(i - 1);
    bomb += "a" + std::to_string(i) + ": &a" + std::to_string(i) + " [" + list + "]\n";
  }
  EXPECT_THAT(ErrorFor(bomb), HasSubstr("has more than 200000 values"));
}

TEST(ParseYaml, RefusesManyAliasesOfALongText) {
  // Less than 200000 values and 4 MiB, but a reader would copy 200 MiB.
  std::string bomb = "a: [&x " + std::string(1 << 20, 'x');
  for (int i = 0; i < 200; ++i) bomb += ", *x";
  EXPECT_THAT(ErrorFor("b: 1\n" + bomb + "]\n"),
              HasSubstr("a.yaml:2: has more than 4194304 bytes with the texts behind its aliases"));
}

TEST(ParseYaml, RefusesDeepNestingAndLargeTexts) {
  EXPECT_NE(ErrorFor(std::string(100, '[') + std::string(100, ']')), "no error");
  EXPECT_NE(ErrorFor(std::string(100000, '[')), "no error");
  EXPECT_THAT(ErrorFor("a: " + std::string(5 << 20, 'x')), HasSubstr("a YAML file may have"));
}

TEST(ParseYaml, RefusesTextsThatAreNotUtf8) {
  for (const char* const text :
       {"\xbb", "\xc3", "\xc0\xaf", "\xe0\x80\xaf", "\xed\xa0\x80", "\xf4\x90\x80\x80"}) {
    const std::string message = ErrorFor(std::string("a: 1\nb: x") + text + "y\n");
    EXPECT_THAT(message, HasSubstr("a.yaml:2")) << text;
    EXPECT_THAT(message, HasSubstr("is not UTF-8")) << text;
  }
  ParseYaml("# M\xfcller\nname: M\xc3\xbcller \xe2\x82\xac \xf0\x9f\x98\x80\n", "a.yaml");
}

TEST(ParseYaml, RefusesControlCharacters) {
  EXPECT_EQ(ErrorFor("a: 1\nb: x\x7fy\n"), "a.yaml:2: has the control character 0x7f; remove it");
  EXPECT_THAT(ErrorFor("# \x1b[2J\na: 1\n"), HasSubstr("a.yaml:1: has the control character 0x1b"));
  EXPECT_EQ(ParseYaml("a:\t1\r\nb: \"\\x7f\"\n", "a.yaml")["b"].Scalar(), "\x7f");
}

TEST(ParseYaml, RefusesAFileThatIsCutWithinANumber) {
  const auto error = [](const std::string& text) {
    return ErrorOf([&] { RequireWholeYaml(text, "a.yaml"); });
  };
  for (const char* const text : {"a: 0.", "a: [1, -2.", "x: 1\na: {b: 12."}) {
    EXPECT_THAT(error(text), HasSubstr("a.yaml: ends with '")) << text;
  }
  for (const char* const text :
       {"a: 0.\n", "a: 0.5", "a: no. 2", "a: the end.", "# version 2.", "a: 1 # see 2.", "", "."}) {
    EXPECT_NO_THROW(RequireWholeYaml(text, "a.yaml")) << text;
  }
}

TEST(ParseYaml, NamesTabsAsACause) {
  EXPECT_THAT(ErrorFor("a:\n\tb: 1\n\tc: 2\n"), HasSubstr(" (tabs are not allowed; use spaces)"));
  EXPECT_THAT(ErrorFor("a: [1\nb: 2\n"), testing::Not(HasSubstr("tabs")));
}

}  // namespace
}  // namespace pickbed::tests
