#include "eval/trial/stage_hash.h"

#include <cstring>

#include "eval/cell/simulated_cell.h"
#include "eval/trial/trial.h"

namespace pickbed::eval {
namespace {

// Hashes contain the former names of causes, so that a replay can compare them with the hashes of
// earlier versions.
std::string_view HashedCause(std::string_view cause) {
  for (const RenamedCause& renamed : kRenamedCauses) {
    if (cause == renamed.is) return renamed.was;
  }
  return cause;
}

}  // namespace

const char* StageName(TrialStage stage) {
  switch (stage) {
    case TrialStage::kScene:
      return "scene";
    case TrialStage::kImage:
      return "image";
    case TrialStage::kHypotheses:
      return "hypotheses";
    case TrialStage::kGrasp:
      return "grasp";
    case TrialStage::kOutcome:
      return "outcome";
  }
  return "";
}

StateHash& StateHash::Add(const Pose& X) {
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 4; ++column) Add(X.matrix()(row, column));
  }
  return *this;
}

StateHash& StateHash::AddBytes(const void* data, size_t size) {
  AddWord(size);
  const auto* bytes = static_cast<const char*>(data);
  uint64_t word = 0;
  for (; size >= sizeof(word); size -= sizeof(word), bytes += sizeof(word)) {
    std::memcpy(&word, bytes, sizeof(word));
    AddWord(word);
  }
  word = 0;
  std::memcpy(&word, bytes, size);
  return size > 0 ? AddWord(word) : *this;
}

uint64_t StateHash::value() const { return state_ == 0 ? 1 : state_; }

uint64_t HashOf(const Scene& scene) {
  StateHash hash;
  hash.Add(scene.bin.inner_size_m).Add(scene.bin.wall_m).Add(scene.bin.friction);
  for (const PosedObject& posed : scene.objects) {
    hash.Add(posed.instance).Add(posed.object).Add(posed.X_WO);
    if (posed.deviation == InstanceDeviation()) continue;
    hash.Add(posed.deviation.friction).Add(posed.deviation.mass);
  }
  return hash.value();
}

uint64_t HashOf(const Observation& view) {
  StateHash hash;
  const CameraIntrinsics& k = view.frame.intrinsics;
  hash.Add(k.fx()).Add(k.fy()).Add(k.cx()).Add(k.cy());
  hash.Add(view.frame.depth_m).Add(view.frame.color).Add(view.ids);
  for (const double fraction : view.visible_fractions) hash.Add(fraction);
  return hash.value();
}

uint64_t HashOfHypotheses(const AttemptRecord& record) {
  StateHash hash;
  hash.Add(record.hypotheses.size());
  for (const HypothesisRecord& hypothesis : record.hypotheses) {
    hash.Add(hypothesis.object).Add(hypothesis.score).Add(hypothesis.X_WO);
  }
  return hash.value();
}

uint64_t HashOfGrasp(const AttemptRecord& record) {
  StateHash hash;
  hash.Add(record.grasp.has_value());
  if (record.grasp) {
    const Grasp& grasp = *record.grasp;
    hash.Add(grasp.X_WG)
        .Add(grasp.width_m)
        .Add(grasp.score)
        .Add(grasp.hypothesis)
        .Add(std::string_view(grasp.tool));
    // A lift straight up keeps the hashes of stores of earlier versions.
    if (grasp.lift_aside_m != Eigen::Vector2d::Zero())
      hash.Add(grasp.lift_aside_m.x()).Add(grasp.lift_aside_m.y());
  }
  for (const auto& [cause, grasps] : record.grasps_rejected) {
    hash.Add(HashedCause(cause)).Add(grasps);
  }
  return hash.value();
}

uint64_t HashOfOutcome(const AttemptRecord& record) {
  StateHash hash;
  const GraspOutcome& o = record.outcome;
  hash.Add(record.chosen).Add(record.matched_instance).Add(record.failure);
  hash.Add(o.success).Add(o.failure).Add(o.picked_instance).Add(o.instances_lifted);
  hash.Add(o.final_opening_m)
      .Add(o.slip_m)
      .Add(o.in_hand_rotation_error_rad)
      .Add(o.neighbors_displaced);
  hash.Add(o.is_target).Add(o.instances_touched).Add(o.instances_risen).Add(o.lift_height_m);
  hash.Add(o.contact_force_n).Add(o.contact_torque_nm);
  hash.Add(o.retreat_contact).Add(o.retreat_opening);
  hash.Add(o.place_executed).Add(o.place_error_m).Add(o.place_rotation_error_rad);
  for (const bool verdict : o.verdicts) hash.Add(verdict);
  if (o.instances_entangled > 0) hash.Add(o.instances_entangled);
  const GraspOutcome unmeasured;
  if (o.retention_g != unmeasured.retention_g) hash.Add(o.retention_g);
  if (o.drop_time_s != unmeasured.drop_time_s) hash.Add(o.drop_time_s);
  // An exact cell keeps the hashes of earlier versions.
  const AttemptErrors& e = record.errors;
  if (!e.robot_m.isZero(0) || e.force != 0) hash.Add(e.robot_m).Add(e.force);
  return hash.value();
}

}  // namespace pickbed::eval
