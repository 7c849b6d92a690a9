#include <fmt/format.h>

#include <algorithm>

#include "eval/report/charts_impl.h"

namespace pickbed {
namespace {

constexpr double kRoomForText = 1.35;  // of the longest bar, for what stands at its end

ReportRate RateOf(const BudgetShares& shares, Loss loss) {
  return {shares.budget[loss], shares.budget.asked(), shares[loss]};
}

std::string LossLabel(const LossRow& row) {
  return fmt::format("{}: {}", StageName(row.stage), row.name);
}

bool AnyLost(std::span<const PointReport> points, Loss loss) {
  for (const PointReport& point : points) {
    if (point.attempts.budget[loss] > 0) return true;
  }
  return false;
}

TableCells LossTableCells(std::span<const PointReport> points) {
  TableCells cells{{"stage", "reason", "means"}};
  for (const PointReport& point : points) {
    cells[0].push_back(points.size() > 1 ? point.name : "looks");
    cells[0].push_back("share [95 %]");
  }
  const auto add = [&](std::vector<std::string> row, auto rate_of) {
    for (const PointReport& point : points) {
      const ReportRate rate = rate_of(point.attempts);
      row.push_back(std::to_string(rate.hits));
      row.push_back(RateText(rate));
    }
    cells.push_back(std::move(row));
  };
  for (const LossRow& row : LossTable()) {
    if (row.loss == Loss::kNone || !AnyLost(points, row.loss)) continue;
    add({std::string(StageName(row.stage)), std::string(row.name), std::string(row.help)},
        [&](const BudgetShares& shares) { return RateOf(shares, row.loss); });
  }
  add({"done", "picked", "the look brought its part"}, [](const BudgetShares& shares) {
    return ReportRate{shares.budget.picked, shares.budget.asked(), shares.picked};
  });
  return cells;
}

// A bar for each reason and point.
struct LossBars {
  Json values = Json::array();
  std::vector<std::string> labels;  // of the reasons
  double longest = 0;
};

LossBars BarsOf(std::span<const PointReport> points) {
  LossBars bars;
  for (const LossRow& row : LossTable()) {
    if (row.loss == Loss::kNone || !AnyLost(points, row.loss)) continue;
    bars.labels.push_back(LossLabel(row));
    for (const PointReport& point : points) {
      const ReportRate rate = RateOf(point.attempts, row.loss);
      bars.longest = std::max(bars.longest, rate.ci95.high);
      bars.values.push_back({{"reason", bars.labels.back()},
                             {"series", point.name},
                             {"share", rate.rate()},
                             {"low", rate.ci95.low},
                             {"high", rate.ci95.high},
                             {"means", row.help},
                             {"text", fmt::format("{} ({:.1f} %)", rate.hits, 100 * rate.rate())}});
    }
  }
  return bars;
}

}  // namespace

ReportChart LossChart(std::span<const PointReport> points) {
  ReportChart chart{"losses", "Where picks were lost",
                    "Each look at a bin that holds parts asks for one. It brings it or is lost "
                    "for one reason, which belongs to one stage; looks that found no grasp are "
                    "among the lost. Lines: 95 % intervals, with scenes as units.",
                    ""};
  chart.table = LossTableCells(points);
  const LossBars bars = BarsOf(points);
  if (bars.labels.empty()) {
    chart.caption += " No pick was lost.";
    return chart;
  }
  Json spec = EmptySpec(bars.values);
  const std::vector<std::string> names = NamesOf(points);
  Json y = Field("reason", "nominal", "");
  y["sort"] = bars.labels;
  y["title"] = nullptr;
  Json encoding{{"y", y}, {"x", PercentField("share", "share of looks", false)}};
  encoding["x"]["scale"] = {{"domain", {0, kRoomForText * bars.longest}}};
  Json text_encoding = encoding, line_encoding = encoding;
  text_encoding["x"]["field"] = "high";
  line_encoding["x"]["field"] = "low";
  line_encoding["x2"] = {{"field", "high"}};
  encoding["fill"] = SeriesFill("series", names);
  encoding["tooltip"] = {{{"field", "reason"}, {"type", "nominal"}},
                         {{"field", "means"}, {"type", "nominal"}},
                         {{"field", "text"}, {"type", "nominal"}, {"title", "looks"}}};
  text_encoding["text"] = {{"field", "text"}, {"type", "nominal"}};
  if (points.size() > 1) {
    const Json offset{{"field", "series"}, {"type", "nominal"}, {"sort", names}};
    encoding["yOffset"] = text_encoding["yOffset"] = line_encoding["yOffset"] = offset;
  }
  spec["height"] = BarsHeight_px(bars.labels.size(), points.size());
  spec["layer"] = {
      {{"mark", {{"type", "bar"}}}, {"encoding", encoding}},
      {{"mark", {{"type", "rule"}, {"color", "currentColor"}, {"strokeWidth", 1.5}}},
       {"encoding", line_encoding}},
      {{"mark", {{"type", "text"}, {"align", "left"}, {"dx", 5}}}, {"encoding", text_encoding}}};
  chart.spec = spec.dump();
  return chart;
}

}  // namespace pickbed
