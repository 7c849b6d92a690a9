#include <fmt/format.h>

#include <algorithm>

#include "eval/page/vega.h"
#include "eval/report/charts.h"

namespace pickbed::eval {
namespace {

const StageTime* TimeOf(const ConfigurationReport& configuration, const std::string& stage) {
  const auto found = std::find_if(configuration.seconds.begin(), configuration.seconds.end(),
                                  [&](const StageTime& time) { return time.stage == stage; });
  return found == configuration.seconds.end() ? nullptr : &*found;
}

// Returns the stages in the order of the first configuration, followed by the stages of others.
std::vector<std::string> StagesOf(std::span<const ConfigurationReport> configurations) {
  std::vector<std::string> stages;
  for (const ConfigurationReport& configuration : configurations) {
    for (const StageTime& time : configuration.seconds) {
      if (std::find(stages.begin(), stages.end(), time.stage) == stages.end()) {
        stages.push_back(time.stage);
      }
    }
  }
  return stages;
}

}  // namespace

ReportChart SecondsChart(std::span<const ConfigurationReport> configurations) {
  ReportChart chart{"seconds", "Time of each stage",
                    "Mean computing time of a trial; the line is from the 10th to the 90th "
                    "percentile over trials. \"estimate/icp\" is included in \"estimate\". Times "
                    "depend on the machine and differ from run to run.",
                    ""};
  chart.table = {{"stage"}};
  for (const ConfigurationReport& configuration : configurations) {
    const std::string prefix = configurations.size() > 1 ? configuration.name + ": " : "";
    chart.table[0].insert(chart.table[0].end(), {prefix + "mean, s", "10 % to 90 %"});
  }
  const std::vector<std::string> stages = StagesOf(configurations), names = NamesOf(configurations);
  Json values = Json::array();
  for (const std::string& stage : stages) {
    chart.table.push_back({stage});
    for (const ConfigurationReport& configuration : configurations) {
      const StageTime* time = TimeOf(configuration, stage);
      if (time == nullptr) {
        chart.table.back().insert(chart.table.back().end(), {"-", ""});
        continue;
      }
      const std::string range = fmt::format("{:.3f} to {:.3f}", time->low_s, time->high_s);
      chart.table.back().insert(chart.table.back().end(),
                                {fmt::format("{:.3f}", time->mean_s), range});
      values.push_back({{"stage", stage},
                        {"series", configuration.name},
                        {"mean", time->mean_s},
                        {"low", time->low_s},
                        {"high", time->high_s},
                        {"text", fmt::format("{:.3f} s, {}", time->mean_s, range)}});
    }
  }
  if (values.empty()) {
    chart.caption = "The run has no times.";
    return chart;
  }
  Json y = Field("stage", "nominal", "");
  y["sort"] = stages;
  y["title"] = nullptr;
  Json x = Field("mean", "quantitative", "seconds per trial");
  x["axis"] = {{"tickCount", 8}};
  Json bar{{"y", y}, {"x", x}};
  if (configurations.size() > 1) {
    bar["yOffset"] = {{"field", "series"}, {"type", "nominal"}, {"sort", names}};
  }
  Json line = bar;
  line["x"]["field"] = "low";
  line["x2"] = {{"field", "high"}};
  bar["fill"] = SeriesFill("series", names);
  bar["tooltip"] = {{{"field", "stage"}, {"type", "nominal"}},
                    {{"field", "text"}, {"type", "nominal"}, {"title", "time"}}};
  Json spec = EmptySpec(values);
  spec["height"] = BarsHeight_px(stages.size(), configurations.size());
  spec["layer"] = {{{"mark", {{"type", "bar"}}}, {"encoding", bar}},
                   {{"mark", {{"type", "rule"}, {"color", "currentColor"}, {"strokeWidth", 1.5}}},
                    {"encoding", line}}};
  chart.spec = spec.dump();
  return chart;
}

}  // namespace pickbed::eval
