#include "eval/store/store_columns.h"

#include <fmt/format.h>

#include <stdexcept>
#include <string_view>

#include "eval/store/schema_internal.h"

namespace pickbed::eval {
namespace {

struct Description {
  std::string_view name, help;
  std::string_view unit = {};
};

constexpr Description kTables[] = {
    {"configurations", "configurations of a sweep; a run has one"},
    {"trials", "one row per trial"},
    {"attempts", "one row per attempt"},
    {"hypotheses", "one row per reported pose"},
    {"hypothesis_metrics", "one row per reported pose and metric, see `pickbed list metrics`"},
    {"instances", "one row per attempt and instance in the bin"},
    {"instance_outcomes", "one row per dropped instance that is not a distractor"},
    {"rejections", "grasp candidates that the planner rejected, by attempt and reason"},
    {"refusals", "faults of drops that failed the certificate and were repeated"},
    {"bands", "one row per occlusion trial and band of the visible fraction"},
    {"timings", "one row per trial and stage"},
};

// TABLE.COLUMN, or COLUMN if it has the same meaning in all tables.
constexpr Description kColumns[] = {
    {"trial", "number of the trial"},
    {"configuration", "number of the configuration; 0 in a run"},
    {"attempt", "number of the attempt in its trial"},
    {"hypothesis", "number of the hypothesis in its attempt, highest score first"},
    {"object", "number of the object in the scenario, from 0"},
    {"band", "band of the target's visible fraction, -1 = none"},
    {"seed", "random seed"},
    {"configurations.name", "settings that the grid changes; empty for a run"},
    {"configurations.first_trial", "number of its first trial"},
    {"configurations.trials", "number of trials that belong to it, finished or not"},
    {"configurations.identity", "hash of all inputs; trials can be merged if it is equal"},
    {"configurations.settings", "effective scenario as YAML"},
    {"trials.bin_index", "number of the bin; equal for paired trials of several configurations"},
    {"trials.status", "finished or crashed"},
    {"trials.crash", "reason of the crash; empty if finished"},
    {"trials.instances_dropped", "number of dropped instances that are not distractors"},
    {"trials.instances_cleared", "number of instances that successful picks took out of the bin"},
    {"trials.ended_by", "failure reason that ended the trial, or none"},
    {"trials.at_rest", "1 if all instances came to rest in time"},
    {"trials.simulated_s", "simulated time until all instances were at rest"},
    {"trials.max_speed_mps", "largest final speed of a center of mass"},
    {"trials.max_spin_radps", "largest final angular speed"},
    {"trials.deepest_penetration_m", "deepest overlap of two bodies at rest"},
    {"trials.wake_movement_m", "largest movement of a surface in one more second of simulation"},
    {"trials.wake_movement_diameters", "the same, as a share of the object's diameter"},
    {"trials.layers",
     "number of instances in each layer before the first pick, from the top, as a JSON list; [] = "
     "unknown"},
    {"trials.instances_tested",
     "number of instances, at least 10 % visible in the first image, for which a grasp was planned "
     "at the true pose; at most 20"},
    {"trials.instances_graspable", "number of these with a grasp that meets nothing"},
    {"trials.child_rows",
     "number of rows of the trial in the other tables except timings; a store with fewer or "
     "more is refused"},
    {"trials.hand_eye_x_m", "error of the calibrated camera position in the camera frame, x"},
    {"trials.hand_eye_y_m", "error of the calibrated camera position in the camera frame, y"},
    {"trials.hand_eye_z_m", "error of the calibrated camera position in the camera frame, z"},
    {"trials.hand_eye_rx_rad", "its rotation vector in the camera frame, x"},
    {"trials.hand_eye_ry_rad", "its rotation vector in the camera frame, y"},
    {"trials.hand_eye_rz_rad", "its rotation vector in the camera frame, z"},
    {"trials.focal_error", "error of the calibrated focal length, as a share", "share"},
    {"trials.principal_x_px", "error of the calibrated principal point, column"},
    {"trials.principal_y_px", "error of the calibrated principal point, row"},
    {"trials.depth_bias_m", "offset of the depth readings"},
    {"trials.depth_scale_error", "scale error of the depth readings, as a share", "share"},
    {"trials.bin_x_m", "error of the assumed bin position in the world, x"},
    {"trials.bin_y_m", "error of the assumed bin position in the world, y"},
    {"trials.bin_z_m", "error of the assumed bin position in the world, z"},
    {"trials.bin_rx_rad", "its rotation vector in the world, x"},
    {"trials.bin_ry_rad", "its rotation vector in the world, y"},
    {"trials.bin_rz_rad", "its rotation vector in the world, z"},
    {"attempts.failure", "failure reason, or none"},
    {"attempts.executed", "1 if a grasp was executed"},
    {"attempts.chosen_hypothesis", "hypothesis of the executed grasp, -1 = none"},
    {"attempts.matched_instance",
     "instance that matches the chosen hypothesis; without poses, the one that came or was "
     "nearest; "
     "-1 = none"},
    {"attempts.target", "target instance of an occlusion trial, -1 = none"},
    {"attempts.grasp_hypothesis", "number of the pose that the planner used"},
    {"attempts.grasp_x_wg", "pose of the hand in the world, 3x4 matrix, row by row", "m"},
    {"attempts.grasp_width_m", "distance between the contacts"},
    {"attempts.grasp_score", "rank value of the grasp"},
    {"attempts.grasp_tool", "gripper of the executed grasp; empty in files of earlier versions"},
    {"attempts.grasp_lift_aside_x_m",
     "shift of the hand at the start of the lift, x in the world; 0 = straight up"},
    {"attempts.grasp_lift_aside_y_m",
     "shift of the hand at the start of the lift, y in the world; 0 = straight up"},
    {"attempts.success", "1 if the grasp succeeded by the rule of the scenario"},
    {"attempts.physical_failure", "failure reason of the executed grasp"},
    {"attempts.picked_instance", "instance in the hand at the end, -1 = none"},
    {"attempts.instances_lifted", "number of instances in the hand after hold, shake and carry"},
    {"attempts.final_opening_m", "final opening of the hand"},
    {"attempts.slip_m", "movement of the instance in the hand, from the lift to the shake"},
    {"attempts.in_hand_rotation_error_rad", "rotation of the instance in the hand, same time"},
    {"attempts.neighbors_displaced", "number of other instances that moved more than 1 cm"},
    {"attempts.is_target", "1 if the picked instance is the target"},
    {"attempts.instances_touched", "number of instances in contact with the closed hand"},
    {"attempts.instances_risen", "number of instances in the hand at the end of the lift"},
    {"attempts.lift_height_m", "height of the instance that rose most, at the end of the lift"},
    {"attempts.contact_force_x_n", "mean force on the hand during the hold, x in frame G"},
    {"attempts.contact_force_y_n", "mean force on the hand during the hold, y in frame G"},
    {"attempts.contact_force_z_n", "mean force on the hand during the hold, z in frame G"},
    {"attempts.contact_torque_x_nm", "mean torque about the origin of G, x in frame G"},
    {"attempts.contact_torque_y_nm", "mean torque about the origin of G, y in frame G"},
    {"attempts.contact_torque_z_nm", "mean torque about the origin of G, z in frame G"},
    {"attempts.retreat_contact", "1 if the hand touched an instance after 10 cm of retreat"},
    {"attempts.retreat_opening", "opening of the hand after 10 cm, as a share of its stroke",
     "0..1"},
    {"attempts.place_executed", "1 if the instance was set down"},
    {"attempts.place_error_m", "distance of the center of mass from its planned place"},
    {"attempts.place_rotation_error_rad", "rotation error at the place, minimum over symmetries"},
    {"attempts.hash_scene", "hash of the scene, for `pickbed replay`"},
    {"attempts.hash_image", "hash of the image"},
    {"attempts.hash_hypotheses", "hash of the reported poses"},
    {"attempts.hash_grasp", "hash of the planned grasp"},
    {"attempts.hash_outcome", "hash of the outcome"},
    {"attempts.robot_x_m", "executed minus planned grasp position in the world, x"},
    {"attempts.robot_y_m", "executed minus planned grasp position in the world, y"},
    {"attempts.robot_z_m", "executed minus planned grasp position in the world, z"},
    {"attempts.force_error", "error of the gripper force, as a share", "share"},
    {"attempts.instances_entangled",
     "number of other instances that came out without contact to the hand"},
    {"attempts.retention_g",
     "load at which the hold test lost the instance, or its limit; -1 = not measured", "g"},
    {"attempts.drop_time_s",
     "time from the end of the lift until the instance was lost, -1 = not lost or not measured"},
    {"attempts.pick_of_image", "number of earlier attempts that used the same image"},
    {"attempts.fill_level",
     "mean height of the surface before the pick over the inner height of "
     "the bin, -1 = unknown",
     "share"},
    {"attempts.layer", "layer of the matched instance, 1 = top, 0 = unknown"},
    {"attempts.instances_above", "number of instances that cover it in the top view, -1 = unknown"},
    {"attempts.instances_below", "number of instances that it covers, -1 = unknown"},
    {"attempts.pose_free",
     "1 if the planner worked without poses, so that there was no pose stage"},
    {"hypotheses.instance", "matched instance, -1 = none"},
    {"hypotheses.score", "score of the pose"},
    {"hypotheses.raw_score", "score of the estimator, before a calibration"},
    {"hypotheses.correct", "1 if the MSSD is under a tenth of the object's diameter"},
    {"hypotheses.x_wo", "estimated pose of the object in the world, 3x4 matrix, row by row", "m"},
    {"hypotheses.x_oe", "estimated object frame in the frame of the matched instance", "m"},
    {"hypothesis_metrics.metric", "name and unit of the metric"},
    {"hypothesis_metrics.value", "pose error; infinite without a matched instance"},
    {"instances.instance", "number of the instance in its bin"},
    {"instances.visible_fraction", "visible fraction in the image", "0..1"},
    {"instances.recalled", "1 if a reported pose is correct for it"},
    {"instances.missed", "failure reason why it is not recalled, or none"},
    {"instance_outcomes.instance", "number of the instance in its bin"},
    {"instance_outcomes.picked", "1 if it was picked"},
    {"instance_outcomes.asked", "1 if it was requested"},
    {"instance_outcomes.failure", "failure reason, or none"},
    {"instance_outcomes.attempt", "attempt that decided the outcome, -1 = none"},
    {"instance_outcomes.friction_deviation", "friction against its model, as a share", "share"},
    {"instance_outcomes.mass_deviation", "mass against its model, as a share", "share"},
    {"instance_outcomes.size_deviation", "size against CAD, as a share", "share"},
    {"rejections.cause", "reason of the rejection"},
    {"rejections.grasps", "number of candidates"},
    {"refusals.attempt", "number of the drop"},
    {"refusals.fault", "reason of the refusal"},
    {"bands.band", "number of the band, least visible first"},
    {"bands.filled", "1 if the trial has a scene for this band"},
    {"bands.targets_given_up", "number of targets given up at this band"},
    {"bands.blockers", "number of dropped blockers"},
    {"bands.blockers_kept", "number of blockers that stayed in the scene"},
    {"bands.blockers_refused", "number of blockers whose scene failed its certificate"},
    {"bands.blockers_jumped", "number of blockers that hid too much of the target"},
    {"bands.blockers_useless", "number of blockers that hid too little of the target"},
    {"timings.stage", "stage, with its part after a slash"},
    {"timings.seconds",
     "duration; of a stage not_finite/NAME the number of values that were dropped there"},
};

const Description* FindDescription(std::span<const Description> rows, std::string_view name) {
  for (const Description& row : rows) {
    if (row.name == name) return &row;
  }
  return nullptr;
}

ResultColumn Described(const std::string& table, const std::string& column) {
  for (const std::string& name : {table + "." + column, column}) {
    if (const Description* row = FindDescription(kColumns, name)) {
      return {column, std::string(row->help), std::string(row->unit)};
    }
  }
  for (const SuccessRuleRow& rule : SuccessRuleTable()) {
    if (column == rule.name) return {column, std::string("1 if by this rule: ") + rule.help};
  }
  throw std::logic_error(fmt::format("column {}.{} has no description; add it to {}", table, column,
                                     "eval/store/store_columns.cpp"));
}

template <typename Row>
StoreTable TableOf(const std::string& name) {
  const Description* row = FindDescription(kTables, name);
  if (row == nullptr) throw std::logic_error("table " + name + " has no description");
  StoreTable table{name, std::string(row->help), {}};
  for (const std::string& column : ColumnsOf<Row>()) {
    table.columns.push_back(Described(name, column));
  }
  return table;
}

}  // namespace

std::vector<StoreTable> StoreTables() {
  std::vector<StoreTable> tables{
      {"settings",
       "properties of the file",
       {{"key", "schema_version or scenario"},
        {"value", "version of the tables, or the settings and inputs of the run"}}},
      TableOf<ConfigurationRow>("configurations")};
  ForEachTrialTable([&]<typename Row>(const char* name) { tables.push_back(TableOf<Row>(name)); });
  return tables;
}

}  // namespace pickbed::eval
