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

constexpr const char* kBehind = "#9aa5b1";

struct ChartSize {
  double width_px, height_px;
};
constexpr ChartSize kLarge{480, 340}, kSmall{258, 200};
constexpr double kLeft_px = 52, kRight_px = 12, kTop_px = 30, kBottom_px = 44;
constexpr double kLegendLine_px = 16;

// From values to places in the drawing.
struct Axes {
  const CurveChart& chart;
  const ChartSize& size;
  double X(double x) const {
    const double share = (x - chart.x_min) / (chart.x_max - chart.x_min);
    return kLeft_px + share * (size.width_px - kLeft_px - kRight_px);
  }
  double Y(double y) const {
    const double share = (y - chart.y_min) / (chart.y_max - chart.y_min);
    return Floor_px() - share * (Floor_px() - kTop_px);
  }
  double Floor_px() const { return size.height_px - kBottom_px; }
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
                       axes.Floor_px() + 16, x);
  }
  return svg;
}

// The interval about a curve.
std::string Band(const Axes& axes, const Curve& curve, const char* color) {
  std::string edge;
  for (const CurvePoint& p : curve.points) {
    edge += fmt::format("{:.1f},{:.1f} ", axes.X(p.x), axes.Y(p.high));
  }
  for (auto p = curve.points.rbegin(); p != curve.points.rend(); ++p) {
    edge += fmt::format("{:.1f},{:.1f} ", axes.X(p->x), axes.Y(p->low));
  }
  return fmt::format("<polygon points='{}' fill='{}' opacity='.15'/>", edge, color);
}

std::string Points(const Axes& axes, const Curve& curve, const char* color) {
  std::string line, dots;
  for (const CurvePoint& p : curve.points) {
    line += fmt::format("{:.1f},{:.1f} ", axes.X(p.x), axes.Y(p.y));
    dots += fmt::format("<circle cx='{:.1f}' cy='{:.1f}' r='3' fill='{}'/>", axes.X(p.x),
                        axes.Y(p.y), color);
  }
  return fmt::format("<polyline points='{}' fill='none' stroke='{}' stroke-width='2'/>{}", line,
                     color, dots);
}

std::string Curves(const Axes& axes) {
  const CurveChart& chart = axes.chart;
  std::string svg = Grid(axes);
  if (chart.diagonal) {
    svg += fmt::format(
        "<line x1='{:.1f}' y1='{:.1f}' x2='{:.1f}' y2='{:.1f}' stroke='#8fa1b3' "
        "stroke-dasharray='4 4'/>",
        axes.X(chart.x_min), axes.Y(chart.y_min), axes.X(chart.x_max), axes.Y(chart.y_max));
  }
  if (!chart.behind.points.empty()) svg += Points(axes, chart.behind, kBehind);
  for (size_t i = 0; i < chart.curves.size(); ++i) {
    const char* color = kColors[i % kColors.size()];
    svg += Band(axes, chart.curves[i], color) + Points(axes, chart.curves[i], color);
  }
  return svg;
}

// With title and names of the axes.
std::string Drawing(const Axes& axes, const std::string& curves) {
  const CurveChart& chart = axes.chart;
  const ChartSize& size = axes.size;
  const double middle_px = 0.5 * (kTop_px + axes.Floor_px());
  return fmt::format(
      "<svg width='{0}' height='{1}' viewBox='0 0 {0} {1}'>{2}"
      "<text x='{3}' y='18' font-weight='bold'>{4}</text>"
      "<text x='{5:.1f}' y='{6:.1f}' text-anchor='middle'>{7}</text>"
      "<text x='14' y='{8:.1f}' text-anchor='middle' transform='rotate(-90 14 {8:.1f})'>{9}</text>"
      "</svg>\n",
      size.width_px, size.height_px, curves, kLeft_px, EscapeHtml(chart.title),
      0.5 * (kLeft_px + size.width_px - kRight_px), size.height_px - 8, EscapeHtml(chart.x_label),
      middle_px, EscapeHtml(chart.y_label));
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
  const Axes axes{chart, kLarge};
  std::string curves = Curves(axes);
  for (size_t i = 0; i < chart.curves.size(); ++i) {
    const double y =
        axes.Floor_px() - 10 - kLegendLine_px * static_cast<double>(chart.curves.size() - 1 - i);
    curves += fmt::format("<text x='{:.1f}' y='{:.1f}' text-anchor='end' fill='{}'>{}</text>",
                          kLarge.width_px - kRight_px - 6, y, kColors[i % kColors.size()],
                          EscapeHtml(chart.curves[i].name));
  }
  body_ += Drawing(axes, curves);
}

void HtmlPage::SmallCharts(const std::vector<CurveChart>& charts) {
  for (const CurveChart& chart : charts) {
    const Axes axes{chart, kSmall};
    body_ += Drawing(axes, Curves(axes));
  }
}

void HtmlPage::Picture(const std::string& path, const std::string& caption) {
  body_ += Figure(path, caption, "");
}

void HtmlPage::WidePicture(const std::string& path, const std::string& caption) {
  body_ += Figure(path, caption, " class=\"wide\"");
}

std::string HtmlPage::Finish() const { return body_ + "</body></html>\n"; }

}  // namespace pickbed
