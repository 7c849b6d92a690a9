#pragma once

// Trial records for tests of the results store, and their field-by-field comparison.

#include <gtest/gtest.h>

#include <limits>
#include <map>
#include <tuple>

#include "eval/trial/trial.h"
#include "scenes/base/ids.h"
#include "scenes/base/random.h"
#include "tests/support/layer.h"

namespace pickbed::tests {

inline GraspOutcome FullOutcome(Rng& rng) {
  GraspOutcome outcome;
  outcome.success = true;
  outcome.failure = FailureReason::kDropped;
  outcome.picked_instance = InstanceId{5};
  outcome.instances_lifted = 2;
  outcome.final_opening_m = rng.Uniform();
  outcome.slip_m = rng.Uniform();
  outcome.in_hand_rotation_error_rad = rng.Uniform();
  outcome.neighbors_displaced = 4;
  outcome.is_target = outcome.retreat_contact = outcome.place_executed = true;
  outcome.instances_touched = 3;
  outcome.instances_risen = 2;
  outcome.instances_entangled = 6;
  outcome.lift_height_m = rng.Uniform();
  outcome.contact_force_n = rng.UnitVector();
  outcome.contact_torque_nm = rng.UnitVector();
  outcome.retreat_opening = rng.Uniform();
  outcome.retention_g = rng.Uniform();
  outcome.drop_time_s = rng.Uniform();
  outcome.place_error_m = rng.Uniform();
  outcome.place_rotation_error_rad = rng.Uniform();
  for (size_t i = 0; i < outcome.verdicts.size(); ++i) outcome.verdicts[i] = i % 2 == 0;
  return outcome;
}

// Returns a trial record in which every field except the configuration has a non-default value.
inline TrialResult FullTrial(int trial) {
  Rng rng(trial + 1);
  TrialResult result;
  result.trial = trial;
  result.bin_index = BinIndex(trial + 100);
  result.certificate.at_rest = true;
  result.certificate.simulated_s = rng.Uniform();
  result.certificate.max_speed_mps = rng.Uniform();
  result.certificate.max_spin_radps = rng.Uniform();
  result.certificate.deepest_penetration_m = rng.Uniform();
  result.certificate.wake_movement_m = rng.Uniform();
  result.certificate.wake_movement_diameters = rng.Uniform();
  result.errors.hand_eye_m = rng.UnitVector();
  result.errors.hand_eye_rotation_rad = rng.UnitVector();
  result.errors.focal = rng.Uniform();
  result.errors.principal_px = rng.UnitVector().head<2>();
  result.errors.depth_bias_m = rng.Uniform();
  result.errors.depth_scale = rng.Uniform();
  result.errors.bin_m = rng.UnitVector();
  result.errors.bin_rotation_rad = rng.UnitVector();
  result.refused = {{0, {"not at rest", "overlap"}}, {1, {"fell outside"}}};
  result.instances_dropped = 7;
  result.instances_cleared = 3;
  result.layers = {5, 2, trial};
  result.instances_tested = 6;
  result.instances_graspable = 4;
  result.ended_by = FailureReason::kSlipped;
  for (int p = 0; p < 3; ++p) {
    AttemptRecord& pick = result.attempts.emplace_back();
    pick.attempt = p;
    pick.pick_of_image = p % 2;
    pick.pose_free = p % 2 == 1;
    pick.fill_level = rng.Uniform();
    pick.layer = p + 1;
    pick.instances_above = p + 2;
    pick.instances_below = p + 3;
    pick.target = InstanceId(p + 4);
    pick.band = p + 1;
    for (int i = 0; i < 4; ++i) {
      pick.instances.push_back(
          {InstanceId(i), ObjectId(i % 2), rng.Uniform(), i % 2 == 0, FailureReason::kSuppressed});
    }
    HypothesisRecord score;
    score.object = ObjectId{1};
    score.instance = InstanceId{3};
    score.score = rng.Uniform();
    score.metrics.Set(kMssd_m, rng.Uniform());
    score.metrics.Set("mspd_px", rng.Uniform());
    score.metrics.Set("add_m", rng.Uniform());
    score.metrics.Set("adi_m", rng.Uniform());
    score.metrics.Set(kRotation_rad, rng.Uniform());
    score.metrics.Set(kTranslation_m, rng.Uniform());
    score.metrics.Set("of_another_version", rng.Uniform());
    score.metrics.Set(kMssdDiameters, std::numeric_limits<double>::infinity());
    score.correct = true;
    score.X_WO = MakePose(rng.Rotation().toRotationMatrix(), rng.UnitVector());
    score.X_OE = MakePose(rng.Rotation().toRotationMatrix(), rng.UnitVector());
    score.raw_score = 100 * rng.Normal();
    pick.hypotheses = {score, HypothesisRecord()};
    pick.failure = FailureReason::kNoGrasp;
    pick.grasps_rejected = {{"collision", 12}, {"tilt's", 3}};
    for (uint64_t& hash : pick.hashes.values) hash = rng.Next();
    pick.errors = {rng.UnitVector(), rng.Uniform()};
    if (p == 2) continue;  // an attempt without a grasp
    pick.chosen = 1;
    pick.matched_instance = InstanceId{3};
    Grasp grasp;
    grasp.X_WG = MakePose(rng.Rotation().toRotationMatrix(), rng.UnitVector());
    grasp.width_m = rng.Uniform();
    grasp.score = rng.Uniform();
    grasp.hypothesis = 1;
    grasp.lift_aside_m = {0.02, -0.01};
    pick.grasp = grasp;
    pick.outcome = FullOutcome(rng);
  }
  result.outcomes = {
      {InstanceId{0}, ObjectId{1}, true, true, FailureReason::kNone, 0},
      {InstanceId{1}, ObjectId{0}, false, false, FailureReason::kNeighborDisplaced, 2}};
  result.outcomes[1].deviation = {rng.Uniform(), rng.Uniform()};
  result.outcomes[1].size_deviation = rng.Uniform();
  result.bands = {{true, 1, {15, 2, 3, 4, 6}}, {false, 5, {7, 0, 7, 0, 0}}};
  result.seconds = {{"drop", rng.Uniform()}, {"capture", rng.Uniform()}};
  return result;
}

inline void ExpectSamePick(const AttemptRecord& a, const AttemptRecord& b) {
  EXPECT_EQ(a.attempt, b.attempt);
  EXPECT_EQ(a.pick_of_image, b.pick_of_image);
  EXPECT_EQ(a.pose_free, b.pose_free);
  EXPECT_EQ(std::tie(a.fill_level, a.layer, a.instances_above, a.instances_below),
            std::tie(b.fill_level, b.layer, b.instances_above, b.instances_below));
  EXPECT_EQ(a.chosen, b.chosen);
  EXPECT_EQ(a.matched_instance, b.matched_instance);
  EXPECT_EQ(a.target, b.target);
  EXPECT_EQ(a.band, b.band);
  EXPECT_EQ(a.failure, b.failure);
  EXPECT_EQ(a.grasps_rejected, b.grasps_rejected);
  EXPECT_EQ(a.hashes, b.hashes);
  EXPECT_EQ(a.errors.robot_m, b.errors.robot_m);
  EXPECT_EQ(a.errors.force, b.errors.force);
  ASSERT_EQ(a.grasp.has_value(), b.grasp.has_value());
  if (a.grasp) {
    EXPECT_EQ(a.grasp->X_WG.matrix(), b.grasp->X_WG.matrix());
    EXPECT_EQ(a.grasp->width_m, b.grasp->width_m);
    EXPECT_EQ(a.grasp->score, b.grasp->score);
    EXPECT_EQ(a.grasp->hypothesis, b.grasp->hypothesis);
    EXPECT_EQ(a.grasp->lift_aside_m, b.grasp->lift_aside_m);
  }
  EXPECT_EQ(a.outcome.success, b.outcome.success);
  EXPECT_EQ(a.outcome.failure, b.outcome.failure);
  EXPECT_EQ(a.outcome.picked_instance, b.outcome.picked_instance);
  EXPECT_EQ(a.outcome.instances_lifted, b.outcome.instances_lifted);
  EXPECT_EQ(a.outcome.instances_entangled, b.outcome.instances_entangled);
  EXPECT_EQ(a.outcome.final_opening_m, b.outcome.final_opening_m);
  EXPECT_EQ(a.outcome.slip_m, b.outcome.slip_m);
  EXPECT_EQ(a.outcome.in_hand_rotation_error_rad, b.outcome.in_hand_rotation_error_rad);
  EXPECT_EQ(a.outcome.neighbors_displaced, b.outcome.neighbors_displaced);
  EXPECT_EQ(a.outcome.is_target, b.outcome.is_target);
  EXPECT_EQ(a.outcome.instances_touched, b.outcome.instances_touched);
  EXPECT_EQ(a.outcome.instances_risen, b.outcome.instances_risen);
  EXPECT_EQ(a.outcome.lift_height_m, b.outcome.lift_height_m);
  EXPECT_EQ(a.outcome.contact_force_n, b.outcome.contact_force_n);
  EXPECT_EQ(a.outcome.contact_torque_nm, b.outcome.contact_torque_nm);
  EXPECT_EQ(a.outcome.retreat_contact, b.outcome.retreat_contact);
  EXPECT_EQ(a.outcome.retreat_opening, b.outcome.retreat_opening);
  EXPECT_EQ(a.outcome.place_executed, b.outcome.place_executed);
  EXPECT_EQ(a.outcome.place_error_m, b.outcome.place_error_m);
  EXPECT_EQ(a.outcome.place_rotation_error_rad, b.outcome.place_rotation_error_rad);
  EXPECT_EQ(a.outcome.retention_g, b.outcome.retention_g);
  EXPECT_EQ(a.outcome.drop_time_s, b.outcome.drop_time_s);
  EXPECT_EQ(a.outcome.verdicts, b.outcome.verdicts);
  ASSERT_EQ(a.instances.size(), b.instances.size());
  for (size_t i = 0; i < a.instances.size(); ++i) {
    EXPECT_EQ(a.instances[i].instance, b.instances[i].instance);
    EXPECT_EQ(a.instances[i].object, b.instances[i].object);
    EXPECT_EQ(a.instances[i].visible_fraction, b.instances[i].visible_fraction);
    EXPECT_EQ(a.instances[i].recalled, b.instances[i].recalled);
    EXPECT_EQ(a.instances[i].missed, b.instances[i].missed);
  }
  ASSERT_EQ(a.hypotheses.size(), b.hypotheses.size());
  for (size_t i = 0; i < a.hypotheses.size(); ++i) {
    const HypothesisRecord &x = a.hypotheses[i], &y = b.hypotheses[i];
    EXPECT_EQ(std::tie(x.object, x.instance, x.score, x.raw_score, x.correct),
              std::tie(y.object, y.instance, y.score, y.raw_score, y.correct));
    const auto values = [](const HypothesisRecord& record) {
      std::map<std::string, double> by_metric;
      for (const MetricValue& value : record.metrics) by_metric[value.metric] = value.value;
      return by_metric;
    };
    EXPECT_EQ(values(x), values(y));
    EXPECT_EQ(x.X_WO.matrix(), y.X_WO.matrix());
    EXPECT_EQ(x.X_OE.matrix(), y.X_OE.matrix());
  }
}

inline void ExpectSameTrial(const TrialResult& a, const TrialResult& b) {
  EXPECT_EQ(a.trial, b.trial);
  EXPECT_EQ(a.configuration, b.configuration);
  EXPECT_EQ(a.bin_index, b.bin_index);
  EXPECT_EQ(a.instances_dropped, b.instances_dropped);
  EXPECT_EQ(a.instances_cleared, b.instances_cleared);
  EXPECT_EQ(a.layers, b.layers);
  EXPECT_EQ(a.instances_tested, b.instances_tested);
  EXPECT_EQ(a.instances_graspable, b.instances_graspable);
  EXPECT_EQ(a.ended_by, b.ended_by);
  EXPECT_EQ(a.certificate.at_rest, b.certificate.at_rest);
  EXPECT_EQ(a.certificate.simulated_s, b.certificate.simulated_s);
  EXPECT_EQ(a.certificate.max_speed_mps, b.certificate.max_speed_mps);
  EXPECT_EQ(a.certificate.max_spin_radps, b.certificate.max_spin_radps);
  EXPECT_EQ(a.certificate.deepest_penetration_m, b.certificate.deepest_penetration_m);
  EXPECT_EQ(a.certificate.wake_movement_m, b.certificate.wake_movement_m);
  EXPECT_EQ(a.certificate.wake_movement_diameters, b.certificate.wake_movement_diameters);
  const BinErrors &p = a.errors, &q = b.errors;
  EXPECT_EQ(std::tie(p.hand_eye_m, p.hand_eye_rotation_rad, p.focal, p.principal_px),
            std::tie(q.hand_eye_m, q.hand_eye_rotation_rad, q.focal, q.principal_px));
  EXPECT_EQ(std::tie(p.depth_bias_m, p.depth_scale, p.bin_m, p.bin_rotation_rad),
            std::tie(q.depth_bias_m, q.depth_scale, q.bin_m, q.bin_rotation_rad));
  ASSERT_EQ(a.refused.size(), b.refused.size());
  for (size_t i = 0; i < a.refused.size(); ++i) {
    EXPECT_EQ(a.refused[i].attempt, b.refused[i].attempt);
    EXPECT_EQ(a.refused[i].faults, b.refused[i].faults);
  }
  ASSERT_EQ(a.outcomes.size(), b.outcomes.size());
  for (size_t i = 0; i < a.outcomes.size(); ++i) {
    const InstanceOutcome &x = a.outcomes[i], &y = b.outcomes[i];
    EXPECT_EQ(std::tie(x.instance, x.object, x.picked, x.asked, x.failure, x.attempt),
              std::tie(y.instance, y.object, y.picked, y.asked, y.failure, y.attempt));
    EXPECT_EQ(x.deviation, y.deviation);
    EXPECT_EQ(x.size_deviation, y.size_deviation);
  }
  EXPECT_EQ(a.bands, b.bands);
  EXPECT_EQ(a.seconds, b.seconds);
  ASSERT_EQ(a.attempts.size(), b.attempts.size());
  for (size_t i = 0; i < a.attempts.size(); ++i) ExpectSamePick(a.attempts[i], b.attempts[i]);
}

}  // namespace pickbed::tests
