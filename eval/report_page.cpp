#include "eval/report_page.h"

#include <fmt/format.h>

#include <filesystem>
#include <set>

#include "eval/report/html_page.h"
#include "eval/report/page_parts.h"
#include "eval/report_views.h"
#include "scenes/check.h"
#include "scenes/files.h"

namespace pickbed {
namespace {

// The page in which the contents are filled, see eval/report/page/make_page.cmake.
std::string ReadTemplate() {
  const std::filesystem::path installed = AssetsDir() / "report" / "page.html";
  const std::filesystem::path built = PICKBED_REPORT_PAGE;
  for (const auto& file : {installed, built}) {
    if (std::filesystem::is_regular_file(file)) return ReadFileBytes(file);
  }
  throw InputError(fmt::format(
      "there is no page for reports at {} nor {}: pickbed was built where npm or its registry was "
      "not to be had; build it again with both (packages.txt, group report)",
      installed.string(), built.string()));
}

// `text` with the first `mark` replaced; the libraries behind it are not searched again.
void Fill(const std::string& mark, const std::string& with, std::string& text) {
  const size_t place = text.find(mark);
  if (place == std::string::npos) throw std::logic_error("the report's page has no " + mark);
  text.replace(place, mark.size(), with);
}

void RemoveViewsLibrary(std::string& text) {
  const std::string begin = "<!--views-->", end = "<!--/views-->";
  const size_t from = text.find(begin), to = text.rfind(end);
  if (from == std::string::npos || to == std::string::npos) {
    throw std::logic_error("the report's page has no " + begin);
  }
  text.erase(from, to + end.size() - from);
}

std::string Heading(const std::string& text, const std::string& id = "") {
  return fmt::format("<h2{}>{}</h2>\n", id.empty() ? "" : fmt::format(" id=\"{}\"", id),
                     EscapeHtml(text));
}

std::string Paragraph(const std::string& text, const char* look = "") {
  return text.empty() ? "" : fmt::format("<p{}>{}</p>\n", look, EscapeHtml(text));
}

std::string PercentText(double share) { return fmt::format("{:.1f} %", 100 * share); }

std::string IntervalText(const Interval& interval) {
  return fmt::format("[{:.1f}, {:.1f}]", 100 * interval.low, 100 * interval.high);
}

struct HeadlineFigure {
  std::string name, value, note;
};

std::vector<HeadlineFigure> HeadlineOf(const PointReport& point) {
  const RunSummary& s = point.summary;
  const ReportRate& recall = point.recall;
  const auto share = [](int part, double rate) { return part > 0 ? PercentText(rate) : "-"; };
  return {
      {"pick success", share(s.attempts, s.success_rate),
       fmt::format("{} {} of {} attempts", IntervalText(s.success_ci95), s.successes, s.attempts)},
      {"parts cleared", share(s.parts_dropped, s.cleared_rate),
       fmt::format("{} {} of {}", IntervalText(s.cleared_ci95), s.parts_cleared, s.parts_dropped)},
      {"recall", share(recall.tries, recall.rate()),
       fmt::format("{} {} of {} parts in view", IntervalText(recall.ci95), recall.hits,
                   recall.tries)},
      {"top-ranked pose right", share(s.frames, s.top1_precision),
       fmt::format("{} {} of {} images", IntervalText(s.top1_ci95), s.top1_correct, s.frames)},
      {"picks an hour",
       s.cycle.picks_per_hour() > 0 ? fmt::format("{:.0f}", s.cycle.picks_per_hour()) : "-",
       s.cycle.measured ? "compute time measured" : ""},
      {"bins", std::to_string(s.trials),
       s.refused.empty() ? "" : fmt::format("{} scenes refused and built anew", s.refused.size())}};
}

std::string HeadlineHtml(const PointReport& point) {
  std::string html = "<div class=\"headline\">\n";
  for (const HeadlineFigure& figure : HeadlineOf(point)) {
    html += fmt::format("<div><b>{1}</b>{0}<span>{2}</span></div>\n", EscapeHtml(figure.name),
                        EscapeHtml(figure.value), EscapeHtml(figure.note));
  }
  html += "</div>\n";
  const RunSummary& s = point.summary;
  if (s.attempts == 0) return html;
  TableCells cells{{"rule", "success", "95 %", "passes when"}};
  for (const RuleRate& rate : s.by_rule) {
    const SuccessRuleRow& row = SuccessRuleTable()[static_cast<size_t>(rate.rule)];
    cells.push_back({row.name, PercentText(rate.rate()), IntervalText(rate.ci95), row.help});
  }
  return html + "<details><summary>Success by each rule</summary>" + TableHtml(cells) +
         "</details>\n";
}

// A column a point where they are few, as one compares; else a row each.
std::string PointsTable(const std::vector<PointReport>& points) {
  constexpr size_t kFewPoints = 4;
  TableCells by_point{{""}};
  for (const HeadlineFigure& figure : HeadlineOf(points[0])) by_point[0].push_back(figure.name);
  for (const PointReport& point : points) {
    by_point.push_back({point.name});
    for (const HeadlineFigure& figure : HeadlineOf(point)) {
      by_point.back().push_back(
          figure.note.empty() ? figure.value : fmt::format("{}  {}", figure.value, figure.note));
    }
  }
  if (points.size() > kFewPoints) return TableHtml(by_point);
  TableCells turned(by_point[0].size());
  for (const auto& row : by_point) {
    for (size_t i = 0; i < row.size(); ++i) turned[i].push_back(row[i]);
  }
  return TableHtml(turned);
}

std::string ObjectsTable(const PointReport& point) {
  TableCells cells{{"part", "dropped", "picked", "recall [95 %]", "pick success [95 %]", "attempts",
                    "median MSSD, diameters [95 %]", "most often lost by"}};
  for (const ObjectReport& object : point.objects) {
    cells.push_back(
        {object.name, std::to_string(object.dropped), std::to_string(object.picked),
         RateText(object.recall), RateText(object.picks), std::to_string(object.picks.tries),
         MedianText(object.median_mssd_diameters, 3),
         object.commonest == Loss::kNone ? "" : std::string(LossName(object.commonest))});
  }
  return TableHtml(cells);
}

std::string ChartsHtml(const std::vector<ReportChart>& charts) {
  std::string html = "<div class=\"charts\">\n";
  for (const ReportChart& chart : charts) html += ChartHtml(chart);
  return html + "</div>\n";
}

// All charts of points that are seen together.
std::string ChartsOf(std::span<const PointReport> points) {
  std::string html = ChartHtml(LossChart(points));
  std::vector<ReportChart> curves = VisibilityCharts(points);
  if (points.size() == 1) curves.push_back(CalibrationChart(points));
  html += ChartsHtml(curves) + ChartsHtml(ErrorCharts(points));
  if (points.size() > 1) html += ChartHtml(CalibrationChart(points));
  return html + ChartHtml(SecondsChart(points));
}

std::string PointSection(const PointReport& point) {
  return HeadlineHtml(point) + ChartsOf({&point, 1}) + "<h3>Part by part</h3>\n" +
         ObjectsTable(point);
}

std::string OptionHtml(const std::string& value, const std::string& text) {
  return fmt::format("<option value=\"{}\">{}</option>", EscapeHtml(value), EscapeHtml(text));
}

std::string CardHtml(const GalleryEntry& entry, const std::string& point) {
  const LostPick& pick = entry.pick;
  const std::string reason(LossName(pick.loss)), stage(StageName(StageOf(pick.loss)));
  std::string data = fmt::format(" data-reason=\"{}\" data-trial=\"{}\"", reason, pick.trial);
  std::string facts;
  const auto fact = [&](const char* name, const std::string& value) {
    facts += fmt::format("<dt>{}</dt><dd>{}</dd>", name, EscapeHtml(value));
  };
  if (!point.empty()) fact("settings", point);
  if (!pick.object.empty()) fact("part", pick.object);
  if (pick.confidence >= 0) {
    data += fmt::format(" data-confidence=\"{:.4f}\"", pick.confidence);
    fact("confidence", fmt::format("{:.2f}", pick.confidence));
  }
  if (pick.mssd_diameters >= 0) {
    data += fmt::format(" data-error=\"{:.5f}\"", pick.mssd_diameters);
    fact("MSSD", fmt::format("{:.3f} diameters", pick.mssd_diameters));
  }
  if (pick.visible_fraction >= 0) {
    data += fmt::format(" data-visible=\"{:.4f}\"", pick.visible_fraction);
    fact("visible", fmt::format("{:.0f} %", 100 * pick.visible_fraction));
  }
  std::string picture;
  if (!entry.jpeg.empty()) {
    picture = fmt::format(
        "<img loading=\"lazy\" alt=\"overlay of {}, pick {}\" src=\"data:image/jpeg;base64,{}\">",
        EscapeHtml(entry.address), pick.pick, Base64(entry.jpeg));
  }
  return fmt::format(
      "<article class=\"failure\"{}>{}<b>{}</b>{} stage<br><code>{}</code> pick {}<dl>{}</dl>"
      "</article>\n",
      data, picture, reason, stage, EscapeHtml(entry.address), pick.pick, facts);
}

std::string GalleryHtml(const ReportContents& contents) {
  std::string html = Heading("Lost picks", "lost-picks");
  if (contents.gallery.empty()) {
    return html + Paragraph(contents.lost == 0 ? "No pick was lost." : contents.gallery_note);
  }
  html += Paragraph(contents.gallery_note, " class=\"note\"");
  std::set<Loss> reasons;
  for (const GalleryEntry& entry : contents.gallery) reasons.insert(entry.pick.loss);
  std::string reason_options = OptionHtml("", "all reasons");
  for (const Loss loss : reasons) {
    const std::string name(LossName(loss));
    reason_options += OptionHtml(name, fmt::format("{} ({})", name, StageName(StageOf(loss))));
  }
  html += fmt::format(
      "<div class=\"failures\"><div class=\"controls\">"
      "<label>Reason <select name=\"reason\">{}</select></label>"
      "<label>Order <select name=\"order\">{}{}{}{}{}</select></label>"
      "<span class=\"note shown\" role=\"status\"></span></div>\n<div class=\"gallery\">\n",
      reason_options, OptionHtml("trial", "by trial"), OptionHtml("reason", "by reason"),
      OptionHtml("confidence down", "surest first"),
      OptionHtml("error down", "largest error first"), OptionHtml("visible", "most hidden first"));
  const bool many = contents.points.size() > 1;
  for (const GalleryEntry& entry : contents.gallery) {
    html += CardHtml(entry, many ? contents.points.at(entry.pick.point).name : "");
  }
  return html + "</div></div>\n";
}

std::string LayerHtml(const ViewLayer& layer) {
  return fmt::format(
      "<label><input type=\"checkbox\" value=\"{}\" checked><span class=\"swatch\" "
      "style=\"background:{}\"></span>{}</label>",
      layer.prefix, layer.color, layer.name);
}

std::string ViewsHtml(const ReportContents& contents) {
  if (contents.views.empty() && contents.views_note.empty()) return "";
  std::string html = Heading("In 3D", "views") + Paragraph(contents.views_note, " class=\"note\"");
  if (contents.views.empty()) return html;
  html += "<div class=\"views screen\">\n";
  for (const ReportView& view : contents.views) {
    html += fmt::format(
        "<div class=\"view\"><h3>{0} <code>{1}</code></h3>"
        "<model-viewer camera-controls touch-action=\"pan-y\" interaction-prompt=\"none\" "
        "shadow-intensity=\"0\" exposure=\"0.75\" camera-orbit=\"25deg 50deg auto\" alt=\"{0}, "
        "{1}\" "
        "src=\"data:model/gltf-binary;base64,{2}\"></model-viewer><div class=\"controls\">",
        EscapeHtml(view.title), EscapeHtml(view.address), Base64(view.glb));
    for (const ViewLayer& layer : ViewLayers()) html += LayerHtml(layer);
    html += "</div></div>\n";
  }
  return html + "</div>\n";
}

std::string ComparisonsHtml(const std::vector<ReportTable>& tables) {
  std::string html;
  for (const ReportTable& table : tables) {
    html += Heading(table.title) + Paragraph(table.text) + TableHtml(table.cells);
  }
  return html;
}

std::string BodyOf(const ReportContents& contents) {
  std::string html = fmt::format("<h1>{}</h1>\n", EscapeHtml(contents.title));
  for (const std::string& text : contents.about) html += Paragraph(text);
  const std::vector<PointReport>& points = contents.points;
  if (points.size() == 1) {
    html += PointSection(points[0]);
  } else {
    html += PointsTable(points) + ComparisonsHtml(contents.comparisons) + Heading("Side by side") +
            ChartHtml(SuccessChart(points)) + ChartsOf(points);
  }
  html += GalleryHtml(contents) + ViewsHtml(contents);
  if (points.size() > 1) {
    for (const PointReport& point : points) html += Heading(point.name) + PointSection(point);
  }
  return html;
}

}  // namespace

std::string FilledPage(const std::string& title, const std::string& body, bool has_views) {
  std::string page = ReadTemplate();
  if (!has_views) RemoveViewsLibrary(page);
  Fill("@PICKBED_TITLE@", EscapeHtml(title), page);
  Fill("@PICKBED_BODY@", body, page);
  Fill("@PICKBED_VERSION@", PICKBED_VERSION, page);
  return page;
}

std::string ReportPage(const ReportContents& contents) {
  return FilledPage(contents.title, BodyOf(contents), !contents.views.empty());
}

}  // namespace pickbed
