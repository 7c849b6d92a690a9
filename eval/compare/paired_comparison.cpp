#include "eval/compare/paired_comparison.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <nlohmann/json.hpp>
#include <sstream>

#include "eval/cell/simulated_cell.h"
#include "eval/metrics/interval_json.h"
#include "eval/metrics/metric_table.h"
#include "eval/trial/counts_by_bin.h"
#include "scenes/base/error.h"

namespace pickbed::eval {
namespace {

using Scenes = std::vector<int>;

// With fewer scenes, the test of medians cannot reach p < 0.05 (2 / 2^n), and the interval cannot
// reach 95 %.
constexpr int kFewestScenes = 6;
static_assert(kFewestScenes >= kMinBinsOfInterval);

constexpr std::array kSceneSettings{"seed:", "bin:", "objects:", "arrangement:"};
// These change the scene only if they are not 0. Older results do not have them. Other cell errors
// change what is assumed, or the picking.
constexpr std::array kOptionalSceneSettings{"fill:", "  size_percent:"};
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

// Returns the group of a line, such as "objects" for "objects:" or "the meshes of the objects"
// for "# part rod is 0123"; empty inside a group.
std::string GroupOf(const std::string& line) {
  if (line.empty() || line[0] == ' ' || line[0] == '-') return "";
  if (line[0] == '#')
    return line.starts_with("# bin") ? "the mesh of the bin" : "the meshes of the objects";
  return line.substr(0, line.find(':'));
}

bool OnceEach(const std::vector<Cluster>& clusters) {
  return std::all_of(clusters.begin(), clusters.end(),
                     [](const Cluster& cluster) { return cluster.samples <= 1; });
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
    if (before[i].samples == 0 || after[i].samples == 0) continue;
    ++outcome.pairs;
    outcome.discordance.before_only += before[i].hits > after[i].hits;
    outcome.discordance.after_only += after[i].hits > before[i].hits;
  }
  return outcome;
}

void TestOneOutcome(const OneOutcome& outcome, PairedStatistic& statistic) {
  statistic.test = "mcnemar";
  statistic.p_value = McNemarExact(outcome.discordance);
  statistic.odds_ratio = MatchedOddsRatio(outcome.discordance);
  if (statistic.odds_ratio && outcome.pairs < kMinBinsOfInterval) {
    statistic.odds_ratio->interval = Interval::Unknown();
  }
  const double discordant = static_cast<double>(statistic.discordant_scenes) / outcome.pairs;
  statistic.scenes_needed = ScenesNeededForMcNemar(statistic.difference(), discordant);
}

PairedStatistic PairedMedian(const std::string& key, const std::string& name,
                             const ValueClusters& before, const ValueClusters& after) {
  PairedStatistic statistic{key, name, false, MedianOf(before), MedianOf(after)};
  for (size_t i = 0; i < before.size(); ++i) {
    statistic.scenes += !before[i].empty() || !after[i].empty();
    statistic.discordant_scenes += before[i] != after[i];
  }
  statistic.difference_ci95 =
      statistic.scenes < kFewestScenes ? Interval::Unknown() : PairedMedianInterval(before, after);
  statistic.p_value = PairedMedianTest(before, after);
  statistic.test = "sign_flip";
  return statistic;
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

// In occlusion trials only targets count for the recall.
std::vector<NamedRate> Rates(const std::vector<VisibleBand>& bands, bool has_targets) {
  const char* recall = has_targets ? "target recall" : "recall";
  std::vector<NamedRate> rates{{"pick_success", "pick success", SuccessOfAttempts()},
                               {"attempts_picked", "attempts that picked", AttemptsThatPicked()},
                               {"cleared", "instances cleared", InstancesCleared()},
                               {"top1", "top-ranked pose right", TopRankedRight()}};
  rates.push_back({"recall", recall, InstancesRecalled(kCountedVisibility, 1)});
  if (has_targets) {
    rates.push_back({"recall_in_view", "recall, all instances in view", AllInstancesRecalled()});
  }
  rates.push_back({"precision", "precision", PosesRight()});
  const auto add_bands = [&](const char* key, const char* name, auto count) {
    for (const VisibleBand& band : bands) {
      std::string ends = band.name();
      std::replace(ends.begin(), ends.end(), '-', '_');
      rates.push_back({fmt::format("{}_{}", key, ends),
                       fmt::format("{}, {} % visible", name, band.name()),
                       count(band.min, band.max)});
    }
  };
  add_bands("recall", recall, InstancesRecalled);
  add_bands("target_picked", "target picked", TargetsPicked);
  return rates;
}

// Formats rates in percent, errors in their unit.
std::string Valued(const PairedStatistic& statistic, double value) {
  return statistic.is_rate ? PercentNumber(value) : fmt::format("{:.4f}", value);
}

nlohmann::ordered_json Number(double value) {
  return std::isfinite(value) ? nlohmann::ordered_json(value) : nlohmann::ordered_json();
}

}  // namespace

PairedStatistic PairedRate(const std::string& key, const std::string& name,
                           const std::vector<Cluster>& before, const std::vector<Cluster>& after) {
  PairedStatistic statistic{key, name, true, RateOf(before), RateOf(after)};
  for (size_t i = 0; i < before.size(); ++i) {
    statistic.scenes += before[i].samples > 0 || after[i].samples > 0;
    statistic.discordant_scenes +=
        before[i].hits * after[i].samples != after[i].hits * before[i].samples;
  }
  statistic.difference_ci95 = PairedInterval(before, after);
  const OneOutcome outcome = OutcomesOf(before, after);
  if (OnceEach(before) && OnceEach(after) && outcome.pairs == statistic.scenes) {
    TestOneOutcome(outcome, statistic);
    return statistic;
  }
  statistic.test = "sign_flip";
  statistic.p_value = PairedRateTest(before, after);
  statistic.scenes_needed = ScenesNeeded(statistic.difference(), DeviationOfRise(before, after));
  return statistic;
}

PairedComparison ComparePaired(std::span<const TrialResult> before,
                               std::span<const TrialResult> after,
                               const std::vector<VisibleBand>& bands) {
  const Scenes scenes_before = ScenesOf(before), scenes_after = ScenesOf(after);
  Scenes shared;
  std::set_intersection(scenes_before.begin(), scenes_before.end(), scenes_after.begin(),
                        scenes_after.end(), std::back_inserter(shared));
  CheckInput(!shared.empty(),
             "the runs share no scenes: none of their finished trials has the same scene");
  PairedComparison comparison;
  comparison.scenes = static_cast<int>(shared.size());
  comparison.before_only = static_cast<int>(scenes_before.size() - shared.size());
  comparison.after_only = static_cast<int>(scenes_after.size() - shared.size());
  for (const NamedRate& rate : Rates(bands, HasTargets(before))) {
    const auto a = CountByScene(before, shared, rate.count);
    const auto b = CountByScene(after, shared, rate.count);
    if (SumOf(a).samples == 0 || SumOf(b).samples == 0) continue;
    comparison.statistics.push_back(PairedRate(rate.key, rate.name, a, b));
  }
  for (const MetricRow& row : MetricsIn(kCompared)) {
    const PairedErrors errors = PairedErrorsByScene(before, after, shared, ShownErrorOf(row));
    if (std::isnan(MedianOf(errors.before))) continue;
    comparison.statistics.push_back(PairedMedian(
        "median_" + ShownKey(row), "median " + ShownName(row), errors.before, errors.after));
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
    const bool is_set = BeginsWithAny(line, kOptionalSceneSettings) && !line.ends_with(": 0");
    if (wanted || is_set || BeginsWithAny(line, kSceneHashes)) key += line + "\n";
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

std::string DifferenceText(const PairedStatistic& statistic) {
  const Interval& ci95 = statistic.difference_ci95;
  if (statistic.is_rate) return PointsText(statistic.difference(), ci95);
  const auto text = [](double value) {
    return std::isfinite(value) ? fmt::format("{:+.3g}", value) : "-";
  };
  if (!ci95.is_known()) return fmt::format("{} ({})", text(statistic.difference()), kTooFewBins);
  return fmt::format("{} [{}, {}]", text(statistic.difference()), text(ci95.low), text(ci95.high));
}

std::string PairedTable(const PairedComparison& comparison, bool all_rows,
                        const std::string& remedy) {
  std::vector<std::vector<std::string>> rows{{"", "A", "B", "B - A", "p", "differ in", "needed"}};
  int folded = 0;
  for (const PairedStatistic& statistic : comparison.statistics) {
    if (statistic.discordant_scenes == 0 && !all_rows) {
      ++folded;
      continue;
    }
    rows.push_back({statistic.name + (statistic.is_rate ? ", %" : ""),
                    Valued(statistic, statistic.before), Valued(statistic, statistic.after),
                    DifferenceText(statistic), fmt::format("{:.4f}", statistic.p_value),
                    fmt::format("{}/{}", statistic.discordant_scenes, statistic.scenes),
                    statistic.scenes_needed ? std::to_string(*statistic.scenes_needed) : "-"});
  }
  std::vector<size_t> widths(rows[0].size(), 0);
  for (const auto& row : rows) {
    for (size_t i = 0; i < row.size(); ++i) widths[i] = std::max(widths[i], row[i].size());
  }
  std::string text = fmt::format(
      "{} scenes that both have\nDifferences with 95 % intervals over scenes; needed: number of "
      "scenes to detect such a\ndifference of rates with a power of 0.8\n",
      comparison.scenes);
  constexpr size_t kDifference = 3;  // this column and the names are aligned to the left
  for (const auto& row : rows) {
    std::string line;
    for (size_t i = 0; i < row.size(); ++i) {
      line += i == 0 || i == kDifference ? fmt::format("  {:<{}}", row[i], widths[i])
                                         : fmt::format("  {:>{}}", row[i], widths[i]);
    }
    text += line + "\n";
  }
  if (folded > 0) {
    text += fmt::format("  {} more rows without a difference in any scene{}{}\n", folded,
                        remedy.empty() ? "" : "; ", remedy);
  }
  return text;
}

std::string PairedJson(const PairedComparison& comparison) {
  nlohmann::ordered_json json;
  json["scenes"] = comparison.scenes;
  json["scenes_of_first_only"] = comparison.before_only;
  json["scenes_of_second_only"] = comparison.after_only;
  json["statistics"] = nlohmann::ordered_json::array();
  for (const PairedStatistic& statistic : comparison.statistics) {
    auto& row = json["statistics"].emplace_back();
    row["key"] = statistic.key;
    row["name"] = statistic.name;
    row["before"] = Number(statistic.before);
    row["after"] = Number(statistic.after);
    row["difference"] = Number(statistic.difference());
    AddInterval(row, "difference_ci95", statistic.difference_ci95);
    row["p_value"] = statistic.p_value;
    row["test"] = statistic.test;
    row["scenes"] = statistic.scenes;
    row["discordant_scenes"] = statistic.discordant_scenes;
    auto& needed = row["scenes_needed"];
    if (statistic.scenes_needed) needed = *statistic.scenes_needed;
    if (!statistic.odds_ratio) continue;
    row["odds_ratio"] = Number(statistic.odds_ratio->ratio);
    AddInterval(row, "odds_ratio_ci95", statistic.odds_ratio->interval);
  }
  return json.dump(2) + "\n";
}

}  // namespace pickbed::eval
