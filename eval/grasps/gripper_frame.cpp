#include "eval/grasps/gripper_frame.h"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <filesystem>

#include "scenes/base/error.h"

namespace pickbed::eval {
namespace {

const std::vector<std::string> kHandAxes{"x", "-x", "y", "-y", "z", "-z"};

Eigen::Vector3d AxisNamed(const std::string& name) {
  const bool is_negative = name.starts_with('-');
  return (is_negative ? -1 : 1) * Eigen::Vector3d::Unit(name.back() - 'x');
}

}  // namespace

void GripperFrame::Visit(SettingsVisitor& v) {
  v.Text("approach", approach, kHandAxes, "axis of the frame in the approach direction");
  v.Text("closing", closing, kHandAxes, "axis of the frame in the closing direction");
  v.Vector3("tip_m", tip_m, {-2, 2}, "point between the fingertips in the frame, m");
}

Pose GripperFrame::X_FG() const {
  const Eigen::Vector3d z = AxisNamed(approach), x = AxisNamed(closing);
  CheckInput(
      std::abs(z.dot(x)) < 0.5,
      fmt::format("closing = {}: must be another axis than approach = {}", closing, approach));
  Eigen::Matrix3d R_FG;
  R_FG << x, z.cross(x), z;
  return MakePose(R_FG, tip_m);
}

std::span<const GripperFrameRow> GripperFrameTable() {
  static const std::array<GripperFrameRow, 2> rows{{
      {"tips", "between the fingertips, z approach, x closing: the frame of pickbed", {}},
      {"panda_hand",
       "hand of the Franka Panda: z approach, y closing, fingertips at z = 103.4 mm",
       {"z", "y", {0, 0, 0.1034}}},
  }};
  return rows;
}

GripperFrame LoadGripperFrame(const std::string& name_or_path) {
  std::vector<std::string> names;
  for (const GripperFrameRow& row : GripperFrameTable()) {
    if (name_or_path == row.name) return row.frame;
    names.push_back(row.name);
  }
  const std::filesystem::path file = name_or_path;
  if (file.extension() != ".yaml") {
    throw InputError(UnknownNameMessage("gripper frame", name_or_path, names) +
                     " (or a .yaml file with approach, closing and tip_m)");
  }
  GripperFrame frame;
  ReadSettingsFile(file, [&](SettingsVisitor& v) { frame.Visit(v); });
  try {
    frame.X_FG();
  } catch (const InputError& error) {
    throw InputError(name_or_path + ": " + error.what());
  }
  return frame;
}

}  // namespace pickbed::eval
