#pragma once

// HTML pages: text, tables, charts and pictures in the page template (eval/page/web). A page has
// its style, scripts and charts in itself and loads only its pictures. Text is escaped.

#include <filesystem>
#include <string>
#include <vector>

#include "eval/layer.h"

namespace pickbed::eval {

// File names of pages that several commands write.
inline constexpr char kIndexPage[] = "index.html";            // of a folder
inline constexpr char kComparisonPage[] = "comparison.html";  // of runs or estimators

using TableCells = std::vector<std::vector<std::string>>;  // the first row is the header

// A chart with its caption and its numbers. eval/page/vega.h makes the specification.
struct ReportChart {
  std::string id;  // for tests and links; only [a-z0-9-]
  std::string title;
  std::string caption;
  std::string spec;  // Vega-Lite JSON; empty = nothing to show
  TableCells table = {};
};

// A table with title and text.
struct ReportTable {
  std::string title, text;
  TableCells cells;
};

// Replaces &, <, > and " by entities.
std::string EscapeHtml(const std::string& text);

// Returns a relative path as a URL: bytes other than letters, digits and "/-_.~" are encoded.
std::string UrlOf(const std::string& path);

// Encodes bytes as Base64 (RFC 4648).
std::string Base64(const std::string& bytes);

// Returns the table in a box that scrolls if the screen is narrow. Cells with a number are
// right-aligned, except in the first column.
std::string TableHtml(const TableCells& cells);
// Returns the table as text with aligned columns, for the console.
std::string AlignedText(const TableCells& table);
// Returns the chart with its caption and a collapsed table of its numbers.
std::string ChartHtml(const ReportChart& chart);

// Places of the page template: of the installed program, and of its build.
std::vector<std::filesystem::path> PageTemplatePlaces();

// Builds a page element by element.
class HtmlPage {
 public:
  explicit HtmlPage(const std::string& title);
  // Adds the heading of a section. `id` is the target of links; it may be empty.
  void Heading(const std::string& text, const std::string& id = "");
  // Adds a heading inside a section.
  void Subheading(const std::string& text);
  // Adds nothing if the text is empty.
  void Paragraph(const std::string& text);
  // Like Paragraph, in small print.
  void Note(const std::string& text);
  // Adds text with its line breaks and indentation, for example settings.
  void Preformatted(const std::string& text);
  // Adds a table, see TableHtml.
  void Table(const TableCells& cells);
  // Adds a chart with the width of the page.
  void Chart(const ReportChart& chart);
  // Adds charts side by side, as many in a row as the screen has room for.
  void Charts(const std::vector<ReportChart>& charts);
  // Same as Charts(), with up to four in a row.
  void SmallCharts(const std::vector<ReportChart>& charts);
  // Adds a picture with a link to its file; `path` is relative to the page. Pictures added one
  // after another share a row.
  void Picture(const std::string& path, const std::string& caption);
  // Same as Picture(), in a row of its own.
  void WidePicture(const std::string& path, const std::string& caption);
  // Adds HTML as it is.
  void Html(const std::string& html) { body_ += html; }

  // HTML of the elements added until now.
  const std::string& body() const { return body_; }

  // Returns the complete page, with the libraries for charts and 3D views if it has any. Throws
  // InputError if the template is at none of the places. This is so if pickbed was built without
  // npm or its registry.
  std::string Finish(const std::vector<std::filesystem::path>& places = PageTemplatePlaces()) const;

 private:
  std::string title_, body_;
};

// Writes the page to `file` and returns an empty string. Without a page template it writes nothing,
// and returns one line for the user: which page is missing and why. Throws InputError if the file
// cannot be written.
[[nodiscard]] std::string WritePage(
    const std::filesystem::path& file, const HtmlPage& page,
    const std::vector<std::filesystem::path>& places = PageTemplatePlaces());

}  // namespace pickbed::eval
