#include "eval/summary/run_summary.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <numeric>
#include <utility>

#include "eval/cell/simulated_cell.h"
#include "eval/metrics/interval_json.h"
#include "eval/trial/counts_by_bin.h"
#include "scenes/base/finite_counts.h"
#include "scenes/base/ids_format.h"

namespace pickbed::eval {
namespace {

double Ratio(int count, int whole) { return whole > 0 ? static_cast<double>(count) / whole : 0; }

void CountAttempt(const AttemptRecord& attempt, RunSummary& summary) {
  const std::vector<InstanceRecord> none;
  const bool is_image = attempt.has_own_image();
  summary.images += is_image;
  for (const InstanceRecord& instance : is_image ? attempt.instances : none) {
    ++summary.in_view[InViewIndex(instance.visible_fraction)];
    // In an occlusion trial only the target is counted.
    if (attempt.target >= 0 && instance.instance != attempt.target) continue;
    if (!attempt.pose_free) CountRecall(instance, summary.recall_by_visibility);
  }
  if (is_image && !attempt.hypotheses.empty()) {
    ++summary.frames;
    summary.top1_correct += attempt.hypotheses.front().correct;
  }
  summary.executed_grasps += UsedHand(attempt);
  if (attempt.grasp) {
    ToolCount& tool = summary.tools[attempt.grasp->tool];
    ++tool.executed_grasps;
    tool.successes += attempt.failure == FailureReason::kNone;
  }
  summary.successes += attempt.grasp && attempt.failure == FailureReason::kNone;
  // An attempt without an executed grasp counts as a failure.
  if (attempt.failure != FailureReason::kNone)
    ++summary.failures[std::string(FailureName(attempt.failure))];
}

void AddIntervals(const std::vector<TrialResult>& trials, RunSummary& summary) {
  const std::vector<int> scenes = ScenesOf(trials);
  const auto of = [&](const TrialCount& count) {
    return ClusterInterval(CountByScene(trials, scenes, count));
  };
  const auto rate = [&](const TrialCount& count) {
    return ClusterRate(CountByScene(trials, scenes, count));
  };
  summary.attempts_picked = rate(AttemptsThatPicked());
  summary.requested_picked = rate(RequestedCleared());
  summary.recall = rate(AllInstancesRecalled());
  summary.precision = rate(PosesRight());
  if (HasTargets(trials)) summary.target_recall = rate(InstancesRecalled(kCountedVisibility, 1));
  summary.success_ci95 = of(SuccessOfAttempts());
  summary.cleared_ci95 = of(InstancesCleared());
  summary.top1_ci95 = of(TopRankedRight());
  for (const RecallBand& band : summary.recall_by_visibility) {
    summary.recall_ci95.push_back(of(InstancesRecalled(band.visible_min, band.visible_max)));
  }
}

std::string BandName(const RecallBand& band) {
  return VisibleBand{band.visible_min, band.visible_max}.name();
}

std::string HiddenText(double hidden_s) {
  return hidden_s > 0 ? fmt::format(", {:.1f} s hidden behind motion", hidden_s) : "";
}

std::string CycleText(const CycleTime& cycle) {
  if (!cycle.measured) {
    return fmt::format("{:.0f}  per instance: sense {:.1f} s, compute {:.1f} s, move {:.1f} s{}",
                       cycle.stated_picks_per_hour(), cycle.sense_s, cycle.compute_s, cycle.move_s,
                       HiddenText(cycle.hidden_s));
  }
  return fmt::format(
      "{:.0f}  per instance: sense {:.1f} s, move {:.1f} s{}; {:.0f} with the {:.1f} s to compute "
      "measured here{}",
      cycle.stated_picks_per_hour(), cycle.sense_s, cycle.move_s, HiddenText(cycle.stated_hidden_s),
      cycle.picks_per_hour(), cycle.compute_s, HiddenText(cycle.hidden_s));
}

constexpr double kEasyShare = 0.75;  // of the instances that are over 90 % visible

int StirsOf(const RunSummary& s) {
  const auto found = s.failures.find(std::string(FailureName(FailureReason::kStirred)));
  return found == s.failures.end() ? 0 : found->second;
}

// "45 executed grasps", or "45 executed grasps and stirs (3 stirs)".
std::string ExecutedText(const RunSummary& s) {
  const int stirs = StirsOf(s);
  if (stirs == 0) return fmt::format("{} executed grasps", s.executed_grasps);
  return fmt::format("{} executed grasps and stirs ({} stir{})", s.executed_grasps, stirs,
                     stirs == 1 ? "" : "s");
}

// "22 of 50 attempts (28 without a grasp, of them 3 stirs)".
std::string AttemptsText(const RunSummary& s) {
  const int stirs = StirsOf(s);
  const int without = s.attempts_picked.samples - s.executed_grasps + stirs;
  std::string text =
      fmt::format("{} of {} attempts", s.attempts_picked.hits, s.attempts_picked.samples);
  if (without == 0) return text;
  text += fmt::format(" ({} without a grasp", without);
  if (stirs > 0) text += fmt::format(", of them {} stir{}", stirs, stirs == 1 ? "" : "s");
  return text + ")";
}

// "40 of 45 in 3 bins", or "12 of 12 requested, of 240 dropped in 3 bins".
std::string ClearedText(const RunSummary& s) {
  const std::string bins = fmt::format("{} bin{}", s.trials, s.trials == 1 ? "" : "s");
  if (s.requested_picked.samples == s.instances_dropped) {
    return fmt::format("{} of {} in {}", s.instances_cleared, s.instances_dropped, bins);
  }
  return fmt::format("{} of {} requested, of {} dropped in {}", s.instances_cleared,
                     s.requested_picked.samples, s.instances_dropped, bins);
}

std::string RefusedText(const RunSummary& summary) {
  std::string text =
      fmt::format("Scenes rejected and dropped again: {} of {}\n", summary.refused.size(),
                  summary.trials + static_cast<int>(summary.refused.size()));
  for (const auto& [trial, refused] : summary.refused) {
    text += fmt::format("  trial {}, attempt {}: {}\n", trial, refused.attempt,
                        fmt::join(refused.faults, ", "));
  }
  return text;
}

nlohmann::ordered_json JsonOf(const BandStatistics& band) {
  nlohmann::ordered_json json;
  json["visible_min"] = band.band.min;
  json["visible_max"] = band.band.max;
  json["attempts"] = band.attempts;
  json["trials_without"] = band.trials_without;
  json["failures"] = band.failures;
  if (band.attempts == 0) return json;
  const auto share = [&](const ShareOfAttempts& of) {
    nlohmann::ordered_json rate{{"hits", of.hits}, {"rate", Ratio(of.hits, band.attempts)}};
    AddInterval(rate, "ci95", of.ci95);
    return rate;
  };
  json["mean_visible"] = band.mean_visible;
  json["recall"] = share(band.recalled);
  json["picks"] = share(band.picked);
  json["posed"] = band.errors.attempts;
  if (band.errors.attempts == 0) return json;
  const auto median = [&](const std::string& key, const ErrorMedian& of) {
    json[key] = of.value;
    AddInterval(json, key + "_ci95", of.ci95);
  };
  median("median_mssd_diameters", band.errors.mssd_diameters);
  median("median_translation_m", band.errors.translation_m);
  median("median_rotation_rad", band.errors.rotation_rad);
  return json;
}

// The rate is null without samples.
nlohmann::ordered_json RateObject(const char* samples, const char* hits, const ReportRate& of) {
  nlohmann::ordered_json json{{samples, of.samples}, {hits, of.hits}, {"rate", nullptr}};
  if (of.samples > 0) json["rate"] = of.rate();
  AddInterval(json, "ci95", of.ci95);
  return json;
}

const SuccessRuleRow& RowOf(SuccessRule rule) { return SuccessRuleTable()[static_cast<int>(rule)]; }

std::string RulesText(const RunSummary& summary, bool few_bins) {
  std::string text = fmt::format("Success of {} by rule\n", ExecutedText(summary));
  for (const RuleRate& rule : summary.by_rule) {
    const SuccessRuleRow& row = RowOf(rule.rule);
    const ReportRate rate{rule.successes, summary.executed_grasps, rule.ci95};
    text += fmt::format("  {:<26}{:<24}{}\n", row.name,
                        few_bins ? ShortRateText(rate) : RateText(rate), row.help);
  }
  return text;
}

std::string Indented(const std::string& lines) {
  std::string text;
  for (const char c : lines) {
    if (text.empty() || text.back() == '\n') text += "  ";
    text += c;
  }
  return text;
}

// One indented line per sentence.
std::string OnLines(std::string sentences) {
  if (sentences.empty()) return "";
  for (size_t at = 0; (at = sentences.find(". ", at)) != std::string::npos;) {
    sentences.replace(at, 2, ".\n  ");
  }
  return "  " + sentences + "\n";
}

// Lines on the reported poses.
std::string PosesText(const RunSummary& s, bool few_bins) {
  std::string text = "Poses (right: MSSD < 0.1 diameter)\n";
  const auto rate = [&](const std::string& name, const ReportRate& of, const std::string& counts) {
    text +=
        fmt::format("  {:<25} {}  {}\n", name, few_bins ? ShortRateText(of) : RateText(of), counts);
  };
  rate("top-ranked pose right", {s.top1_correct, s.frames, s.top1_ci95},
       fmt::format("{} of {} images", s.top1_correct, s.frames));
  const bool has_targets = s.target_recall.samples > 0;
  if (has_targets) {
    rate("target recall", s.target_recall,
         fmt::format("{} of {} targets", s.target_recall.hits, s.target_recall.samples));
  }
  rate(has_targets ? "recall, all in view" : "recall", s.recall,
       fmt::format("{} of {} instances", s.recall.hits, s.recall.samples));
  rate("precision", s.precision,
       fmt::format("{} of {} poses, {} false", s.precision.hits, s.precision.samples,
                   s.precision.samples - s.precision.hits));
  return text;
}

}  // namespace

std::vector<VisibleBand> ReportedBands(const OcclusionSpec& spec) {
  return spec.enabled ? spec.bands : OcclusionSpec().bands;
}

std::vector<RecallBand> EmptyRecallBands(const std::vector<VisibleBand>& bands) {
  std::vector<RecallBand> empty;
  for (const VisibleBand& band : bands) empty.push_back({band.min, band.max, 0, 0});
  return empty;
}

void CountRecall(const InstanceRecord& instance, std::vector<RecallBand>& bands) {
  const double v = instance.visible_fraction;
  for (RecallBand& band : bands) {
    const bool last = band.visible_max >= 1;
    if (v < band.visible_min || (!last && v >= band.visible_max)) continue;
    ++band.instances;
    band.recalled += instance.recalled;
    return;
  }
}

std::vector<std::string> InViewNames() {
  const std::vector<VisibleBand> bands = ReportedBands();
  std::vector<std::string> names{VisibleBand{0, bands.front().min}.name()};
  for (const VisibleBand& band : bands) names.push_back(band.name());
  return names;
}

size_t InViewIndex(double visible_fraction) {
  size_t index = 0;
  for (const VisibleBand& band : ReportedBands()) index += visible_fraction >= band.min;
  return index;
}

RunSummary Summarize(const std::vector<TrialResult>& trials, const CycleSpec& cycle,
                     const std::vector<VisibleBand>& bands) {
  RunSummary summary;
  summary.in_view.resize(InViewNames().size());
  summary.cycle = CycleTimeOf(trials, cycle);
  summary.recall_by_visibility = EmptyRecallBands(bands);
  for (const TrialResult& trial : trials) {
    ++summary.trials;
    summary.instances_dropped += trial.instances_dropped;
    summary.instances_cleared += trial.instances_cleared;
    for (const AttemptRecord& attempt : trial.attempts) CountAttempt(attempt, summary);
    for (const RefusedScene& refused : trial.refused) {
      summary.refused.push_back({trial.trial, refused});
    }
    for (const auto& [stage, seconds] : trial.seconds) {
      if (!IsNotFiniteCount(stage)) summary.seconds[stage] += seconds;
    }
  }
  for (auto& [stage, seconds] : summary.seconds) seconds /= summary.trials;
  summary.success_rate = Ratio(summary.successes, summary.executed_grasps);
  AddIntervals(trials, summary);
  summary.by_rule = RatesByRule(trials);
  summary.by_fill = SuccessByFillLevel(trials);
  summary.by_layer = SuccessByLayers(trials);
  summary.retention = RetentionOf(trials);
  summary.drop_times = DropTimesOf(trials);
  summary.clutter = ClutterOfTrials(trials);
  summary.cleared_rate = Ratio(summary.instances_cleared, summary.instances_dropped);
  summary.top1_precision = Ratio(summary.top1_correct, summary.frames);
  return summary;
}

std::string SummaryJson(const RunSummary& s) {
  nlohmann::ordered_json json;
  json["trials"] = s.trials;
  json["executed_grasps"] = s.executed_grasps;
  json["successes"] = s.successes;
  json["success_rate"] = s.success_rate;
  AddInterval(json, "success_ci95", s.success_ci95);
  json["success_by_rule"] = nlohmann::ordered_json::object();
  for (const RuleRate& rule : s.by_rule) {
    auto& entry = json["success_by_rule"][RowOf(rule.rule).name];
    entry = {{"successes", rule.successes}, {"rate", rule.rate()}};
    AddInterval(entry, "ci95", rule.ci95);
  }
  if (s.stop) {
    json["stop"] = {{"width", s.stop->width},
                    {"reached", s.stop->reached},
                    {"bins", s.stop->bins},
                    {"mean", s.stop->mean},
                    {"interval", {s.stop->interval.low, s.stop->interval.high}}};
  }
  json["instances_dropped"] = s.instances_dropped;
  json["instances_cleared"] = s.instances_cleared;
  json["cleared_rate"] = s.cleared_rate;
  AddInterval(json, "cleared_ci95", s.cleared_ci95);
  json["attempts"] = RateObject("all", "picked", s.attempts_picked);
  json["requested"] = RateObject("instances", "picked", s.requested_picked);
  json["recall"] = RateObject("instances", "recalled", s.recall);
  json["precision"] = RateObject("poses", "right", s.precision);
  json["false_positives"] = s.precision.samples - s.precision.hits;
  if (s.target_recall.samples > 0) {
    json["target_recall"] = RateObject("targets", "recalled", s.target_recall);
  }
  if (s.tools.size() > 1) {
    for (const auto& [name, tool] : s.tools) {
      json["tools"][name] = {{"executed_grasps", tool.executed_grasps},
                             {"successes", tool.successes},
                             {"rate", Ratio(tool.successes, tool.executed_grasps)}};
    }
    json["tool_changes"] = s.cycle.tool_changes;
  }
  auto& in_view = json["in_view"] = nlohmann::ordered_json::object();
  const std::vector<std::string> names = InViewNames();
  for (size_t i = 0; i < names.size(); ++i) in_view[names[i]] = s.in_view[i];
  if (s.clutter.bins > 0)
    json["clutter"] = nlohmann::ordered_json::parse(ClutterJson(s.clutter, ""));
  json["images"] = s.images;
  json["frames"] = s.frames;
  json["top1_precision"] = s.top1_precision;
  AddInterval(json, "top1_ci95", s.top1_ci95);
  auto& recall = json["recall_by_visibility"] = nlohmann::ordered_json::object();
  for (size_t i = 0; i < s.recall_by_visibility.size(); ++i) {
    const RecallBand& band = s.recall_by_visibility[i];
    recall[BandName(band)] = {{"instances", band.instances}, {"recalled", band.recalled}};
    auto& rate = recall[BandName(band)]["recall"];  // null without instances
    if (band.instances > 0) rate = Ratio(band.recalled, band.instances);
    AddInterval(recall[BandName(band)], "ci95", s.recall_ci95[i]);
  }
  auto& by_fill = json["success_by_fill"] = nlohmann::ordered_json::object();
  for (const FillBand& band : s.by_fill) {
    by_fill[band.name()] = RateObject("executed_grasps", "successes", band.success);
  }
  auto& by_layer = json["success_by_layer"] = nlohmann::ordered_json::object();
  for (const LayerRate& layer : s.by_layer) {
    by_layer["layer_" + layer.name()] = RateObject("executed_grasps", "successes", layer.success);
  }
  for (const BandStatistics& band : s.bands) json["target_by_visibility"].push_back(JsonOf(band));
  json["scenes_refused"] = nlohmann::ordered_json::array();
  for (const auto& [trial, refused] : s.refused) {
    json["scenes_refused"].push_back(
        {{"trial", trial}, {"attempt", refused.attempt}, {"faults", refused.faults}});
  }
  json["trials_crashed"] = nlohmann::ordered_json::array();
  for (const CrashedTrial& trial : s.crashed) {
    json["trials_crashed"].push_back({{"trial", trial.trial},
                                      {"bin_index", int{trial.bin_index}},
                                      {"seed", trial.seed},
                                      {"why", trial.why}});
  }
  json["failures"] = nlohmann::ordered_json::object();
  for (const auto& [reason, count] : s.failures) json["failures"][reason] = count;
  if (!s.forecasts.empty()) {
    json["pick_forecasts"] = nlohmann::ordered_json::parse(ForecastJson(s.forecasts));
  }
  if (s.retention.picks > 0) {
    json["retention"] = {{"picks", s.retention.picks},
                         {"min_g", s.retention.min_g},
                         {"median_g", s.retention.median_g}};
  }
  if (s.drop_times.drops > 0) {
    json["drop_time"] = {{"drops", s.drop_times.drops}, {"median_s", s.drop_times.median_s}};
  }
  // Both are null if nothing was picked. A new member can move the ones before it.
  json["picks_per_hour"] = nullptr;
  if (s.cycle.stated_pick_s() > 0) json["picks_per_hour"] = s.cycle.stated_picks_per_hour();
  auto& cycle = json["cycle"];
  if (s.cycle.stated_pick_s() > 0) {
    cycle = {{"sense_s", s.cycle.sense_s},
             {"compute_s", nullptr},
             {"move_s", s.cycle.move_s},
             {"hidden_s", s.cycle.stated_hidden_s}};
    if (!s.cycle.measured) cycle["compute_s"] = s.cycle.compute_s;
  }
  return json.dump(2) + "\n";
}

std::string InViewText(const RunSummary& s) {
  const int all = std::accumulate(s.in_view.begin(), s.in_view.end(), 0);
  const int counted = all - s.in_view.front();
  if (all == 0) return "";
  std::string text = fmt::format(
      "{} of {} instances in view were under {} visible and are not counted; an instance counts "
      "once per image.",
      s.in_view.front(), all, WholePercentText(kCountedVisibility));
  if (counted == 0) return text;
  const int clear = s.in_view.back(), hidden = s.in_view[1] + s.in_view[2];
  text += fmt::format(" {} of the {} counted were over 90 % visible", clear, counted);
  if (clear >= kEasyShare * counted) return text + ": an easy bin.";
  return text + fmt::format(", and {} under 50 %.", hidden);
}

std::string SummaryTable(const RunSummary& s) {
  std::string text;
  const auto line = [&text](const std::string& name, const std::string& value) {
    text += fmt::format("  {:<25} {}\n", name, value);
  };
  const bool few_bins = s.trials < kMinBinsOfInterval;  // said once, below the table
  const auto rate = [&](const std::string& name, const ReportRate& of, const std::string& counts) {
    line(name, fmt::format("{}  {}", few_bins ? ShortRateText(of) : RateText(of), counts));
  };
  const bool has_targets = s.target_recall.samples > 0;
  if (s.has_poses()) {
    text += has_targets ? "Target recall by visible fraction\n" : "Recall by visible fraction\n";
  }
  for (size_t i = 0; i < s.recall_by_visibility.size(); ++i) {
    const RecallBand& band = s.recall_by_visibility[i];
    if (band.instances == 0) continue;
    rate(BandName(band) + " %", {band.recalled, band.instances, s.recall_ci95[i]},
         fmt::format("{} of {}", band.recalled, band.instances));
  }
  if (!s.bands.empty()) text += CurveTable(s.bands, few_bins);
  text += "Failed picks by reason\n";
  if (s.failures.empty()) text += "  no pick failed\n";
  for (const auto& [reason, count] : s.failures) {
    line(reason, fmt::format("{:<6}{}", count, StageName(StageOf(*FailureFromName(reason)))));
  }
  const std::string hard = std::exchange(text, "");
  text += "Picks\n";
  if (has_targets) rate("targets picked", s.attempts_picked, AttemptsText(s));
  rate("success rate", {s.successes, s.executed_grasps, s.success_ci95},
       fmt::format("{} of {}", s.successes, ExecutedText(s)));
  if (s.tools.size() > 1) {
    for (const auto& [name, tool] : s.tools) {
      line("  with " + name, fmt::format("{}  {} of {} executed grasps",
                                         PercentText(Ratio(tool.successes, tool.executed_grasps)),
                                         tool.successes, tool.executed_grasps));
    }
    line("  tool changes", fmt::format("{}", s.cycle.tool_changes));
  }
  if (s.stop) line("early stop", StopText(*s.stop));
  if (!has_targets) {
    if (s.attempts_picked.samples > s.executed_grasps) {
      rate("attempts that picked", s.attempts_picked, AttemptsText(s));
    }
    rate("instances cleared", s.requested_picked, ClearedText(s));
  }
  if (s.retention.picks > 0) {
    line("retention", fmt::format("median {:.1f} g, minimum {:.1f} g in {} hold tests",
                                  s.retention.median_g, s.retention.min_g, s.retention.picks));
  }
  if (s.drop_times.drops > 0) {
    line("dropped from the hand", fmt::format("{}, {:.2f} s after the lift (median)",
                                              s.drop_times.drops, s.drop_times.median_s));
  }
  if (s.cycle.picks_per_hour() > 0) line("picks per hour", CycleText(s.cycle));
  if (!s.refused.empty()) text += RefusedText(s);
  for (const CrashedTrial& trial : s.crashed) {
    line("crashed", fmt::format("trial {} (seed {}, scene {}): {}", trial.trial, trial.seed,
                                trial.bin_index, trial.why));
  }
  if (s.executed_grasps > 0) text += RulesText(s, few_bins);
  if (s.has_poses()) text += PosesText(s, few_bins);
  text += OnLines(InViewText(s));
  if (s.clutter.layers.size() > 1) {
    text += "Before the first pick\n" + Indented(ClutterText(s.clutter, ""));
  }
  // What is hard comes first. In occlusion trials this is whether the targets were picked.
  text = has_targets ? text + hard : hard + text;
  text += ForecastText(s.forecasts);
  text += "Seconds per bin\n";
  for (const auto& [stage, seconds] : s.seconds) line(stage, fmt::format("{:.2f}", seconds));
  if (const std::string few = FewBinsText(s.trials); !few.empty()) text += few + "\n";
  return text;
}

}  // namespace pickbed::eval
