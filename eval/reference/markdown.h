#pragma once

// Markdown text of the generated pages.

#include <string>
#include <vector>

#include "eval/metrics/result_columns.h"

namespace pickbed::eval {

// Returns the text with the special characters of Markdown and HTML escaped, except in `code`.
std::string MarkdownText(const std::string& text);
// Returns the text as code, or nothing for an empty text.
std::string MarkdownCode(const std::string& text);
// Returns a table; the first row is the header. The cells must be escaped.
std::string MarkdownTable(const std::vector<std::vector<std::string>>& rows);
// Returns a table of columns: name, unit and meaning. `title` is the header of the names.
std::string ColumnTable(const std::string& title, const ResultColumns& columns);
// Comment of a generated page.
inline constexpr char kGeneratedMark[] = "<!-- Written by pickbed_make_reference. Do not edit. -->";
// Returns the beginning of a page: title and kGeneratedMark.
std::string PageHead(const std::string& title);

}  // namespace pickbed::eval
