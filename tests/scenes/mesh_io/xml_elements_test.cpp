#include "scenes/mesh_io/xml_elements.h"

#include <gmock/gmock.h>

#include "tests/scenes/shapes.h"

namespace pickbed::tests {
namespace {

using testing::HasSubstr;

TEST(ReadXml, KeepsNamesAttributesTextAndOrder) {
  const XmlElement root = ReadXml(
      "a.xml",
      "\xef\xbb\xbf<?xml version=\"1.0\"?>\n<!DOCTYPE x>\n<a one='1' two = \"2 > 1\">\n<!-- <b> "
      "-->text<b/>more<c x=\"\"><d>1 2</d></c ></a>\n");
  EXPECT_EQ(root.name, "a");
  EXPECT_EQ(root.line, 3);
  EXPECT_EQ(root.Attribute("one"), "1");
  EXPECT_EQ(root.Attribute("two"), "2 > 1");
  EXPECT_EQ(root.Attribute("three"), "");
  EXPECT_EQ(root.text, "\ntextmore");
  ASSERT_EQ(root.children.size(), 2u);
  EXPECT_EQ(root.children[0].name, "b");
  ASSERT_NE(root.Child("c"), nullptr);
  EXPECT_EQ(root.Child("c")->Child("d")->text, "1 2");
  EXPECT_EQ(root.Child("d"), nullptr);
}

TEST(ReadXml, BrokenTextsAreRefusedWithFileAndLine) {
  struct {
    std::string text, message;
  } const cases[] = {
      {"", "it has no element"},
      {"<!-- <a/> -->", "it has no element"},
      {"<?xml", "line 1 cannot be read: Error parsing document declaration"},
      {"<a>\n<b></a>", "line 2 cannot be read: Start-end tags mismatch"},
      {"<a></a></a>", "Start-end tags mismatch"},
      {"<a>\n<b>", "line 2 cannot be read: Start-end tags mismatch"},
      {"<a", "Error parsing start element tag"},
      {"<a b>", "Error parsing element attribute"},
      {"<a b=1/>", "Error parsing element attribute"},
      {"<a b='1/>", "Error parsing element attribute"},
      {"<a>\n<b c='1' c='2'/></a>", "line 2 has the attribute 'c' twice"},
      {"<a / >", "Error parsing start element tag"},
      {"< a/>", "Could not determine tag type"},
      {"<a/>\n<b/>", "line 2 has an element after the end"},
      {"<a/>\n\nx", "line 3 has text outside of the outermost element"},
      {"x<a/>", "line 1 has text outside of the outermost element"},
      {"<a><!-- </a>", "Error parsing comment"},
      {std::string("<a>\n\0</a>", 9), "line 2 has a byte of value 0"},
      {std::string("<a/>\0<b", 7), "line 1 has a byte of value 0"},
  };
  for (const auto& test : cases) {
    const std::string message = InputErrorOf([&] { ReadXml("x/a.dae", test.text); });
    EXPECT_THAT(message, HasSubstr(test.message)) << test.text;
    EXPECT_THAT(message, HasSubstr("x/a.dae")) << test.text;
  }
  std::string deep;
  for (int i = 0; i < 100000; ++i) deep += "<a>";
  for (int i = 0; i < 100000; ++i) deep += "</a>";
  EXPECT_THAT(InputErrorOf([&] { ReadXml("a.dae", deep); }), HasSubstr("more than 100 deep"));
}

}  // namespace
}  // namespace pickbed::tests
