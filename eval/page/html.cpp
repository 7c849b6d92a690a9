#include "eval/page/html.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cstdint>
#include <stdexcept>
#include <string_view>

#include "scenes/base/error.h"
#include "scenes/base/files.h"

namespace pickbed::eval {
namespace {

// Returns the first place with a page template; empty if there is none. For the template see
// eval/page/web/make_page.cmake.
std::filesystem::path FindTemplate(const std::vector<std::filesystem::path>& places) {
  for (const auto& file : places) {
    if (std::filesystem::is_regular_file(file)) return file;
  }
  return {};
}

std::string NoTemplateText(const std::vector<std::filesystem::path>& places) {
  std::string text;
  for (const auto& file : places) text += (text.empty() ? "" : " or ") + file.string();
  return fmt::format(
      "there is no page template at {} because pickbed was built without npm or its registry; "
      "build it again with both (packages.txt, group report)",
      text);
}

// Replaces the first `mark` in `text`. The libraries after it are not searched.
void Fill(const std::string& mark, const std::string& with, std::string& text) {
  const size_t place = text.find(mark);
  if (place == std::string::npos) throw std::logic_error("the page template has no " + mark);
  text.replace(place, mark.size(), with);
}

// Removes everything between <!--NAME--> and <!--/NAME-->, wherever these are.
void RemoveMarked(const std::string& name, std::string& text) {
  const std::string begin = "<!--" + name + "-->", end = "<!--/" + name + "-->";
  size_t from = text.find(begin);
  if (from == std::string::npos) throw std::logic_error("the page template has no " + begin);
  for (; from != std::string::npos; from = text.find(begin, from)) {
    const size_t to = text.find(end, from);
    if (to == std::string::npos) throw std::logic_error("the page template has no " + end);
    text.erase(from, to + end.size() - from);
  }
}

// Inside a script element, "</script" and "<!--" would be parsed as markup.
std::string ScriptSafe(const std::string& json) {
  std::string safe;
  for (const char c : json) safe += c == '<' ? std::string("\\u003c") : std::string(1, c);
  return safe;
}

bool IsNumber(const std::string& cell) {
  if (cell.starts_with("inf")) return true;
  return !cell.empty() && (std::isdigit(static_cast<unsigned char>(cell[0])) || cell == "-" ||
                           cell.starts_with("- ") ||
                           ((cell[0] == '+' || cell[0] == '-') && cell.size() > 1 &&
                            std::isdigit(static_cast<unsigned char>(cell[1]))));
}

// Whether most cells of the column are numbers, which are right-aligned.
bool HasNumbers(const TableCells& cells, size_t column) {
  size_t numbers = 0, others = 0;
  for (size_t i = 1; column > 0 && i < cells.size(); ++i) {
    if (column >= cells[i].size() || cells[i][column].empty()) continue;
    ++(IsNumber(cells[i][column]) ? numbers : others);
  }
  return numbers > others;
}

// Formats "87.5 % [69.0, 95.7]" so that a line break is only possible before the interval. A count
// after the interval has its own element.
std::string NumberHtml(const std::string& cell) {
  const size_t interval = cell.find(" [");
  std::string html = EscapeHtml(cell.substr(0, interval));
  if (const size_t at = html.find(" %"); at != std::string::npos) html.replace(at, 1, "&nbsp;");
  if (interval == std::string::npos) return html;
  const size_t count = cell.find("] ", interval);
  const size_t length = count == std::string::npos ? count : count - interval;
  html += " <span>" + EscapeHtml(cell.substr(interval + 1, length)) + "</span>";
  if (count == std::string::npos) return html;
  return html + " <span class=\"count\">" + EscapeHtml(cell.substr(count + 2)) + "</span>";
}

// Names of configurations such as "estimator.name=ppf,seed=1" may break only between words.
std::string HeadHtml(const std::string& cell, bool of_numbers) {
  std::string html = of_numbers ? "<th class=\"n\">" : "<th>";
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

std::string ElementHtml(const char* tag, const std::string& text, const std::string& attributes) {
  return fmt::format("<{0}{1}>{2}</{0}>\n", tag, attributes, EscapeHtml(text));
}

std::string GridHtml(const std::vector<ReportChart>& charts, const char* css_class) {
  std::string html = fmt::format("<div class=\"{}\">\n", css_class);
  for (const ReportChart& chart : charts) html += ChartHtml(chart);
  return html + "</div>\n";
}

std::string PictureHtml(const std::string& path, const std::string& caption,
                        const char* css_class) {
  return fmt::format(
      "<figure class=\"{2}\"><a href=\"{0}\"><img src=\"{0}\" alt=\"{1}\"></a><figcaption>{1}"
      "</figcaption></figure>\n",
      EscapeHtml(path), EscapeHtml(caption), css_class);
}

}  // namespace

std::string EscapeHtml(const std::string& text) {
  std::string safe;
  for (const char c : text) {
    if (c == '&') {
      safe += "&amp;";
    } else if (c == '<') {
      safe += "&lt;";
    } else if (c == '>') {
      safe += "&gt;";
    } else if (c == '"') {
      safe += "&quot;";
    } else {
      safe += c;
    }
  }
  return safe;
}

std::string UrlOf(const std::string& path) {
  constexpr std::string_view kPlain = "/-_.~";
  std::string url;
  for (const unsigned char c : path) {
    const bool plain = c < 0x80 && (std::isalnum(c) ||
                                    kPlain.find(static_cast<char>(c)) != std::string_view::npos);
    url += plain ? std::string(1, static_cast<char>(c)) : fmt::format("%{:02X}", c);
  }
  return url;
}

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
      html += i == 0 ? HeadHtml(cells[i][k], HasNumbers(cells, k))
                     : CellHtml(cells[i][k], /*may_be_number=*/k > 0);
    }
    html += "</tr>\n";
  }
  return html + "</table></div>\n";
}

