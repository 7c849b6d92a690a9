#include "eval/summary/run_columns.h"

#include <fmt/format.h>

#include "eval/metrics/interval_json.h"
#include "eval/metrics/metric_columns.h"
#include "eval/metrics/pose_columns.h"
#include "eval/summary/clutter_json.h"
#include "eval/summary/success_rates.h"
#include "eval/tolerance/pick_forecast.h"

namespace pickbed::eval {
namespace {

constexpr char kShare[] = "0..1";
constexpr char kTrialHelp[] = "number of the trial in its results folder";
constexpr char kConfigurationHelp[] = "number of the configuration of a sweep; 0 in a run";

// Keys of the counts and the rate of one band of the occlusion trials.
void AddBandKeys(ResultColumns& keys) {
  const std::string at = "target_by_visibility[].";
  AddColumns({{at + "visible_min", "lower limit of the visible fraction", kShare},
              {at + "visible_max", "upper limit of the visible fraction", kShare},
              {at + "attempts", "number of attempts with a target in this band"},
              {at + "trials_without", "number of trials without a scene for this band"},
              {at + "failures.REASON", "number of failed attempts with this reason"},
              {at + "mean_visible", "mean visible fraction of the target", kShare}},
             keys);
  for (const std::string group : {"recall", "picks"}) {
    const std::string what =
        group == "recall" ? "attempts with a correct pose of the target" : "picks of the target";
    AddColumns({{at + group + ".hits", "number of " + what},
                {at + group + ".rate", "hits / attempts", kShare}},
               keys);
    AddColumns(IntervalKeys(at + group + ".ci95", "95 % interval of rate"), keys);
  }
  keys.push_back({at + "posed", "number of attempts with a pose that matches the target"});
  for (const std::string median :
       {"median_mssd_diameters", "median_translation_m", "median_rotation_rad"}) {
    keys.push_back({at + median, "median error of the best pose of the target"});
    AddColumns(IntervalKeys(at + median + "_ci95", "its 95 % interval; null for an infinite end",
                            UnitInName(median)),
               keys);
  }
}

// Keys of a count, of its hits and of their rate.
void AddRateKeys(const std::string& group, const std::string& samples,
                 const std::string& samples_help, const std::string& hits,
                 const std::string& hits_help, ResultColumns& keys) {
  AddColumns({{group + "." + samples, samples_help},
              {group + "." + hits, hits_help},
              {group + ".rate", fmt::format("{} / {}; null without any", hits, samples), kShare}},
             keys);
  AddColumns(IntervalKeys(group + ".ci95", "95 % interval of rate"), keys);
}

}  // namespace

ResultColumns TrialsColumns() {
  return {
      {"trial", kTrialHelp},
      {"configuration", kConfigurationHelp},
      {"bin_index", "number of the bin; equal for the paired trials of several configurations"},
      {"status", "finished or crashed; a crashed trial has no further cells"},
      {"instances_dropped", "number of dropped instances that are not distractors"},
      {"instances_cleared", "number of instances that successful picks took out of the bin"},
      {"executed_grasps", "number of executed grasps and of stirs"},
      {"successes", "number of executed grasps that succeeded"},
      {"ended_by",
       "failure reason that ended the trial; none if the bin is empty or the number of "
       "attempts is reached"},
      {"settled_s", "simulated time until all instances were at rest"},
      {"wake_movement_mm", "largest movement of a surface in one more second of simulation"},
      {"penetration_mm", "deepest overlap of two bodies at rest"},
      {"scenes_refused", "number of drops that failed the certificate and were repeated"},
      {"hand_eye_x_mm", "error of the calibrated camera position in the camera frame, x"},
      {"hand_eye_y_mm", "error of the calibrated camera position in the camera frame, y"},
      {"hand_eye_z_mm", "error of the calibrated camera position in the camera frame, z"},
      {"hand_eye_rx_deg", "its rotation vector in the camera frame, x"},
      {"hand_eye_ry_deg", "its rotation vector in the camera frame, y"},
      {"hand_eye_rz_deg", "its rotation vector in the camera frame, z"},
      {"focal_percent", "error of the calibrated focal length", "percent"},
      {"principal_x_px", "error of the calibrated principal point, column"},
      {"principal_y_px", "error of the calibrated principal point, row"},
      {"depth_bias_mm", "offset of the depth readings"},
      {"depth_scale_percent", "scale error of the depth readings", "percent"},
      {"bin_x_mm", "error of the assumed bin position in the world, x"},
      {"bin_y_mm", "error of the assumed bin position in the world, y"},
      {"bin_z_mm", "error of the assumed bin position in the world, z"},
      {"bin_rx_deg", "its rotation vector in the world, x"},
      {"bin_ry_deg", "its rotation vector in the world, y"},
      {"bin_rz_deg", "its rotation vector in the world, z"},
  };
}

ResultColumns AttemptsColumns() {
  ResultColumns columns{
      {"trial", kTrialHelp},
      {"configuration", kConfigurationHelp},
      {"attempt", "number of the attempt in its trial"},
      {"pick_of_image", "number of earlier attempts that used the same image"},
      {"target", "target instance of an occlusion trial, -1 = none"},
      {"band", "band of the target's visible fraction, -1 = none"},
      {"instances_in_view", "number of instances in the bin"},
      {"fill_percent",
       "mean height of the surface before the pick over the inner height of the bin", "percent"},
      {"hypotheses", "number of reported poses"},
      {"object",
       "object of the chosen hypothesis; without poses, of the instance that came or was nearest; "
       "empty without an executed grasp"},
      {"instance",
       "instance that matches the chosen hypothesis, -1 = none; without poses, the one that came "
       "or "
       "was nearest"},
      {"layer", "layer of this instance, 1 = top; empty without one"},
      {"instances_above", "number of instances that cover it in the top view"},
      {"instances_below", "number of instances that it covers in the top view"},
      {"confidence", "score of the chosen hypothesis"},
  };
  AddColumns(MetricColumns::Placed(MetricUnits::kShown).Columns(), columns);
  AddColumns({{"p_pick",
               "predicted probability that a pick at the chosen pose succeeds, mean over the "
               "grasps of the tolerance map; empty without a map",
               kShare},
              {"p_grasp", "the same for the executed grasp", kShare},
              {"success", "1 if the attempt succeeded"},
              {"failure", "failure reason, see `pickbed list failures`"},
              {"slip_mm", "movement of the instance in the hand, from the lift to the shake"},
              {"in_hand_rotation_error_deg", "rotation of the instance in the hand, same time"},
              {"neighbors_displaced", "number of other instances that moved more than 1 cm"}},
             columns);
  AddColumns(OutcomeColumns(), columns);
  AddColumns(PoseColumns("pose of the chosen hypothesis"), columns);
  AddColumns(
      {
          {"robot_x_mm", "executed minus planned grasp position in the world, x"},
          {"robot_y_mm", "executed minus planned grasp position in the world, y"},
          {"robot_z_mm", "executed minus planned grasp position in the world, z"},
          {"force_percent", "error of the gripper force", "percent"},
      },
      columns);
  columns.push_back({"tool", "gripper of the executed grasp"});
  AddColumns(MetricColumns::AtEnd(MetricUnits::kShown).Columns(), columns);
  return columns;
}

ResultColumns InstancesColumns() {
  return {
      {"trial", kTrialHelp},
      {"configuration", kConfigurationHelp},
      {"attempt", "number of the attempt in its trial"},
      {"instance", "number of the instance in its bin"},
      {"object", "name of the object"},
      {"visible_fraction", "visible share of its pixels; recall counts from 0.1 on", kShare},
      {"found", "1 if a reported pose is correct for it"},
      {"missed", "reason why it was not found, see `pickbed list failures`"},
      {"target", "1 if it is the target of an occlusion trial"},
  };
}

ResultColumns InstanceOutcomesColumns() {
  return {
      {"trial", kTrialHelp},
      {"configuration", kConfigurationHelp},
      {"instance", "number of the instance in its bin"},
      {"object", "name of the object"},
      {"outcome", "picked, failed or not_asked (not requested)"},
      {"failure", "failure reason, see `pickbed list failures`"},
      {"stage", "stage that the failure is attributed to"},
      {"attempt", "attempt that decided the outcome, -1 = none"},
      {"friction_percent", "deviation of its friction from the model", "percent"},
      {"mass_percent", "deviation of its mass from the model", "percent"},
      {"size_percent", "deviation of its size from CAD", "percent"},
  };
}

ResultColumns ConfigurationsColumns() {
  return {
      {"configuration", "number of the configuration"},
      {"name", "settings that the grid changes; empty for a run"},
      {"seed", "random seed"},
      {"first_trial", "number of its first trial"},
      {"trials", "number of trials that belong to it"},
      {"finished", "number of finished trials"},
      {"crashed", "number of crashed trials"},
      {"executed_grasps", "number of executed grasps and of stirs"},
      {"successes", "number of executed grasps that succeeded"},
      {"success_rate", "successes / executed_grasps", kShare},
      {"success_low", "lower end of the 95 % interval of success_rate; bins are the units", kShare},
      {"success_high", "upper end of the 95 % interval of success_rate", kShare},
      {"instances_dropped", "number of dropped instances that are not distractors"},
      {"instances_cleared", "number of instances that successful picks took out of the bins"},
      {"frames", "number of images with at least one reported pose"},
      {"top1_correct", "number of these images whose highest-ranked pose is correct"},
  };
}

ResultColumns TimingsColumns() {
  return {
      {"trial", "number of the trial; all = mean per picked instance"},
      {"stage", "stage, with its part after a slash"},
      {"seconds", "duration"},
  };
}

ResultColumns CurveColumns() {
  return {
      {"configuration", "name of the configuration; empty for a run"},
      {"visible_min", "lower limit of the target's visible fraction", kShare},
      {"visible_max", "upper limit of the target's visible fraction", kShare},
      {"attempts", "number of attempts with a target in this band"},
      {"visible_mean", "mean visible fraction of the target", kShare},
      {"recalled", "number of attempts with a correct pose of the target"},
      {"recall", "recalled / attempts", kShare},
      {"recall_low", "lower end of the 95 % interval of recall", kShare},
      {"recall_high", "upper end of the 95 % interval of recall", kShare},
      {"picked", "number of picks of the target"},
      {"pick_rate", "picked / attempts", kShare},
      {"pick_low", "lower end of the 95 % interval of pick_rate", kShare},
      {"pick_high", "upper end of the 95 % interval of pick_rate", kShare},
      {"posed", "number of attempts with a pose that matches the target"},
      {"mssd_diameters", "median MSSD of the best pose of the target"},
      {"mssd_low", "lower end of its 95 % interval", "diameters"},
      {"mssd_high", "upper end of its 95 % interval", "diameters"},
      {"translation_mm", "median translation error of the best pose of the target"},
      {"translation_low", "lower end of its 95 % interval", "mm"},
      {"translation_high", "upper end of its 95 % interval", "mm"},
      {"rotation_deg", "median rotation error of the best pose of the target"},
      {"rotation_low", "lower end of its 95 % interval", "deg"},
      {"rotation_high", "upper end of its 95 % interval", "deg"},
      {"trials_without", "number of trials without a scene for this band"},
      {"targets_given_up", "number of targets given up at this band"},
      {"blockers", "number of dropped blockers"},
      {"blockers_kept", "number of blockers that stayed in a scene"},
      {"blockers_refused", "number of blockers whose scene failed its certificate"},
      {"blockers_jumped", "number of blockers that hid too much of the target"},
      {"blockers_useless", "number of blockers that hid too little of the target"},
  };
}

ResultColumns SummaryKeys() {
  ResultColumns keys;
  const auto add = [&](const ResultColumns& more) { AddColumns(more, keys); };
  add({
      {"trials", "number of finished trials"},
      {"executed_grasps", "number of executed grasps and of stirs"},
      {"successes", "number of executed grasps that succeeded"},
      {"success_rate", "successes / executed_grasps", kShare},
  });
  add(IntervalKeys("success_ci95", "95 % interval of success_rate; bins are the units"));
  add({
      {"success_by_rule.RULE.successes", "number of grasps that succeed by this rule"},
      {"success_by_rule.RULE.rate", "share of the executed grasps", kShare},
  });
  add(IntervalKeys("success_by_rule.RULE.ci95", "95 % interval of rate"));
  add({
      {"stop.width", "width of the interval at which the run may end early; only with stop_width"},
      {"stop.reached", "whether the width was reached"},
      {"stop.bins", "number of bins until then"},
      {"stop.mean", "pick success in these bins", kShare},
      {"stop.interval", "95 % confidence sequence of the pick success"},
      {"instances_dropped", "number of dropped instances that are not distractors"},
      {"instances_cleared", "number of instances that successful picks took out of the bins"},
      {"cleared_rate", "instances_cleared / instances_dropped", kShare},
  });
  add(IntervalKeys("cleared_ci95", "95 % interval of cleared_rate"));
  AddRateKeys("attempts", "all", "number of attempts", "picked",
              "number of attempts that picked an instance; one without a grasp did not", keys);
  AddRateKeys("requested", "instances",
              "number of requested instances; all that were dropped unless the policy limits the "
              "attempts",
              "picked", "number of instances that successful picks took out of the bins", keys);
  AddRateKeys("recall", "instances",
              "number of instances in view that are at least 10 % visible; an instance counts once "
              "per image",
              "recalled", "number of these with a correct pose", keys);
  AddRateKeys("precision", "poses", "number of reported poses", "right",
              "number of these that are correct; a second pose of an instance is not", keys);
  add({{"false_positives", "precision.poses - precision.right"}});
  AddRateKeys("target_recall", "targets", "number of targets; only of occlusion trials", "recalled",
              "number of these with a correct pose", keys);
  add({
      {"tools.GRIPPER.executed_grasps", "number of executed grasps; only with several grippers"},
      {"tools.GRIPPER.successes", "number of these that succeeded"},
      {"tools.GRIPPER.rate", "successes / executed_grasps", kShare},
      {"tool_changes", "number of grasps with another gripper than the grasp before"},
      {"in_view.BAND", "number of instances in view in a band of visible fractions"},
  });
  for (const ResultColumn& key : ClutterKeys()) {
    if (key.name == "gripper") continue;
    add({{"clutter." + key.name, key.help + ", before the first pick", key.unit}});
  }
  add({
      {"images", "number of captured images; several attempts can share one"},
      {"frames", "number of images with at least one reported pose"},
      {"top1_precision", "share of these images whose highest-ranked pose is correct", kShare},
  });
  add(IntervalKeys("top1_ci95", "95 % interval of top1_precision"));
  add({
      {"recall_by_visibility.BAND.instances", "number of instances in a band of visible fractions"},
      {"recall_by_visibility.BAND.recalled", "number of these with a correct pose"},
      {"recall_by_visibility.BAND.recall", "recalled / instances; null without instances", kShare},
  });
  add(IntervalKeys("recall_by_visibility.BAND.ci95", "95 % interval of recall"));
  AddRateKeys("success_by_fill.BAND", "executed_grasps",
              "number of grasps executed at a band of fill levels, percent of the bin's height",
              "successes", "number of these that succeeded", keys);
  AddRateKeys("success_by_layer.LAYER", "executed_grasps",
              "number of grasps executed at an instance of this layer: layer_1 is the top one, "
              "layer_5- counts all from the fifth",
              "successes", "number of these that succeeded", keys);
  add({
      {"scenes_refused[].trial", "trial of a drop that failed the certificate"},
      {"scenes_refused[].attempt", "number of the drop"},
      {"scenes_refused[].faults", "reasons, one text each"},
      {"trials_crashed[].trial", "trial whose worker process crashed"},
      {"trials_crashed[].bin_index", "its bin"},
      {"trials_crashed[].seed", "its random seed"},
      {"trials_crashed[].why", "reason of the crash"},
      {"failures.REASON", "number of failed attempts with this reason"},
      {"retention.picks", "number of hold tests; only with policy.retention_g"},
      {"retention.min_g", "smallest load at which a hold test lost the instance, multiples of g"},
      {"retention.median_g", "median load at which a hold test lost the instance, multiples of g"},
      {"drop_time.drops", "number of lifted instances that left the hand; only if there are any"},
      {"drop_time.median_s", "median time from the end of the lift until then", "s"},
      {"picks_per_hour",
       "picks per hour by the settings `cycle`, without the time to compute if they do not give "
       "it; null if nothing was picked"},
      {"cycle.sense_s", "time to capture images, for each picked instance", "s"},
      {"cycle.compute_s", "time to compute, the same; null if the settings do not give it", "s"},
      {"cycle.move_s", "time to move, the same", "s"},
      {"cycle.hidden_s", "time of images and computing that cycle.overlap hides, the same", "s"},
  });
  AddBandKeys(keys);
  for (ResultColumn key : ForecastKeys()) {
    key.name = "pick_forecasts[]." + key.name;
    keys.push_back(std::move(key));
  }
  return keys;
}

}  // namespace pickbed::eval
