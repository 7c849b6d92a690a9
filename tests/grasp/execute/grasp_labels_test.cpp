#include <gtest/gtest.h>

#include <algorithm>
#include <numbers>

#include "grasp/execute/execute.h"
#include "grasp/grippers/table.h"
#include "tests/grasp/grasp_scenes.h"

namespace pickbed::tests {
namespace {

// Returns all numbers of an outcome.
std::vector<double> Label(const GraspOutcome& o) {
  std::vector<double> label{static_cast<double>(o.success),
                            static_cast<double>(o.failure),
                            static_cast<double>(o.picked_instance),
                            static_cast<double>(o.instances_lifted),
                            o.final_opening_m,
                            o.slip_m,
                            o.in_hand_rotation_error_rad,
                            static_cast<double>(o.neighbors_displaced),
                            static_cast<double>(o.is_target),
                            static_cast<double>(o.instances_touched),
                            static_cast<double>(o.instances_risen),
                            o.lift_height_m,
                            static_cast<double>(o.retreat_contact),
                            o.retreat_opening,
                            static_cast<double>(o.place_executed),
                            o.place_error_m,
                            o.place_rotation_error_rad};
  label.insert(label.end(), o.contact_force_n.begin(), o.contact_force_n.end());
  label.insert(label.end(), o.contact_torque_nm.begin(), o.contact_torque_nm.end());
  label.insert(label.end(), o.verdicts.begin(), o.verdicts.end());
  return label;
}

std::vector<std::vector<double>> LabelsOfSampledGrasps(const Gripper& gripper, double min_z_m,
                                                       double max_z_m, int count) {
  constexpr double kHeight_m = 0.04;
  const ObjectSet boxes{BoxObject({0.04, 0.05, kHeight_m}, 0.2)};
  const Scene scene = BoxesOnFloor({{0, 0}, {0.06, 0.01}, {-0.04, 0.06}}, kHeight_m);
  Rng rng(11);
  std::vector<std::vector<double>> labels;
  for (int i = 0; i < count; ++i) {
    Grasp grasp;
    const double x = rng.Uniform(-0.02, 0.02), y = rng.Uniform(-0.02, 0.02);
    const double z = rng.Uniform(min_z_m, max_z_m);
    grasp.X_WG = FromAbove({x, y, z}, rng.Uniform(0, std::numbers::pi));
    grasp.width_m = 0.05;
    labels.push_back(Label(ExecuteGrasp(scene, boxes, grasp, gripper, InstanceId{10}).outcome));
  }
  return labels;
}

TEST(GraspLabels, RepeatExactlyInASecondRun) {
  const auto cup = LoadGripper("cup_30mm");
  const ParallelJaw jaw = SmallJaw();
  struct Sample {
    const Gripper& gripper;
    double min_z_m, max_z_m;
    int count;
  };
  for (const auto& [gripper, min_z_m, max_z_m, count] :
       {Sample{jaw, 0.005, 0.03, 400}, Sample{*cup, 0.036, 0.041, 100}}) {
    const auto first = LabelsOfSampledGrasps(gripper, min_z_m, max_z_m, count);
    EXPECT_EQ(first, LabelsOfSampledGrasps(gripper, min_z_m, max_z_m, count)) << gripper.name;
    const auto held = std::count_if(first.begin(), first.end(),
                                    [](const std::vector<double>& label) { return label[0] > 0; });
    EXPECT_GT(held, count / 20) << gripper.name;
    EXPECT_LT(held, count - count / 20) << gripper.name;
  }
}

}  // namespace
}  // namespace pickbed::tests
