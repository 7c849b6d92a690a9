#include "eval/summary/run_summary.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <array>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "eval/metrics/metric_columns.h"
#include "eval/summary/run_columns.h"
#include "eval/trial/counts_by_bin.h"
#include "scenes/base/ids_format.h"
#include "scenes/base/math.h"

namespace pickbed::eval {
namespace {

double Ratio(int count, int whole) { return whole > 0 ? static_cast<double>(count) / whole : 0; }

void CountAttempt(const AttemptRecord& attempt, RunSummary& summary) {
  for (const InstanceRecord& instance : attempt.instances) {
    // In an occlusion trial only the target is counted.
    if (attempt.target >= 0 && instance.instance != attempt.target) continue;
    CountRecall(instance, summary.recall_by_visibility);
  }
  if (!attempt.hypotheses.empty()) {
    ++summary.frames;
    summary.top1_correct += attempt.hypotheses.front().correct;
  }
  summary.executed_grasps += attempt.grasp.has_value();
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

std::string CycleText(const CycleTime& cycle) {
  return fmt::format("{:.0f}  per instance: sense {:.1f} s, compute {:.1f} s{}, move {:.1f} s",
                     cycle.picks_per_hour(), cycle.sense_s, cycle.compute_s,
                     cycle.measured ? " (measured)" : "", cycle.move_s);
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

std::array<double, 2> EndsOf(const Interval& interval) { return {interval.low, interval.high}; }

// JSON has no infinity: unknown ends become null.
nlohmann::ordered_json FiniteOrNull(double value) {
  return std::isfinite(value) ? nlohmann::ordered_json(value) : nlohmann::ordered_json();
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
    return nlohmann::ordered_json{
        {"hits", of.hits}, {"rate", Ratio(of.hits, band.attempts)}, {"ci95", EndsOf(of.ci95)}};
  };
  json["mean_visible"] = band.mean_visible;
  json["recall"] = share(band.recalled);
  json["picks"] = share(band.picked);
  json["posed"] = band.errors.attempts;
  if (band.errors.attempts == 0) return json;
  const auto median = [&](const std::string& key, const ErrorMedian& of) {
    json[key] = of.value;
    json[key + "_ci95"] = {FiniteOrNull(of.ci95.low), FiniteOrNull(of.ci95.high)};
  };
  median("median_mssd_diameters", band.errors.mssd_diameters);
  median("median_translation_m", band.errors.translation_m);
  median("median_rotation_rad", band.errors.rotation_rad);
  return json;
}

const SuccessRuleRow& RowOf(SuccessRule rule) { return SuccessRuleTable()[static_cast<int>(rule)]; }

std::string RulesText(const RunSummary& summary) {
  std::string text =
      fmt::format("Success of {} executed grasps by rule\n", summary.executed_grasps);
  for (const RuleRate& rule : summary.by_rule) {
    const SuccessRuleRow& row = RowOf(rule.rule);
    text += fmt::format("  {:<26}{:<24}{}\n", row.name, RateText(rule.rate(), rule.ci95), row.help);
  }
  return text;
}

// Empty if the object has no tolerance model.
std::string ChanceCell(const std::optional<double>& chance) {
  return chance ? fmt::format("{:.4f}", *chance) : "";
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

RunSummary Summarize(const std::vector<TrialResult>& trials, const CycleSpec& cycle,
                     const std::vector<VisibleBand>& bands) {
  RunSummary summary;
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
    for (const auto& [stage, seconds] : trial.seconds) summary.seconds[stage] += seconds;
  }
  for (auto& [stage, seconds] : summary.seconds) seconds /= summary.trials;
  summary.success_rate = Ratio(summary.successes, summary.executed_grasps);
  AddIntervals(trials, summary);
  summary.by_rule = RatesByRule(trials);
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
  json["success_ci95"] = EndsOf(s.success_ci95);
  json["success_by_rule"] = nlohmann::ordered_json::object();
  for (const RuleRate& rule : s.by_rule) {
    json["success_by_rule"][RowOf(rule.rule).name] = {
        {"successes", rule.successes}, {"rate", rule.rate()}, {"ci95", EndsOf(rule.ci95)}};
  }
  if (s.stop) {
    json["stop"] = {{"width", s.stop->width},
                    {"reached", s.stop->reached},
                    {"bins", s.stop->bins},
                    {"mean", s.stop->mean},
                    {"interval", EndsOf(s.stop->interval)}};
  }
  json["instances_dropped"] = s.instances_dropped;
  json["instances_cleared"] = s.instances_cleared;
  json["cleared_rate"] = s.cleared_rate;
  json["cleared_ci95"] = EndsOf(s.cleared_ci95);
  json["frames"] = s.frames;
  json["top1_precision"] = s.top1_precision;
  json["top1_ci95"] = EndsOf(s.top1_ci95);
  auto& recall = json["recall_by_visibility"] = nlohmann::ordered_json::object();
  for (size_t i = 0; i < s.recall_by_visibility.size(); ++i) {
    const RecallBand& band = s.recall_by_visibility[i];
    recall[BandName(band)] = {{"instances", band.instances}, {"recalled", band.recalled}};
    auto& rate = recall[BandName(band)]["recall"];  // null without instances
    if (band.instances > 0) rate = Ratio(band.recalled, band.instances);
    recall[BandName(band)]["ci95"] = EndsOf(s.recall_ci95[i]);
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
  auto& picks_per_hour = json["picks_per_hour"];
  if (!s.cycle.measured && s.successes > 0) picks_per_hour = s.cycle.picks_per_hour();
  return json.dump(2) + "\n";
}

std::string SummaryTable(const RunSummary& s) {
  std::string text;
  const auto line = [&text](const std::string& name, const std::string& value) {
    text += fmt::format("  {:<26}{}\n", name, value);
  };
  text += "Picks\n";
  line("success rate",
       fmt::format("{}  {} of {} executed grasps", RateText(s.success_rate, s.success_ci95),
                   s.successes, s.executed_grasps));
  if (s.stop) line("early stop", StopText(*s.stop));
  line("instances cleared",
       fmt::format("{}  {} of {} in {} bins", RateText(s.cleared_rate, s.cleared_ci95),
                   s.instances_cleared, s.instances_dropped, s.trials));
  line("top-ranked pose right",
       fmt::format("{}  {} of {} images", RateText(s.top1_precision, s.top1_ci95), s.top1_correct,
                   s.frames));
  if (s.cycle.picks_per_hour() > 0) line("picks per hour", CycleText(s.cycle));
  if (!s.refused.empty()) text += RefusedText(s);
  for (const CrashedTrial& trial : s.crashed) {
    line("crashed", fmt::format("trial {} (seed {}, scene {}): {}", trial.trial, trial.seed,
                                trial.bin_index, trial.why));
  }
  if (s.executed_grasps > 0) text += RulesText(s);
  text += "Recall by visible fraction (MSSD < 0.1 diameter)\n";
  for (size_t i = 0; i < s.recall_by_visibility.size(); ++i) {
    const RecallBand& band = s.recall_by_visibility[i];
    if (band.instances == 0) continue;
    const std::string recall = RateText(Ratio(band.recalled, band.instances), s.recall_ci95[i]);
    line(BandName(band) + " %", fmt::format("{}  {} of {}", recall, band.recalled, band.instances));
  }
  if (!s.bands.empty()) text += CurveTable(s.bands);
  text += "Failed picks by reason\n";
  if (s.failures.empty()) line("none", "0");
  for (const auto& [reason, count] : s.failures) {
    line(reason, fmt::format("{:<6}{}", count, StageName(StageOf(*FailureFromName(reason)))));
  }
  text += ForecastText(s.forecasts);
  text += "Seconds per bin\n";
  for (const auto& [stage, seconds] : s.seconds) line(stage, fmt::format("{:.2f}", seconds));
  return text;
}

std::string TrialsCsv(const std::vector<TrialResult>& trials,
                      const std::vector<CrashedTrial>& crashed) {
  std::string csv = HeaderLine(TrialsColumns());
  auto next_crashed = crashed.begin();
  const auto add_crashed_before = [&](int trial) {
    for (; next_crashed != crashed.end() && next_crashed->trial < trial; ++next_crashed) {
      csv += fmt::format("{},{},{},crashed,,,,,,,,,\n", next_crashed->trial,
                         next_crashed->configuration, next_crashed->bin_index);
    }
  };
  for (const TrialResult& t : trials) {
    int executed_grasps = 0, successes = 0;
    for (const AttemptRecord& attempt : t.attempts) {
      executed_grasps += attempt.grasp.has_value();
      successes += attempt.grasp && attempt.failure == FailureReason::kNone;
    }
    add_crashed_before(t.trial);
    csv += fmt::format("{},{},{},finished,{},{},{},{},{},{},{},{},{}\n", t.trial, t.configuration,
                       t.bin_index, t.instances_dropped, t.instances_cleared, executed_grasps,
                       successes, FailureName(t.ended_by), t.certificate.simulated_s,
                       1e3 * t.certificate.wake_movement_m,
                       1e3 * t.certificate.deepest_penetration_m, t.refused.size());
  }
  add_crashed_before(std::numeric_limits<int>::max());
  return csv;
}

std::string AttemptsCsv(const std::vector<TrialResult>& trials,
                        const std::vector<std::string>& object_names, const ToleranceMaps& maps) {
  const MetricColumns placed = MetricColumns::Placed(MetricUnits::kShown);
  const MetricColumns at_end = MetricColumns::AtEnd(MetricUnits::kShown);
  std::string csv = HeaderLine(AttemptsColumns());
  for (const TrialResult& trial : trials) {
    for (const AttemptRecord& attempt : trial.attempts) {
      csv += fmt::format("{},{},{},{},{},{},{},", trial.trial, trial.configuration, attempt.attempt,
                         attempt.target, attempt.band, attempt.instances.size(),
                         attempt.hypotheses.size());
      std::string cells_at_end = at_end.EmptyCells();
      if (attempt.chosen >= 0) {
        const HypothesisRecord& h = attempt.hypotheses.at(attempt.chosen);
        csv += fmt::format("{},{},{}{},{},{},", object_names.at(h.object), h.instance, h.score,
                           placed.Cells(h.metrics), ChanceCell(maps.PickChance(h)),
                           ChanceCell(maps.PickChance(h, *attempt.grasp)));
        cells_at_end = at_end.Cells(h.metrics);
      } else {
        csv += ",,," + placed.EmptyCells() + ",,";
      }
      csv += fmt::format("{},{},{},{},{}{}{}\n", attempt.failure == FailureReason::kNone ? 1 : 0,
                         FailureName(attempt.failure), 1e3 * attempt.outcome.slip_m,
                         kDegreesPerRadian * attempt.outcome.in_hand_rotation_error_rad,
                         attempt.outcome.neighbors_displaced, OutcomeCells(attempt), cells_at_end);
    }
  }
  return csv;
}

std::string InstanceOutcomesCsv(const std::vector<TrialResult>& trials,
                                const std::vector<std::string>& object_names) {
  std::string csv = HeaderLine(InstanceOutcomesColumns());
  for (const TrialResult& trial : trials) {
    for (const InstanceOutcome& instance_outcome : trial.outcomes) {
      csv += fmt::format("{},{},{},{},{},{},{},{}\n", trial.trial, trial.configuration,
                         instance_outcome.instance, object_names.at(instance_outcome.object),
                         instance_outcome.picked  ? "picked"
                         : instance_outcome.asked ? "failed"
                                                  : "not_asked",
                         FailureName(instance_outcome.failure),
                         StageName(StageOf(instance_outcome.failure)), instance_outcome.attempt);
    }
  }
  return csv;
}

std::string TimingsCsv(const std::vector<TrialResult>& trials, const CycleTime& cycle) {
  std::string csv = HeaderLine(TimingsColumns());
  for (const TrialResult& trial : trials) {
    for (const auto& [stage, seconds] : trial.seconds) {
      csv += fmt::format("{},{},{:.6f}\n", trial.trial, stage, seconds);
    }
  }
  if (cycle.pick_s() == 0) return csv;
  csv += fmt::format("all,cycle/sense,{:.6f}\nall,cycle/compute,{:.6f}\nall,cycle/move,{:.6f}\n",
                     cycle.sense_s, cycle.compute_s, cycle.move_s);
  return csv + fmt::format("all,cycle/part,{:.6f}\n", cycle.pick_s());
}

}  // namespace pickbed::eval
