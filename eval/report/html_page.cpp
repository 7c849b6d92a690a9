#include "eval/report/html_page.h"

#include <fmt/format.h>

#include <array>

#include "eval/report/ticks.h"

namespace pickbed {
namespace {

constexpr const char* kStyle =
    "body{font:15px/1.5 system-ui,sans-serif;color:#1c2733;margin:2em auto;max-width:1100px;"
    "padding:0 1em}h1{font-size:1.6em}h2{font-size:1.2em;margin-top:2em}"
    "table{border-collapse:collapse;font-size:.92em}td,th{padding:.25em .7em;border-bottom:1px "
    "solid #dde3ea;text-align:left}td.n{text-align:right;font-variant-numeric:tabular-nums}"
    "th{border-bottom:2px solid #8fa1b3}figure{display:inline-block;margin:.5em 1em .5em 0}"
    "figcaption{font-size:.85em;color:#50606f}svg text{font:12px system-ui,sans-serif}"
    "img{max-width:520px}img.wide{max-width:100%}";

// Told apart by colour-blind readers too (Okabe and Ito 2008).
constexpr std::array<const char*, 7> kColors{"#0072b2", "#d55e00", "#009e73", "#cc79a7",
                                             "#e69f00", "#56b4e9", "#000000"};

constexpr double kWidth_px = 480, kHeight_px = 340;
constexpr double kLeft_px = 52, kRight_px = 12, kTop_px = 30, kBottom_px = 44;
constexpr double kLegendLine_px = 16;

// From values to places in the drawing.
struct Axes {
  const CurveChart& chart;
  double X(double x) const {
    const double share = (x - chart.x_min) / (chart.x_max - chart.x_min);
    return kLeft_px + share * (kWidth_px - kLeft_px - kRight_px);
  }
  double Y(double y) const {
    const double share = (y - chart.y_min) / (chart.y_max - chart.y_min);
    return kHeight_px - kBottom_px - share * (kHeight_px - kTop_px - kBottom_px);
  }
};

std::string Grid(const Axes& axes) {
  const CurveChart& chart = axes.chart;
  std::string svg;
  for (const double y : RoundTicks(chart.y_min, chart.y_max)) {
    svg += fmt::format(
        "<line x1='{0:.1f}' x2='{1:.1f}' y1='{2:.1f}' y2='{2:.1f}' stroke='#e3e8ee'/>"
        "<text x='{3:.1f}' y='{4:.1f}' text-anchor='end'>{5:.6g}</text>",
        axes.X(chart.x_min), axes.X(chart.x_max), axes.Y(y), kLeft_px - 6, axes.Y(y) + 4, y);
  }
  for (const double x : RoundTicks(chart.x_min, chart.x_max)) {
    svg += fmt::format("<text x='{:.1f}' y='{:.1f}' text-anchor='middle'>{:.6g}</text>", axes.X(x),
                       kHeight_px - kBottom_px + 16, x);
  }
  return svg;
}

std::string Line(const Axes& axes, const Curve& curve, const char* color) {
  std::string band, line, dots;
  for (const CurvePoint& p : curve.points) {
    band += fmt::format("{:.1f},{:.1f} ", axes.X(p.x), axes.Y(p.high));
    line += fmt::format("{:.1f},{:.1f} ", axes.X(p.x), axes.Y(p.y));
    dots += fmt::format("<circle cx='{:.1f}' cy='{:.1f}' r='3' fill='{}'/>", axes.X(p.x),
                        axes.Y(p.y), color);
  }
  for (auto p = curve.points.rbegin(); p != curve.points.rend(); ++p) {
    band += fmt::format("{:.1f},{:.1f} ", axes.X(p->x), axes.Y(p->low));
  }
  return fmt::format(
      "<polygon points='{0}' fill='{2}' opacity='.15'/>"
      "<polyline points='{1}' fill='none' stroke='{2}' stroke-width='2'/>{3}",
      band, line, color, dots);
}

std::string Figure(const std::string& path, const std::string& caption, const char* look) {
  return fmt::format(
      "<figure><a href=\"{0}\"><img{2} src=\"{0}\" alt=\"{1}\"></a><figcaption>{1}</figcaption>"
      "</figure>\n",
      EscapeHtml(path), EscapeHtml(caption), look);
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

HtmlPage::HtmlPage(const std::string& title) {
  body_ = fmt::format(
      "<!doctype html>\n<html lang='en'><head><meta charset='utf-8'><title>{0}</title>"
      "<style>{1}</style></head><body>\n<h1>{0}</h1>\n",
      EscapeHtml(title), kStyle);
}

void HtmlPage::Heading(const std::string& text) {
  body_ += fmt::format("<h2>{}</h2>\n", EscapeHtml(text));
}

void HtmlPage::Paragraph(const std::string& text) {
  body_ += fmt::format("<p>{}</p>\n", EscapeHtml(text));
}

void HtmlPage::Table(const std::vector<std::vector<std::string>>& rows) {
  body_ += "<table>\n";
  for (size_t i = 0; i < rows.size(); ++i) {
    body_ += "<tr>";
    for (const std::string& cell : rows[i]) {
      const bool number = !cell.empty() && cell[0] >= '0' && cell[0] <= '9';
      const char* tag = i == 0 ? "th" : "td";
      body_ += fmt::format("<{0}{1}>{2}</{0}>", tag, number && i > 0 ? " class='n'" : "",
                           EscapeHtml(cell));
    }
    body_ += "</tr>\n";
  }
  body_ += "</table>\n";
}

void HtmlPage::Chart(const CurveChart& chart) {
  const Axes axes{chart};
  std::string svg = Grid(axes);
  if (chart.diagonal) {
    svg += fmt::format(
        "<line x1='{:.1f}' y1='{:.1f}' x2='{:.1f}' y2='{:.1f}' stroke='#8fa1b3' "
        "stroke-dasharray='4 4'/>",
        axes.X(chart.x_min), axes.Y(chart.y_min), axes.X(chart.x_max), axes.Y(chart.y_max));
  }
  for (size_t i = 0; i < chart.curves.size(); ++i) {
    const char* color = kColors[i % kColors.size()];
    svg += Line(axes, chart.curves[i], color);
    const double y = kHeight_px - kBottom_px - 10 -
                     kLegendLine_px * static_cast<double>(chart.curves.size() - 1 - i);
    svg += fmt::format("<text x='{:.1f}' y='{:.1f}' text-anchor='end' fill='{}'>{}</text>",
                       kWidth_px - kRight_px - 6, y, color, EscapeHtml(chart.curves[i].name));
  }
  svg += fmt::format(
      "<text x='{}' y='18' font-weight='bold'>{}</text>"
      "<text x='{:.1f}' y='{:.1f}' text-anchor='middle'>{}</text>"
      "<text x='14' y='{:.1f}' text-anchor='middle' transform='rotate(-90 14 {:.1f})'>{}</text>",
      kLeft_px, EscapeHtml(chart.title), 0.5 * (kLeft_px + kWidth_px - kRight_px), kHeight_px - 8,
      EscapeHtml(chart.x_label), 0.5 * kHeight_px, 0.5 * kHeight_px, EscapeHtml(chart.y_label));
  body_ += fmt::format("<svg width='{0}' height='{1}' viewBox='0 0 {0} {1}'>{2}</svg>\n", kWidth_px,
                       kHeight_px, svg);
}

void HtmlPage::Picture(const std::string& path, const std::string& caption) {
  body_ += Figure(path, caption, "");
}

void HtmlPage::WidePicture(const std::string& path, const std::string& caption) {
  body_ += Figure(path, caption, " class=\"wide\"");
}

std::string HtmlPage::Finish() const { return body_ + "</body></html>\n"; }

}  // namespace pickbed
