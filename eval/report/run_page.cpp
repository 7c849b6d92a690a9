#include "eval/report/run_page.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "eval/page/html.h"
#include "eval/report/views_3d.h"

namespace pickbed::eval {
namespace {

struct HeadlineStatistic {
  std::string name, value, note;
};

std::string CycleNote(const CycleTime& cycle) {
  std::string note =
      fmt::format("per instance: sense {:.1f} s, move {:.1f} s", cycle.sense_s, cycle.move_s);
  if (!cycle.measured) note += fmt::format(", compute {:.1f} s", cycle.compute_s);
  if (cycle.stated_hidden_s > 0) {
    note += fmt::format(", {:.1f} s hidden behind motion", cycle.stated_hidden_s);
  }
  return note + (cycle.measured ? "; without the time to compute" : "");
}

std::vector<HeadlineStatistic> HeadlineOf(const ConfigurationReport& configuration) {
  const RunSummary& s = configuration.summary;
  std::vector<HeadlineStatistic> headline;
  const auto add = [&](const std::string& name, const ReportRate& rate, const std::string& what) {
    headline.push_back(
        {name, PercentText(rate.hits, rate.samples),
         fmt::format("{}{} of {} {}", rate.ci95.is_known() ? IntervalText(rate.ci95) + " " : "",
                     rate.hits, rate.samples, what)});
  };
  const bool has_targets = s.target_recall.samples > 0;
  if (has_targets) add("targets picked", s.attempts_picked, "attempts");
  const bool has_stirs = s.failures.contains(std::string(FailureName(FailureReason::kStirred)));
  add("pick success", {s.successes, s.executed_grasps, s.success_ci95},
      has_stirs ? "executed grasps and stirs" : "executed grasps");
  if (!has_targets) {
    const bool all = s.requested_picked.samples == s.instances_dropped;
    add("instances cleared", s.requested_picked, all ? "dropped" : "requested");
    add("attempts that picked", s.attempts_picked, "attempts");
  } else {
    add("target recall", s.target_recall, "targets");
  }
  if (s.has_poses()) {
    add("recall", s.recall, "instances in view");
    add("precision", s.precision,
        fmt::format("poses, {} false", s.precision.samples - s.precision.hits));
    add("top-ranked pose right", {s.top1_correct, s.frames, s.top1_ci95}, "images");
  }
  const double per_hour = s.cycle.stated_picks_per_hour();
  headline.push_back({"picks per hour", per_hour > 0 ? fmt::format("{:.0f}", per_hour) : "-",
                      per_hour > 0 ? CycleNote(s.cycle) : ""});
  const int attempts = s.attempts_picked.samples;
  if (!has_targets && s.images > 0 && s.images < attempts) {
    headline.push_back(
        {"images", std::to_string(s.images),
         fmt::format("{:.1f} attempts each", static_cast<double>(attempts) / s.images)});
  }
  if (s.retention.picks > 0) {
    headline.push_back({"retention", fmt::format("{:.1f} g", s.retention.median_g),
                        fmt::format("median of {} hold tests, minimum {:.1f} g", s.retention.picks,
                                    s.retention.min_g)});
  }
  headline.push_back(
      {"bins", std::to_string(s.trials),
       s.refused.empty() ? "" : fmt::format("{} rejected and dropped again", s.refused.size())});
  return headline;
}

std::string HeadlineHtml(const ConfigurationReport& configuration) {
  std::string html = "<div class=\"headline\">\n";
  for (const HeadlineStatistic& statistic : HeadlineOf(configuration)) {
    html += fmt::format("<div><b>{1}</b>{0}<span>{2}</span></div>\n", EscapeHtml(statistic.name),
                        EscapeHtml(statistic.value), EscapeHtml(statistic.note));
  }
  html += "</div>\n";
  const RunSummary& s = configuration.summary;
  html += fmt::format("<p class=\"note\">{}</p>\n",
                      EscapeHtml(FewBinsText(s.trials) + " " + InViewText(s)));
  if (s.clutter.layers.size() > 1) {
    std::string lines = EscapeHtml(ClutterText(s.clutter, ""));
    lines.pop_back();
    for (size_t end; (end = lines.find('\n')) != std::string::npos;) lines.replace(end, 1, "<br>");
    html += fmt::format("<p class=\"note\">Before the first pick: {}</p>\n", lines);
  }
  if (s.executed_grasps == 0) return html;
  if (s.by_layer.size() > 1) {
    TableCells layers{{"layer, 1 = top", "success [95 %]", "executed grasps"}};
    for (const LayerRate& layer : s.by_layer) {
      layers.push_back(
          {layer.name(), ShortRateText(layer.success), std::to_string(layer.success.samples)});
    }
    html += "<details><summary>Success by layer</summary>" + TableHtml(layers) + "</details>\n";
  }
  TableCells cells{{"rule", "success", "95 %", "passes when"}};
  for (const RuleRate& rate : s.by_rule) {
    const SuccessRuleRow& row = SuccessRuleTable()[static_cast<size_t>(rate.rule)];
    cells.push_back({row.name, PercentText(rate.rate()), IntervalText(rate.ci95), row.help});
  }
  return html + "<details><summary>Success by each rule</summary>" + TableHtml(cells) +
         "</details>\n";
}

// Few configurations get one column each, to compare them. Many get one row each.
TableCells ConfigurationsTable(const std::vector<ConfigurationReport>& configurations) {
  constexpr size_t kFewConfigurations = 4;
  TableCells by_configuration{{""}};
  for (const HeadlineStatistic& statistic : HeadlineOf(configurations[0]))
    by_configuration[0].push_back(statistic.name);
  for (const ConfigurationReport& configuration : configurations) {
    by_configuration.push_back({configuration.name});
    for (const HeadlineStatistic& statistic : HeadlineOf(configuration)) {
      const std::string& note = statistic.note;
      const char* separator = note.empty() ? "" : note.starts_with('[') ? " " : ", ";
      by_configuration.back().push_back(statistic.value + separator + note);
    }
  }
  if (configurations.size() > kFewConfigurations) return by_configuration;
  TableCells transposed(by_configuration[0].size());
  for (const auto& row : by_configuration) {
    for (size_t i = 0; i < row.size(); ++i) transposed[i].push_back(row[i]);
  }
  return transposed;
}

TableCells ObjectsTable(const ConfigurationReport& configuration) {
  const bool has_targets = configuration.summary.target_recall.samples > 0;
  TableCells cells{{"object", "dropped", "picked",
                    has_targets ? "target recall [95 %]" : "recall [95 %]", "pick success [95 %]",
                    "attempts", "median MSSD, diameters [95 %]", "most frequent failure"}};
  for (const ObjectReport& object : configuration.objects) {
    cells.push_back(
        {object.name, std::to_string(object.dropped), std::to_string(object.picked),
         ShortRateText(object.recall), ShortRateText(object.picks),
         std::to_string(object.picks.samples), MedianText(object.median_mssd_diameters, 3),
         object.commonest == FailureReason::kNone ? ""
                                                  : std::string(FailureName(object.commonest))});
  }
  return cells;
}

// Adds the charts that show these configurations together. Many configurations get only curves:
// bars have no more than seven fills.
void AddCharts(std::span<const ConfigurationReport> configurations, HtmlPage& page) {
  constexpr size_t kMaxBarSeries = 7;
  const bool has_bars = configurations.size() <= kMaxBarSeries;
  if (has_bars) {
    page.Chart(FailureChart(configurations));
    page.Chart(RejectionsChart(configurations));
  } else {
    page.Note("These are many settings. Each has all of its charts in its own section below.");
  }
  const bool has_poses = std::ranges::any_of(
      configurations, [](const auto& report) { return report.summary.has_poses(); });
  std::vector<ReportChart> curves = VisibilityCharts(configurations);
  if (has_poses && configurations.size() == 1) curves.push_back(CalibrationChart(configurations));
  // The attempts of an occlusion trial are separate scenes, in which no bin empties.
  const auto has_targets = [](const BandRates& band) { return band.targets.samples > 0; };
  if (configurations[0].attempt_ranges.size() > 1 &&
      std::none_of(configurations[0].bands.begin(), configurations[0].bands.end(), has_targets)) {
    curves.push_back(AttemptsChart(configurations));
  }
  if (std::any_of(configurations.begin(), configurations.end(),
                  [](const auto& report) { return !report.summary.hidden.empty(); })) {
    curves.push_back(HiddenShareChart(configurations));
  }
  if (std::any_of(configurations.begin(), configurations.end(),
                  [](const auto& report) { return report.summary.by_fill.size() > 1; })) {
    curves.push_back(FillChart(configurations));
  }
  page.Charts(curves);
  if (!has_bars) return;
  if (has_poses) {
    page.Charts(ErrorCharts(configurations));
    page.Charts(ErrorByBandCharts(configurations));
    if (configurations.size() > 1) page.Chart(CalibrationChart(configurations));
  }
  page.Chart(SecondsChart(configurations));
}

void AddPoint(const ConfigurationReport& configuration, HtmlPage& page) {
  page.Html(HeadlineHtml(configuration));
  AddCharts({&configuration, 1}, page);
  page.Subheading("By object");
  page.Table(ObjectsTable(configuration));
}

std::string OptionHtml(const std::string& value, const std::string& text) {
  return fmt::format("<option value=\"{}\">{}</option>", EscapeHtml(value), EscapeHtml(text));
}

std::string CardHtml(const GalleryEntry& entry, const std::string& configuration) {
  const FailedPick& pick = entry.pick;
  const std::string reason(FailureName(pick.failure)), stage(StageName(StageOf(pick.failure)));
  std::string data = fmt::format(" data-reason=\"{}\" data-trial=\"{}\"", reason, pick.trial);
  std::string facts;
  const auto fact = [&](const char* name, const std::string& value) {
    facts += fmt::format("<dt>{}</dt><dd>{}</dd>", name, EscapeHtml(value));
  };
  if (!configuration.empty()) fact("settings", configuration);
  if (!pick.object.empty()) fact("object", pick.object);
  if (pick.confidence >= 0) {
    data += fmt::format(" data-confidence=\"{:.4f}\"", pick.confidence);
    fact("score", fmt::format("{:.2f}", pick.confidence));
  }
  if (pick.mssd_diameters >= 0) {
    data += fmt::format(" data-error=\"{:.5f}\"", pick.mssd_diameters);
    fact("MSSD", fmt::format("{:.3f} diameters", pick.mssd_diameters));
  }
  if (pick.visible_fraction >= 0) {
    data += fmt::format(" data-visible=\"{:.4f}\"", pick.visible_fraction);
    fact("visible", WholePercentText(pick.visible_fraction));
  }
  std::string picture;
  if (!entry.jpeg.empty()) {
    picture = fmt::format(
        "<img loading=\"lazy\" alt=\"overlay of {}, attempt {}\" "
        "src=\"data:image/jpeg;base64,{}\">",
        EscapeHtml(entry.address), pick.attempt, Base64(entry.jpeg));
    if (!entry.link.empty()) {
      picture = fmt::format("<a href=\"{}\" title=\"full picture\">{}</a>", EscapeHtml(entry.link),
                            picture);
    }
  }
  return fmt::format(
      "<article class=\"failure\"{}>{}<b>{}</b>{} stage<br><code>{}</code> attempt {}<dl>{}</dl>"
      "</article>\n",
      data, picture, reason, stage, EscapeHtml(entry.address), pick.attempt, facts);
}

void AddDifferentSettings(const TableCells& settings, HtmlPage& page) {
  if (settings.empty()) return;
  page.Heading("Settings that differ", "settings-that-differ");
  if (settings.size() == 1) return page.Note("All settings that affect the results are equal.");
  page.Table(settings);
}

// Many tables are collapsed, so that the charts below them are not overlooked.
void AddComparisons(const std::vector<ReportTable>& comparisons, HtmlPage& page) {
  constexpr size_t kFewComparisons = 3;
  if (comparisons.size() <= kFewComparisons) {
    for (const ReportTable& table : comparisons) {
      page.Heading(table.title);
      page.Paragraph(table.text);
      page.Table(table.cells);
    }
    return;
  }
  page.Heading("Paired differences", "paired-differences");
  for (const ReportTable& table : comparisons) {
    page.Html(fmt::format("<details><summary>{}</summary><p>{}</p>{}</details>\n",
                          EscapeHtml(table.title), EscapeHtml(table.text), TableHtml(table.cells)));
  }
}

void AddGallery(const ReportContents& contents, HtmlPage& page) {
  page.Heading("Failed picks", "failed-picks");
  if (contents.gallery.empty()) {
    page.Paragraph(contents.failed_picks == 0 ? "No pick failed." : contents.gallery_note);
    return;
  }
  page.Note(contents.gallery_note);
  page.Note(
      "In a picture: thick line, pose of the grasp with its score; blue and tick, right; orange, "
      "dashed and cross, wrong; yellow, the requested instance; white dots, not found; white "
      "lines, the hand.");
  std::set<FailureReason> reasons;
  for (const GalleryEntry& entry : contents.gallery) reasons.insert(entry.pick.failure);
  std::string reason_options = OptionHtml("", "all reasons");
  for (const FailureReason failure : reasons) {
    const std::string name(FailureName(failure));
    reason_options += OptionHtml(name, fmt::format("{} ({})", name, StageName(StageOf(failure))));
  }
  std::string html = fmt::format(
      "<div class=\"failures\"><div class=\"controls\">"
      "<label>Reason <select name=\"reason\">{}</select></label>"
      "<label>Order <select name=\"order\">{}{}{}{}{}</select></label>"
      "<span class=\"note shown\" role=\"status\"></span></div>\n<div class=\"gallery\">\n",
      reason_options, OptionHtml("trial", "by trial"), OptionHtml("reason", "by reason"),
      OptionHtml("confidence down", "highest score first"),
      OptionHtml("error down", "largest error first"), OptionHtml("visible", "most hidden first"));
  const bool many = contents.configurations.size() > 1;
  for (const GalleryEntry& entry : contents.gallery) {
    html += CardHtml(entry, many ? contents.configurations.at(entry.pick.configuration).name : "");
  }
  page.Html(html + "</div></div>\n");
}

std::string LayerHtml(const ViewLayer& layer) {
  return fmt::format(
      "<label><input type=\"checkbox\" value=\"{}\" checked><span class=\"swatch\" "
      "style=\"background:{}\"></span>{}</label>",
      layer.prefix, layer.color, layer.name);
}

// Title and 3D viewer, with these further attributes.
std::string ViewerHtml(const ReportView& view, const char* attributes) {
  return fmt::format(
      "<h3>{0} <code>{1}</code></h3>"
      "<model-viewer camera-controls touch-action=\"pan-y\" interaction-prompt=\"none\" "
      "shadow-intensity=\"0\" exposure=\"0.75\" {3} alt=\"{0}, {1}\" "
      "src=\"data:model/gltf-binary;base64,{2}\"></model-viewer>",
      EscapeHtml(view.title), EscapeHtml(view.address), Base64(view.glb), attributes);
}

void AddAnimatedPicks(const ReportContents& contents, HtmlPage& page) {
  if (contents.picks.empty() && contents.picks_note.empty()) return;
  page.Heading("Animated picks", "picks");
  if (contents.picks.empty()) return page.Note(contents.picks_note);
  page.Note(
      "The hand approaches, closes, lifts and carries, and all objects move as in the simulation. "
      "Drag to rotate. " +
      contents.picks_note);
  std::string html = "<div class=\"views screen\">\n";
  for (const ReportView& pick : contents.picks) {
    html += "<div class=\"pick\">" +
            ViewerHtml(pick, "autoplay camera-orbit=\"20deg 55deg auto\"") +
            "<div class=\"controls\"><button type=\"button\">Pause</button>"
            "<input type=\"range\" min=\"0\" max=\"1\" step=\"any\" value=\"0\" "
            "aria-label=\"time\"><span class=\"note\"></span></div></div>\n";
  }
  page.Html(html + "</div>\n");
}

void AddViews(const ReportContents& contents, HtmlPage& page) {
  if (contents.views.empty() && contents.views_note.empty()) return;
  page.Heading("In 3D", "views");
  page.Note(contents.views_note);
  if (contents.views.empty()) return;
  std::string html = "<div class=\"views screen\">\n";
  for (const ReportView& view : contents.views) html += ViewHtml(view);
  page.Html(html + "</div>\n");
}

void AddScenarios(const std::vector<ShownScenario>& scenarios, HtmlPage& page) {
  if (scenarios.empty()) return;
  page.Heading("Scenario", "scenario");
  for (const ShownScenario& scenario : scenarios) {
    const std::string name = scenario.name.empty() ? "All settings" : scenario.name;
    page.Html(fmt::format("<details><summary>{}</summary><pre>{}</pre></details>\n",
                          EscapeHtml(name), EscapeHtml(scenario.settings)));
    if (scenario.link.empty()) continue;
    page.Html(fmt::format("<p class=\"note\">File: <a href=\"{0}\">{0}</a></p>\n",
                          EscapeHtml(scenario.link)));
  }
}

}  // namespace

std::string ViewHtml(const ReportView& view) {
  std::string html = "<div class=\"view\">" +
                     ViewerHtml(view, "camera-orbit=\"25deg 50deg auto\"") +
                     "<div class=\"controls\">";
  for (const ViewLayer& layer : ViewLayers()) {
    // Names in the scene begin with the prefix of their layer.
    const bool is_shown = view.glb.find(std::string("\"") + layer.prefix) != std::string::npos;
    if (is_shown || !layer.is_optional) html += LayerHtml(layer);
  }
  return html + "</div></div>\n";
}

std::string ReportPage(const ReportContents& contents) {
  HtmlPage page(contents.title);
  for (const std::string& text : contents.about) page.Paragraph(text);
  if (!contents.overlay_jpeg.empty()) {
    page.Html(
        fmt::format("<img class=\"overlay\" alt=\"the first bin with the estimated poses\" "
                    "src=\"data:image/jpeg;base64,{}\">\n",
                    Base64(contents.overlay_jpeg)));
  }
  const std::vector<ConfigurationReport>& configurations = contents.configurations;
  if (configurations.size() == 1) {
    AddPoint(configurations[0], page);
  } else {
    page.Html("<div class=\"summary\">" + TableHtml(ConfigurationsTable(configurations)) +
              "</div>\n");
    AddDifferentSettings(contents.different_settings, page);
    AddComparisons(contents.comparisons, page);
    page.Heading("Side by side");
    page.Chart(SuccessChart(configurations));
    AddCharts(configurations, page);
  }
  AddGallery(contents, page);
  AddAnimatedPicks(contents, page);
  AddViews(contents, page);
  AddScenarios(contents.scenarios, page);
  if (configurations.size() > 1) {
    for (const ConfigurationReport& configuration : configurations) {
      page.Heading(configuration.name);
      AddPoint(configuration, page);
    }
  }
  return page.Finish();
}

}  // namespace pickbed::eval
