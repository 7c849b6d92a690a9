#pragma once

// Rows of the tables of the results store. Visit() names their columns for CREATE, INSERT, SELECT.

#include <string>

#include "eval/store/error_columns.h"
#include "eval/store/grasp_columns.h"
#include "eval/store/results_store.h"

namespace pickbed::eval {

inline constexpr char kFinished[] = "finished";
inline constexpr char kCrashed[] = "crashed";

struct ConfigurationRow {
  StoredConfiguration configuration;
  template <typename V>
  void Visit(V&& v) {
    v("configuration", configuration.number);
    v("name", configuration.name);
    v("first_trial", configuration.first_trial);
    v("trials", configuration.trials);
    v("seed", configuration.seed);
    v("identity", configuration.identity);
    v("settings", configuration.settings);
  }
};

// A trial that crashed has no rows in the other tables.
struct TrialRow {
  int trial = 0, child_rows = 0;  // rows of the trial in the other tables except timings
  TrialResult result;
  uint64_t seed = 0;
  std::string status = kFinished;
  std::string crash;  // reason of the crash
  template <typename V>
  void Visit(V&& v) {
    v("trial", trial);
    v("configuration", result.configuration);
    v("bin_index", result.bin_index);
    v("seed", seed);
    v("status", status);
    v("crash", crash);
    v("instances_dropped", result.instances_dropped);
    v("instances_cleared", result.instances_cleared);
    v("ended_by", result.ended_by);
    SceneCertificate& certificate = result.certificate;
    v("at_rest", certificate.at_rest);
    v("simulated_s", certificate.simulated_s);
    v("max_speed_mps", certificate.max_speed_mps);
    v("max_spin_radps", certificate.max_spin_radps);
    v("deepest_penetration_m", certificate.deepest_penetration_m);
    v("wake_movement_m", certificate.wake_movement_m);
    v("wake_movement_diameters", certificate.wake_movement_diameters);
    VisitErrors(v, result.errors);
    v("layers", result.layers);
    v("instances_tested", result.instances_tested);
    v("instances_graspable", result.instances_graspable);
    v("child_rows", child_rows);
  }
};

struct AttemptRow {
  int trial = 0;
  AttemptRecord record;
  bool executed = false;
  Grasp grasp;
  // The states of physics that failed need not be finite.
  bool MayLackNumbers() const { return record.outcome.failure == FailureReason::kPhysicsFailed; }
  template <typename V>
  void Visit(V&& v) {
    GraspOutcome& outcome = record.outcome;
    v("trial", trial);
    v("attempt", record.attempt);
    v("failure", record.failure);
    v("executed", executed);
    v("chosen_hypothesis", record.chosen);
    v("matched_instance", record.matched_instance);
    v("target", record.target);
    v("band", record.band);
    VisitGrasp(v, grasp);
    v("success", outcome.success);
    v("physical_failure", outcome.failure);
    v("picked_instance", outcome.picked_instance);
    v("instances_lifted", outcome.instances_lifted);
    v("final_opening_m", outcome.final_opening_m);
    v("slip_m", outcome.slip_m);
    v("in_hand_rotation_error_rad", outcome.in_hand_rotation_error_rad);
    v("neighbors_displaced", outcome.neighbors_displaced);
    v("is_target", outcome.is_target);
    v("instances_touched", outcome.instances_touched);
    v("instances_risen", outcome.instances_risen);
    v("lift_height_m", outcome.lift_height_m);
    v("contact_force_x_n", outcome.contact_force_n.x());
    v("contact_force_y_n", outcome.contact_force_n.y());
    v("contact_force_z_n", outcome.contact_force_n.z());
    v("contact_torque_x_nm", outcome.contact_torque_nm.x());
    v("contact_torque_y_nm", outcome.contact_torque_nm.y());
    v("contact_torque_z_nm", outcome.contact_torque_nm.z());
    v("retreat_contact", outcome.retreat_contact);
    v("retreat_opening", outcome.retreat_opening);
    v("place_executed", outcome.place_executed);
    v("place_error_m", outcome.place_error_m);
    v("place_rotation_error_rad", outcome.place_rotation_error_rad);
    for (const SuccessRuleRow& row : SuccessRuleTable()) {
      v(row.name, outcome.verdicts[static_cast<int>(row.rule)]);
    }
    v("hash_scene", record.hashes[TrialStage::kScene]);
    v("hash_image", record.hashes[TrialStage::kImage]);
    v("hash_hypotheses", record.hashes[TrialStage::kHypotheses]);
    v("hash_grasp", record.hashes[TrialStage::kGrasp]);
    v("hash_outcome", record.hashes[TrialStage::kOutcome]);
    VisitErrors(v, record.errors);
    v("instances_entangled", outcome.instances_entangled);
    v("retention_g", outcome.retention_g);
    v("drop_time_s", outcome.drop_time_s);
    v("pick_of_image", record.pick_of_image);
    v("fill_level", record.fill_level);
    v("layer", record.layer);
    v("instances_above", record.instances_above);
    v("instances_below", record.instances_below);
    v("pose_free", record.pose_free);
  }
};

struct HypothesisRow {
  int trial = 0, attempt = 0, hypothesis = 0;
  HypothesisRecord score;
  template <typename V>
  void Visit(V&& v) {
    v("trial", trial);
    v("attempt", attempt);
    v("hypothesis", hypothesis);
    v("object", score.object);
    v("instance", score.instance);
    v("score", score.score);
    v("correct", score.correct);
    v("x_wo", score.X_WO);
    v("x_oe", score.X_OE);
    v("raw_score", score.raw_score);
  }
};

// One metric of a hypothesis, by its key. A store can hold metrics that the program does not know.
struct HypothesisMetricRow {
  int trial = 0, attempt = 0, hypothesis = 0;
  MetricValue value;
  template <typename V>
  void Visit(V&& v) {
    v("trial", trial);
    v("attempt", attempt);
    v("hypothesis", hypothesis);
    v("metric", value.metric);
    v("value", value.value);
  }
};

struct InstanceRow {
  int trial = 0, attempt = 0;
  InstanceRecord record;
  template <typename V>
  void Visit(V&& v) {
    v("trial", trial);
    v("attempt", attempt);
    v("instance", record.instance);
    v("object", record.object);
    v("visible_fraction", record.visible_fraction);
    v("recalled", record.recalled);
    v("missed", record.missed);
  }
};

struct InstanceOutcomeRow {
  int trial = 0;
  InstanceOutcome instance_outcome;
  template <typename V>
  void Visit(V&& v) {
    v("trial", trial);
    v("instance", instance_outcome.instance);
    v("object", instance_outcome.object);
    v("picked", instance_outcome.picked);
    v("asked", instance_outcome.asked);
    v("failure", instance_outcome.failure);
    v("attempt", instance_outcome.attempt);
    v("friction_deviation", instance_outcome.deviation.friction);
    v("mass_deviation", instance_outcome.deviation.mass);
    v("size_deviation", instance_outcome.size_deviation);
  }
};

struct RejectionRow {
  int trial = 0, attempt = 0;
  std::string cause;
  int grasps = 0;
  template <typename V>
  void Visit(V&& v) {
    v("trial", trial);
    v("attempt", attempt);
    v("cause", cause);
    v("grasps", grasps);
  }
};

// One fault of a scene that failed certification and was not used.
struct RefusalRow {
  int trial = 0, attempt = 0;
  std::string fault;
  template <typename V>
  void Visit(V&& v) {
    v("trial", trial);
    v("attempt", attempt);
    v("fault", fault);
  }
};

// How one visible-fraction band of an occlusion trial was filled.
struct BandRow {
  int trial = 0, band = 0;
  BandAccount account;
  template <typename V>
  void Visit(V&& v) {
    v("trial", trial);
    v("band", band);
    v("filled", account.filled);
    v("targets_given_up", account.given_up);
    v("blockers", account.blockers.dropped);
    v("blockers_kept", account.blockers.kept);
    v("blockers_refused", account.blockers.refused);
    v("blockers_jumped", account.blockers.jumped);
    v("blockers_useless", account.blockers.useless);
  }
};

struct TimingRow {
  int trial = 0;
  std::string stage;
  double seconds = 0;
  template <typename V>
  void Visit(V&& v) {
    v("trial", trial);
    v("stage", stage);
    v("seconds", seconds);
  }
};

}  // namespace pickbed::eval
