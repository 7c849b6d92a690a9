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
      {"<?xml", "line 1 has no ?> for its <?"},
      {"<a>\n<b></a>", "line 2 closes the element 'a', which is not open there"},
      {"<a></a></a>", "closes the element 'a'"},
      {"<a>\n<b>", "it ends within its element 'b' of line 2"},
      {"<a", "has an attribute of 'a' without a value"},
      {"<a b>", "has an attribute of 'a' without a value"},
      {"<a b=1/>", "has an attribute of 'a' without a value"},
      {"<a b='1/>", "has a value without its end"},
      {"<a b='1' b='2'/>", "has the attribute 'b' twice"},
      {"<a / >", "has a broken tag 'a'"},
      {"< a/>", "has a tag without a name"},
      {"<a/><b/>", "has an element after the end"},
      {"<a/>x", "has text outside of the outermost element"},
      {"<a><!-- </a>", "has no --> for its <!--"},
  };
  for (const auto& test : cases) {
    const std::string message = InputErrorOf([&] { ReadXml("x/a.dae", test.text); });
    EXPECT_THAT(message, HasSubstr(test.message)) << test.text;
    EXPECT_THAT(message, HasSubstr("x/a.dae")) << test.text;
  }
  std::string deep;
  for (int i = 0; i < 100000; ++i) deep += "<a>";
  EXPECT_THAT(InputErrorOf([&] { ReadXml("a.dae", deep); }), HasSubstr("more than 100 deep"));
}

}  // namespace
}  // namespace pickbed::tests
