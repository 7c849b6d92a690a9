#include "eval/reference/markdown.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <string_view>

namespace pickbed::eval {

std::string MarkdownText(const std::string& text) {
  std::string escaped;
  bool in_code = false;
  for (const char c : text) {
    if (c == '`') in_code = !in_code;
    if (!in_code && c == '<') {
      escaped += "&lt;";
      continue;
    }
    const bool special =
        in_code ? c == '|' : std::string_view("|*_[]").find(c) != std::string::npos;
    if (special) escaped += '\\';
    escaped += c;
  }
  return escaped;
}

std::string MarkdownCode(const std::string& text) {
  if (text.empty()) return "";
  std::string code = "`";
  for (const char c : text) code += c == '|' ? "\\|" : std::string(1, c);
  return code + "`";
}

std::string MarkdownTable(const std::vector<std::vector<std::string>>& rows) {
  std::string text;
  for (const std::vector<std::string>& row : rows) {
    text += fmt::format("| {} |\n", fmt::join(row, " | "));
    if (&row != &rows.front()) continue;
    for (size_t i = 0; i < row.size(); ++i) text += "|---";
    text += "|\n";
  }
  return text;
}

std::string ColumnTable(const std::string& title, const ResultColumns& columns) {
  std::vector<std::vector<std::string>> rows{{title, "unit", "meaning"}};
  for (const ResultColumn& column : columns) {
    rows.push_back(
        {MarkdownCode(column.name), MarkdownText(UnitOf(column)), MarkdownText(column.help)});
  }
  return MarkdownTable(rows);
}

std::string PageHead(const std::string& title) {
  return fmt::format("# {}\n\n{}\n\n", title, kGeneratedMark);
}

}  // namespace pickbed::eval
