#include "eval/report/page_parts.h"

#include <fmt/format.h>

#include "eval/report/html_page.h"

namespace pickbed {
namespace {

// Within a script element "</script" and "<!--" would be read as markup.
std::string ScriptSafe(const std::string& json) {
  std::string safe;
  for (const char c : json) safe += c == '<' ? std::string("\\u003c") : std::string(1, c);
  return safe;
}

bool IsNumber(const std::string& cell) {
  return !cell.empty() && (std::isdigit(static_cast<unsigned char>(cell[0])) || cell == "-" ||
                           ((cell[0] == '+' || cell[0] == '-') && cell.size() > 1 &&
                            std::isdigit(static_cast<unsigned char>(cell[1]))));
}

// "87.5 % [69.0, 95.7]": where it has to break, before its interval.
std::string NumberHtml(const std::string& cell) {
  const size_t interval = cell.find(" [");
  std::string html = EscapeHtml(cell.substr(0, interval));
  if (const size_t at = html.find(" %"); at != std::string::npos) html.replace(at, 1, "&nbsp;");
  if (interval == std::string::npos) return html;
  return html + " <span>" + EscapeHtml(cell.substr(interval + 1)) + "</span>";
}

// Names of points as "estimator.name=ppf,seed=1" may break between their words alone.
std::string HeadHtml(const std::string& cell) {
  std::string html = "<th>";
  for (const char c : EscapeHtml(cell)) {
    html += c;
    if (c == '=' || c == ',' || c == '.') html += "<wbr>";
  }
  return html + "</th>";
}

std::string CellHtml(const std::string& cell, bool may_be_number) {
  if (may_be_number && IsNumber(cell))
    return fmt::format("<td class=\"n\">{}</td>", NumberHtml(cell));
  return fmt::format("<td>{}</td>", EscapeHtml(cell));
}

}  // namespace

std::string Base64(const std::string& bytes) {
  static constexpr char kDigits[] =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  text.reserve((bytes.size() + 2) / 3 * 4);
  for (size_t i = 0; i < bytes.size(); i += 3) {
    uint32_t group = 0;
    for (size_t k = 0; k < 3; ++k) {
      group = group << 8 | (i + k < bytes.size() ? static_cast<unsigned char>(bytes[i + k]) : 0u);
    }
    const size_t digits = std::min<size_t>(bytes.size() - i, 3) + 1;
    for (size_t k = 0; k < 4; ++k) {
      text += k < digits ? kDigits[group >> (18 - 6 * k) & 63] : '=';
    }
  }
  return text;
}

std::string TableHtml(const TableCells& cells) {
  std::string html = "<div class=\"wide\"><table>\n";
  for (size_t i = 0; i < cells.size(); ++i) {
    html += "<tr>";
    for (size_t k = 0; k < cells[i].size(); ++k) {
      html += i == 0 ? HeadHtml(cells[i][k]) : CellHtml(cells[i][k], /*may_be_number=*/k > 0);
    }
    html += "</tr>\n";
  }
  return html + "</table></div>\n";
}

std::string ChartHtml(const ReportChart& chart) {
  std::string html = fmt::format("<figure class=\"chart\" data-chart=\"{}\"><h3>{}</h3>\n",
                                 chart.id, EscapeHtml(chart.title));
  if (!chart.spec.empty()) {
    html += fmt::format(
        "<div class=\"plot\" role=\"img\" aria-label=\"{}\"></div>"
        "<script type=\"application/json\">{}</script>\n",
        EscapeHtml(chart.title), ScriptSafe(chart.spec));
  }
  html += fmt::format("<figcaption>{}</figcaption>\n", EscapeHtml(chart.caption));
  if (chart.table.size() > 1) {
    html += "<details><summary>As a table</summary>" + TableHtml(chart.table) + "</details>\n";
  }
  return html + "</figure>\n";
}

}  // namespace pickbed
