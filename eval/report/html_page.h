#pragma once

// Pages for people in one file: text, tables, curves and pictures, with nothing to load from
// elsewhere.

#include <filesystem>
#include <string>
#include <vector>

namespace pickbed {

struct CurvePoint {
  double x = 0, y = 0;
  double low = 0, high = 0;  // of the interval about y
};
struct Curve {
  std::string name;
  std::vector<CurvePoint> points;
};
struct CurveChart {
  std::string title, x_label, y_label;
  double x_min = 0, x_max = 1, y_min = 0, y_max = 1;
  bool diagonal = false;  // y = x, as a guide
  std::vector<Curve> curves = {};
  Curve behind = {};  // drawn in grey without its interval, to compare with
};

class HtmlPage {
 public:
  explicit HtmlPage(const std::string& title);
  void Heading(const std::string& text);
  void Paragraph(const std::string& text);
  // The first row is the header; cells that begin with a digit stand to the right.
  void Table(const std::vector<std::vector<std::string>>& rows);
  // Curves with their intervals as shaded bands; charts added one after the other share a row.
  void Chart(const CurveChart& chart);
  // Each smaller and without a legend, so that many stand side by side; for one curve, which the
  // title names.
  void SmallCharts(const std::vector<CurveChart>& charts);
  // A link to a picture that shows it; `path` as seen from the page.
  void Picture(const std::string& path, const std::string& caption);
  // The same, as wide as the page.
  void WidePicture(const std::string& path, const std::string& caption);

  std::string Finish() const;

 private:
  std::string body_;
};

// &, <, > and " as entities.
std::string EscapeHtml(const std::string& text);

}  // namespace pickbed