std::string AlignedText(const TableCells& table) {
  std::vector<size_t> widths;
  for (const auto& row : table) {
    widths.resize(std::max(widths.size(), row.size()));
    for (size_t i = 0; i < row.size(); ++i) widths[i] = std::max(widths[i], row[i].size());
  }
  std::string text;
  for (const auto& row : table) {
    std::string line;
    for (size_t i = 0; i < row.size(); ++i) line += fmt::format("{:<{}}  ", row[i], widths[i]);
    line.erase(line.find_last_not_of(' ') + 1);
    text += line + "\n";
  }
  return text;
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

std::vector<std::filesystem::path> PageTemplatePlaces() {
  return {AssetsDir() / "report" / "page.html", PICKBED_REPORT_PAGE};
}

HtmlPage::HtmlPage(const std::string& title) : title_(title), body_(ElementHtml("h1", title, "")) {}

void HtmlPage::Heading(const std::string& text, const std::string& id) {
  body_ += ElementHtml("h2", text, id.empty() ? "" : fmt::format(" id=\"{}\"", id));
}

void HtmlPage::Subheading(const std::string& text) { body_ += ElementHtml("h3", text, ""); }

void HtmlPage::Paragraph(const std::string& text) {
  if (!text.empty()) body_ += ElementHtml("p", text, "");
}

void HtmlPage::Note(const std::string& text) {
  if (!text.empty()) body_ += ElementHtml("p", text, " class=\"note\"");
}

void HtmlPage::Preformatted(const std::string& text) { body_ += ElementHtml("pre", text, ""); }

void HtmlPage::Table(const TableCells& cells) { body_ += TableHtml(cells); }

void HtmlPage::Chart(const ReportChart& chart) { body_ += ChartHtml(chart); }

void HtmlPage::Charts(const std::vector<ReportChart>& charts) {
  body_ += GridHtml(charts, "charts");
}

void HtmlPage::SmallCharts(const std::vector<ReportChart>& charts) {
  body_ += GridHtml(charts, "charts small");
}

void HtmlPage::Picture(const std::string& path, const std::string& caption) {
  body_ += PictureHtml(path, caption, "picture");
}

void HtmlPage::WidePicture(const std::string& path, const std::string& caption) {
  body_ += PictureHtml(path, caption, "wide-picture");
}

std::string HtmlPage::Finish(const std::vector<std::filesystem::path>& places) const {
  const std::filesystem::path file = FindTemplate(places);
  CheckInput(!file.empty(), NoTemplateText(places));
  std::string page = ReadFileBytes(file);
  if (body_.find("<div class=\"plot\"") == std::string::npos) RemoveMarked("charts", page);
  if (body_.find("<model-viewer ") == std::string::npos) RemoveMarked("views", page);
  Fill("@PICKBED_TITLE@", EscapeHtml(title_), page);
  Fill("@PICKBED_BODY@", body_, page);
  Fill("@PICKBED_VERSION@", PICKBED_VERSION, page);
  return page;
}

std::string WritePage(const std::filesystem::path& file, const HtmlPage& page,
                      const std::vector<std::filesystem::path>& places) {
  if (FindTemplate(places).empty()) {
    return fmt::format("{} is not written: {}", file.string(), NoTemplateText(places));
  }
  WriteFileAtomically(file, page.Finish(places));
  return "";
}

}  // namespace pickbed::eval
