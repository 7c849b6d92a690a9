#include "eval/page/html.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "scenes/base/error.h"
#include "tests/support/temporary_folder.h"

namespace pickbed::tests {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

constexpr const char* kTemplate =
    "<title>@PICKBED_TITLE@</title>@PICKBED_BODY@ @PICKBED_VERSION@ "
    "<!--charts-->credit of charts<!--/charts--> <!--views-->credit of views<!--/views-->"
    "<!--charts-->library of charts<!--/charts--><!--views-->library of views<!--/views-->";

// Returns a page with this body in a small template.
std::string Finished(const std::string& body) {
  const TemporaryFolder folder;
  HtmlPage page("title");
  page.Html(body);
  return page.Finish({folder.Write("page.html", kTemplate)});
}

TEST(Base64, EqualsTheExamplesOfRfc4648) {
  EXPECT_EQ(Base64(""), "");
  EXPECT_EQ(Base64("f"), "Zg==");
  EXPECT_EQ(Base64("fo"), "Zm8=");
  EXPECT_EQ(Base64("foobar"), "Zm9vYmFy");
  EXPECT_EQ(Base64("\xff\xfe\xfd"), "//79");
}

TEST(TableHtml, NumbersBreakOnlyBeforeTheirInterval) {
  const std::string html = TableHtml({{"part", "right"}, {"rod", "87.5 % [69.0, 95.7]"}});
  EXPECT_THAT(html, HasSubstr(">87.5&nbsp;% <span>[69.0, 95.7]</span></td>"));
  const std::string counted =
      TableHtml({{"part", "right"}, {"rod", "87.5 % [69.0, 95.7] 14 of 16 picks"}});
  EXPECT_THAT(counted, HasSubstr(">87.5&nbsp;% <span>[69.0, 95.7]</span> <span class=\"count\">14 "
                                 "of 16 picks</span></td>"));
}

TEST(TableHtml, NumbersAreRightAlignedExceptInTheFirstColumn) {
  const std::string html = TableHtml({{"a", "b"}, {"10-30", "+1.5"}, {"x", "none"}});
  EXPECT_THAT(html, HasSubstr("<td>10-30</td><td class=\"n\">+1.5</td>"));
  EXPECT_THAT(html, HasSubstr("<td>none</td>"));
  const std::string unknown = TableHtml({{"a", "b"}, {"x", "- 0 of 0 grasps"}});
  EXPECT_THAT(unknown, HasSubstr("<td class=\"n\">- 0 of 0 grasps</td>"));
  const std::string numbers = TableHtml({{"a", "b"}, {"1", "2.5"}, {"2", "inf [3, inf]"}});
  EXPECT_THAT(numbers, HasSubstr("<th>a</th><th class=\"n\">b</th>"));
  EXPECT_THAT(numbers, HasSubstr("<td class=\"n\">inf <span>[3, inf]</span></td>"));
}

TEST(HtmlPage, TextIsEscaped) {
  const std::string name = "</script><!--<script>\"'&";
  HtmlPage page(name);
  page.Heading(name, "id");
  page.Subheading(name);
  page.Paragraph(name);
  page.Note(name);
  page.Preformatted(name);
  page.Table({{name}, {name}});
  page.Chart({"id", name, name, "{\"name\": \"</script><!--\"}", {{name}, {name}}});
  page.Picture("a\"b.png", name);
  page.WidePicture("a\"b.png", name);
  EXPECT_THAT(page.body(), Not(HasSubstr("<!--")));
  EXPECT_THAT(page.body(), Not(HasSubstr("</script><")));
  EXPECT_THAT(page.body(), Not(HasSubstr("a\"b")));
  EXPECT_THAT(page.body(), HasSubstr("&lt;/script&gt;"));
}

TEST(HtmlPage, EmptyParagraphsAreOmitted) {
  HtmlPage page("title");
  const std::string before = page.body();
  page.Paragraph("");
  page.Note("");
  EXPECT_EQ(page.body(), before);
}

TEST(HtmlPage, PageHasTitleBodyAndOnlyNeededLibraries) {
  EXPECT_THAT(Finished("<p>text</p>"), HasSubstr("<title>title</title><h1>title</h1>"));
  EXPECT_THAT(Finished("<p>text</p>"), HasSubstr("<p>text</p>"));
  EXPECT_THAT(Finished("<p>text</p>"), Not(HasSubstr("of charts")));
  EXPECT_THAT(Finished("<p>text</p>"), Not(HasSubstr("of views")));
  const std::string chart = Finished(ChartHtml({"id", "title", "", "{}"}));
  EXPECT_THAT(chart, HasSubstr("credit of charts"));
  EXPECT_THAT(chart, HasSubstr("library of charts"));
  EXPECT_THAT(chart, Not(HasSubstr("of views")));
  EXPECT_THAT(Finished(ChartHtml({"id", "title", "", ""})), Not(HasSubstr("of charts")));
  const std::string view = Finished("<model-viewer src=\"\"></model-viewer>");
  EXPECT_THAT(view, HasSubstr("library of views"));
  EXPECT_THAT(view, Not(HasSubstr("of charts")));
}

TEST(WritePage, UsesTheFirstTemplateThatExists) {
  const TemporaryFolder folder;
  const auto missing = folder.path() / "missing.html";
  const auto first = folder.Write("first.html", std::string("first") + kTemplate);
  const auto second = folder.Write("second.html", std::string("second") + kTemplate);
  const auto page = folder.path() / "out.html";
  EXPECT_THAT(WritePage(page, HtmlPage("title"), {missing, first, second}), IsEmpty());
  EXPECT_THAT(ReadFileBytes(page), testing::StartsWith("first"));
}

TEST(WritePage, MissingTemplateGivesOneLineAndNoFile) {
  const TemporaryFolder folder;
  const auto missing = folder.path() / "missing.html", page = folder.path() / "out.html";
  const std::string reason = WritePage(page, HtmlPage("title"), {missing, missing});
  EXPECT_FALSE(std::filesystem::exists(page));
  EXPECT_THAT(reason, HasSubstr("out.html is not written"));
  EXPECT_THAT(reason, HasSubstr(missing.string()));
  EXPECT_THAT(reason, HasSubstr("npm"));
  EXPECT_THAT(reason, Not(HasSubstr("\n")));
  EXPECT_THROW(HtmlPage("title").Finish({missing}), InputError);
}

TEST(WritePage, TemplateWithoutItsMarksIsAnError) {
  const TemporaryFolder folder;
  const auto broken = folder.Write("broken.html", "<title>@PICKBED_TITLE@</title>");
  EXPECT_THROW(HtmlPage("title").Finish({broken}), std::logic_error);
}

}  // namespace
}  // namespace pickbed::tests
