#include "eval/compare/paired_comparison.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <limits>
#include <nlohmann/json.hpp>
#include <sstream>

#include "eval/metrics/metric_table.h"
#include "eval/trial/counts_by_bin.h"
#include "eval/trial/simulated_cell.h"
#include "scenes/base/error.h"

namespace pickbed::eval {
namespace {

using Scenes = std::vector<int>;

// With fewer scenes, the test of medians cannot reach p < 0.05 (2 / 2^n), and the interval cannot
// reach 95 %.
constexpr int kFewestScenes = 6;

constexpr std::array kSceneSettings{"seed:", "bin:", "objects:", "arrangement:"};
// In occlusion trials these also determine where blockers are placed to reach a visible fraction.
constexpr std::array kSeriesSettings{"camera:", "occlusion:"};
constexpr std::array kSceneHashes{"# part ", "# bin "};

template <size_t N>
bool BeginsWithAny(const std::string& line, const std::array<const char*, N>& heads) {
  return std::any_of(heads.begin(), heads.end(),
                     [&](const char* head) { return line.starts_with(head); });
}

// Returns whether the settings enable occlusion trials.
bool IsOccluded(const std::string& settings) {
  bool inside = false;
  std::istringstream lines(settings);
  for (std::string line; std::getline(lines, line);) {
    if (line.starts_with("  enabled: true") && inside) return true;
    if (!line.starts_with(" ")) inside = line.starts_with("occlusion:");
  }
  return false;
}

// Returns the group of a line, such as "objects" for "objects:" or "the parts' meshes" for "# part
// rod is 0123"; empty inside a group.
std::string GroupOf(const std::string& line) {
  if (line.empty() || line[0] == ' ' || line[0] == '-') return "";
  if (line[0] == '#') return line.starts_with("# bin") ? "the bin's mesh" : "the parts' meshes";
  return line.substr(0, line.find(':'));
}

bool OnceEach(const std::vector<Cluster>& clusters) {
  return std::all_of(clusters.begin(), clusters.end(),
                     [](const Cluster& cluster) { return cluster.tries <= 1; });
}

// Outcomes if each scene has one outcome in both runs. A scene without data in one run is not a
// pair.
struct OneOutcome {
  int pairs = 0;
  Discordance discordance;
};
OneOutcome OutcomesOf(const std::vector<Cluster>& before, const std::vector<Cluster>& after) {
  OneOutcome outcome;
  for (size_t i = 0; i < before.size(); ++i) {
    if (before[i].tries == 0 || after[i].tries == 0) continue;
    ++outcome.pairs;
    outcome.discordance.before_only += before[i].hits > after[i].hits;
    outcome.discordance.after_only += after[i].hits > before[i].hits;
  }
  return outcome;
}

void TestOneOutcome(const OneOutcome& outcome, PairedFigure& figure) {
  figure.test = "mcnemar";
  figure.p_value = McNemarExact(outcome.discordance);
  figure.odds_ratio = MatchedOddsRatio(outcome.discordance);
  const double discordant = static_cast<double>(figure.discordant_scenes) / outcome.pairs;
  figure.scenes_needed = ScenesNeededForMcNemar(figure.difference(), discordant);
}

PairedFigure PairedMedian(const std::string& key, const std::string& name,
                          const ValueClusters& before, const ValueClusters& after) {
  PairedFigure figure{key, name, false, MedianOf(before), MedianOf(after)};
  for (size_t i = 0; i < before.size(); ++i) {
    figure.scenes += !before[i].empty() || !after[i].empty();
    figure.discordant_scenes += before[i] != after[i];
  }
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  figure.difference_ci95 = figure.scenes < kFewestScenes ? Interval{-kInfinity, kInfinity}
                                                         : PairedMedianInterval(before, after);
  figure.p_value = PairedMedianTest(before, after);
  figure.test = "sign_flip";
  return figure;
}

ErrorOfPose ShownErrorOf(const MetricRow& row) {
  return [key = MetricKey(row), unit = ShownUnitOf(row)](const HypothesisRecord& pose) {
    return pose.metrics.Get(key) * unit.numerator / unit.denominator;
  };
}

struct NamedRate {
  std::string key, name;
  TrialCount count;
};

std::vector<NamedRate> Rates(const std::vector<VisibleBand>& bands) {
  std::vector<NamedRate> rates{{"pick_success", "pick success", SuccessOfAttempts()},
                               {"cleared", "parts cleared", InstancesCleared()},
                               {"top1", "top-ranked pose right", TopRankedRight()}};
  rates.push_back({"recall", "recall", InstancesRecalled(kCountedVisibility, 1)});
  const auto add_bands = [&](const char* key, const char* name, auto count) {
    for (const VisibleBand& band : bands) {
      std::string ends = band.name();
      std::replace(ends.begin(), ends.end(), '-', '_');
      rates.push_back({fmt::format("{}_{}", key, ends),
                       fmt::format("{}, {} % visible", name, band.name()),
                       count(band.min, band.max)});
    }
  };
  add_bands("recall", "recall", InstancesRecalled);
  add_bands("target_picked", "target picked", TargetsPicked);
  return rates;
}

// Formats rates in percent, errors in their unit.
std::string Valued(const PairedFigure& figure, double value) {
  return figure.is_rate ? PercentNumber(value) : fmt::format("{:.4f}", value);
}

std::string Signed(const PairedFigure& figure, double value) {
  if (figure.is_rate) return PointsText(value);
  return std::isfinite(value) ? fmt::format("{:+.4f}", value) : "-";
}

nlohmann::ordered_json Number(double value) {
  return std::isfinite(value) ? nlohmann::ordered_json(value) : nlohmann::ordered_json();
}

}  // namespace

PairedFigure PairedRate(const std::string& key, const std::string& name,
                        const std::vector<Cluster>& before, const std::vector<Cluster>& after) {
  PairedFigure figure{key, name, true, RateOf(before), RateOf(after)};
  for (size_t i = 0; i < before.size(); ++i) {
    figure.scenes += before[i].tries > 0 || after[i].tries > 0;
    figure.discordant_scenes += before[i].hits * after[i].tries != after[i].hits * before[i].tries;
  }
  figure.difference_ci95 = PairedInterval(before, after);
  const OneOutcome outcome = OutcomesOf(before, after);
  if (OnceEach(before) && OnceEach(after) && outcome.pairs == figure.scenes) {
    TestOneOutcome(outcome, figure);
    return figure;
  }
  figure.test = "sign_flip";
  figure.p_value = PairedRateTest(before, after);
  figure.scenes_needed = ScenesNeeded(figure.difference(), DeviationOfRise(before, after));
  return figure;
}

PairedComparison ComparePaired(std::span<const TrialResult> before,
                               std::span<const TrialResult> after,
                               const std::vector<VisibleBand>& bands) {
  const Scenes scenes_before = ScenesOf(before), scenes_after = ScenesOf(after);
  Scenes shared;
  std::set_intersection(scenes_before.begin(), scenes_before.end(), scenes_after.begin(),
                        scenes_after.end(), std::back_inserter(shared));
  CheckInput(!shared.empty(),
             "the runs share no scenes: none of their finished trials is about the same one");
  PairedComparison comparison;
  comparison.scenes = static_cast<int>(shared.size());
  comparison.before_only = static_cast<int>(scenes_before.size() - shared.size());
  comparison.after_only = static_cast<int>(scenes_after.size() - shared.size());
  for (const NamedRate& rate : Rates(bands)) {
    const auto a = CountByScene(before, shared, rate.count);
    const auto b = CountByScene(after, shared, rate.count);
    if (SumOf(a).tries == 0 || SumOf(b).tries == 0) continue;
    comparison.figures.push_back(PairedRate(rate.key, rate.name, a, b));
  }
  for (const MetricRow& row : MetricsIn(kCompared)) {
    const PairedErrors errors = PairedErrorsByScene(before, after, shared, ShownErrorOf(row));
    if (std::isnan(MedianOf(errors.before))) continue;
    comparison.figures.push_back(PairedMedian("median_" + ShownKey(row), "median " + ShownName(row),
                                              errors.before, errors.after));
  }
  return comparison;
}

std::string SceneKey(const std::string& settings) {
  const bool occluded = IsOccluded(settings);
  std::string key = fmt::format("occlusion.enabled: {}\n", occluded);
  bool wanted = false;
  std::istringstream lines(settings);
  for (std::string line; std::getline(lines, line);) {
    if (line.empty()) continue;
    const bool is_inside = line[0] == ' ' || line[0] == '-';
    if (!is_inside) {
      wanted =
          BeginsWithAny(line, kSceneSettings) || (occluded && BeginsWithAny(line, kSeriesSettings));
    }
    if (wanted || BeginsWithAny(line, kSceneHashes)) key += line + "\n";
  }
  return key;
}

void RequireSameScenes(const std::string& settings_before, const std::string& settings_after,
                       const std::string& name_before, const std::string& name_after) {
  const std::string before = SceneKey(settings_before), after = SceneKey(settings_after);
  if (before == after) return;
  std::istringstream lines_before(before), lines_after(after);
  std::string a, b, group;
  while (true) {
    const bool more_a = static_cast<bool>(std::getline(lines_before, a));
    const bool more_b = static_cast<bool>(std::getline(lines_after, b));
    if (!more_a) a = "nothing";
    if (!more_b) b = "nothing";
    const std::string begun = GroupOf(more_a ? a : b);
    if (!begun.empty()) group = begun;
    if (a != b) break;
  }
  const auto trimmed = [](const std::string& line) {
    return line.substr(std::min(line.size(), line.find_first_not_of(" -")));
  };
  throw InputError(
      fmt::format("{} and {} share no scenes: they differ in {}: '{}' in one, '{}' "
                  "in the other",
                  name_before, name_after, group, trimmed(a), trimmed(b)));
}

std::string PairedTable(const PairedComparison& comparison) {
  std::string text = fmt::format(
      "{} scenes that both have\n"
      "Differences with 95 % intervals over scenes; needed: scenes that show such a difference of\n"
      "rates four times in five\n  {:<28}{:>9}{:>9}  {:<28}{:>8}{:>11}{:>9}\n",
      comparison.scenes, "", "A", "B", "B - A", "p", "differ in", "needed");
  for (const PairedFigure& figure : comparison.figures) {
    const std::string difference = fmt::format("{} [{}, {}]", Signed(figure, figure.difference()),
                                               Signed(figure, figure.difference_ci95.low),
                                               Signed(figure, figure.difference_ci95.high));
    text += fmt::format("  {:<28}{:>9}{:>9}  {:<28}{:>8.4f}{:>11}{:>9}\n",
                        figure.name + (figure.is_rate ? ", %" : ""), Valued(figure, figure.before),
                        Valued(figure, figure.after), difference, figure.p_value,
                        fmt::format("{}/{}", figure.discordant_scenes, figure.scenes),
                        figure.scenes_needed ? std::to_string(*figure.scenes_needed) : "-");
  }
  return text;
}

std::string PairedJson(const PairedComparison& comparison) {
  nlohmann::ordered_json json;
  json["scenes"] = comparison.scenes;
  json["scenes_of_first_only"] = comparison.before_only;
  json["scenes_of_second_only"] = comparison.after_only;
  json["statistics"] = nlohmann::ordered_json::array();
  for (const PairedFigure& figure : comparison.figures) {
    auto& row = json["statistics"].emplace_back();
    row["key"] = figure.key;
    row["name"] = figure.name;
    row["before"] = Number(figure.before);
    row["after"] = Number(figure.after);
    row["difference"] = Number(figure.difference());
    row["difference_ci95"] = {Number(figure.difference_ci95.low),
                              Number(figure.difference_ci95.high)};
    row["p_value"] = figure.p_value;
    row["test"] = figure.test;
    row["scenes"] = figure.scenes;
    row["discordant_scenes"] = figure.discordant_scenes;
    auto& needed = row["scenes_needed"];
    if (figure.scenes_needed) needed = *figure.scenes_needed;
    if (!figure.odds_ratio) continue;
    row["odds_ratio"] = Number(figure.odds_ratio->ratio);
    row["odds_ratio_ci95"] = {Number(figure.odds_ratio->interval.low),
                              Number(figure.odds_ratio->interval.high)};
  }
  return json.dump(2) + "\n";
}

}  // namespace pickbed::eval
