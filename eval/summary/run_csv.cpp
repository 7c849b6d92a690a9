#include "eval/summary/run_csv.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <optional>

#include "eval/metrics/metric_columns.h"
#include "eval/metrics/pose_columns.h"
#include "eval/summary/run_columns.h"
#include "eval/summary/success_rates.h"
#include "scenes/base/ids_format.h"
#include "scenes/base/math.h"

namespace pickbed::eval {
namespace {

// Empty if the object has no tolerance model.
std::string ChanceCell(const std::optional<double>& chance) {
  return chance ? fmt::format("{:.4f}", *chance) : "";
}

std::string FillCell(const AttemptRecord& attempt) {
  return attempt.fill_level < 0 ? "" : fmt::format("{:.2f}", 1e2 * attempt.fill_level);
}

// Layer, instances above and instances below.
std::string LayerCells(const AttemptRecord& attempt) {
  if (attempt.layer == 0) return ",,";
  return fmt::format("{},{},{}", attempt.layer, attempt.instances_above, attempt.instances_below);
}

// Object of the instance that a grasp without a pose was on.
ObjectId MatchedObject(const AttemptRecord& attempt) {
  const auto matched =
      std::ranges::find(attempt.instances, attempt.matched_instance, &InstanceRecord::instance);
  return matched == attempt.instances.end() ? ObjectId(0) : matched->object;
}

// Empty without a pose stage.
std::string RecalledCell(const AttemptRecord& attempt, const InstanceRecord& instance) {
  if (attempt.pose_free) return "";
  return instance.recalled ? "1" : "0";
}

// Cells with a comma before each.
std::string VectorCells(const Eigen::Vector3d& v) {
  return fmt::format(",{},{},{}", v.x(), v.y(), v.z());
}

std::string ErrorCells(const BinErrors& e) {
  return fmt::format("{}{},{},{},{},{},{}{}{}", VectorCells(1e3 * e.hand_eye_m),
                     VectorCells(kDegreesPerRadian * e.hand_eye_rotation_rad), 1e2 * e.focal,
                     e.principal_px.x(), e.principal_px.y(), 1e3 * e.depth_bias_m,
                     1e2 * e.depth_scale, VectorCells(1e3 * e.bin_m),
                     VectorCells(kDegreesPerRadian * e.bin_rotation_rad));
}

std::string ErrorCells(const AttemptErrors& e) {
  return fmt::format("{},{}", VectorCells(1e3 * e.robot_m), 1e2 * e.force);
}

}  // namespace

std::string TrialsCsv(const std::vector<TrialResult>& trials,
                      const std::vector<CrashedTrial>& crashed) {
  const ResultColumns columns = TrialsColumns();
  std::string csv = HeaderLine(columns);
  auto next_crashed = crashed.begin();
  const auto add_crashed_before = [&](int trial) {
    for (; next_crashed != crashed.end() && next_crashed->trial < trial; ++next_crashed) {
      csv += fmt::format("{},{},{},crashed{}\n", next_crashed->trial, next_crashed->configuration,
                         next_crashed->bin_index, std::string(columns.size() - 4, ','));
    }
  };
  for (const TrialResult& t : trials) {
    int executed_grasps = 0, successes = 0;
    for (const AttemptRecord& attempt : t.attempts) {
      executed_grasps += UsedHand(attempt);
      successes += attempt.grasp && attempt.failure == FailureReason::kNone;
    }
    add_crashed_before(t.trial);
    csv += fmt::format(
        "{},{},{},finished,{},{},{},{},{},{},{},{},{}{}\n", t.trial, t.configuration, t.bin_index,
        t.instances_dropped, t.instances_cleared, executed_grasps, successes,
        FailureName(t.ended_by), t.certificate.simulated_s, 1e3 * t.certificate.wake_movement_m,
        1e3 * t.certificate.deepest_penetration_m, t.refused.size(), ErrorCells(t.errors));
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
      csv += fmt::format("{},{},{},{},{},{},{},{},{},", trial.trial, trial.configuration,
                         attempt.attempt, attempt.pick_of_image, attempt.target, attempt.band,
                         attempt.instances.size(), FillCell(attempt), attempt.hypotheses.size());
      std::string cells_at_end = at_end.EmptyCells(), pose = EmptyPoseCells();
      if (attempt.chosen >= 0) {
        const HypothesisRecord& h = attempt.hypotheses.at(attempt.chosen);
        csv += fmt::format("{},{},{},{}{},{},{},", object_names.at(h.object), h.instance,
                           LayerCells(attempt), h.score, placed.Cells(h.metrics),
                           ChanceCell(maps.PickChance(h)),
                           ChanceCell(maps.PickChance(h, *attempt.grasp)));
        cells_at_end = at_end.Cells(h.metrics);
        pose = PoseCells(h.X_WO);
      } else if (attempt.pose_free && attempt.matched_instance >= 0) {
        csv += fmt::format("{},{},{},", object_names.at(MatchedObject(attempt)),
                           attempt.matched_instance, LayerCells(attempt)) +
               placed.EmptyCells() + ",,,";
      } else {
        csv += ",,,,,," + placed.EmptyCells() + ",,";
      }
      csv += fmt::format(
          "{},{},{},{},{}{}{}{},{}{}\n", attempt.failure == FailureReason::kNone ? 1 : 0,
          FailureName(attempt.failure), 1e3 * attempt.outcome.slip_m,
          kDegreesPerRadian * attempt.outcome.in_hand_rotation_error_rad,
          attempt.outcome.neighbors_displaced, OutcomeCells(attempt), pose,
          ErrorCells(attempt.errors), attempt.grasp ? attempt.grasp->tool : "", cells_at_end);
    }
  }
  return csv;
}

std::string InstancesCsv(const std::vector<TrialResult>& trials,
                         const std::vector<std::string>& object_names) {
  std::string csv = HeaderLine(InstancesColumns());
  for (const TrialResult& trial : trials) {
    for (const AttemptRecord& attempt : trial.attempts) {
      if (!attempt.has_own_image()) continue;
      for (const InstanceRecord& instance : attempt.instances) {
        csv +=
            fmt::format("{},{},{},{},{},{},{},{},{}\n", trial.trial, trial.configuration,
                        attempt.attempt, instance.instance, object_names.at(instance.object),
                        instance.visible_fraction, RecalledCell(attempt, instance),
                        FailureName(instance.missed), instance.instance == attempt.target ? 1 : 0);
      }
    }
  }
  return csv;
}

std::string InstanceOutcomesCsv(const std::vector<TrialResult>& trials,
                                const std::vector<std::string>& object_names) {
  std::string csv = HeaderLine(InstanceOutcomesColumns());
  for (const TrialResult& trial : trials) {
    for (const InstanceOutcome& instance_outcome : trial.outcomes) {
      csv += fmt::format(
          "{},{},{},{},{},{},{},{},{},{},{}\n", trial.trial, trial.configuration,
          instance_outcome.instance, object_names.at(instance_outcome.object),
          instance_outcome.picked  ? "picked"
          : instance_outcome.asked ? "failed"
                                   : "not_asked",
          FailureName(instance_outcome.failure), StageName(StageOf(instance_outcome.failure)),
          instance_outcome.attempt, 1e2 * instance_outcome.deviation.friction,
          1e2 * instance_outcome.deviation.mass, 1e2 * instance_outcome.size_deviation);
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
  if (cycle.hidden_s > 0) csv += fmt::format("all,cycle/hidden,{:.6f}\n", cycle.hidden_s);
  return csv + fmt::format("all,cycle/part,{:.6f}\n", cycle.pick_s());
}

}  // namespace pickbed::eval
