#include "grasp/gripper.h"

namespace pickbed::grasp {

void Gripper::Visit(SettingsVisitor& v) {
  VisitOwn(v);
  v.Real("approach_m", approach_m, {0.01, 1},
         "length of the straight approach before the grasp, m");
  v.Real("clearance_m", clearance_m, {0, 0.05},
         "distance between the hand and all other bodies, m");
}

void Gripper::Validate(const std::string&) const {}

void Gripper::Check() const {
  // Visit() is not const because readers set the values. The check only reads them.
  CheckSettings("gripper " + name,
                [this](SettingsVisitor& v) { const_cast<Gripper*>(this)->Visit(v); });
  Validate("gripper " + name);
}

std::string Gripper::SettingsText() const { return WriteText({}, false); }

std::string Gripper::SettingsHelp(const std::vector<std::string>& mechanisms) const {
  return WriteText(mechanisms, true);
}

std::string Gripper::WriteText(const std::vector<std::string>& mechanisms, bool with_help) const {
  const auto visit = [&](SettingsVisitor& v) {
    std::string own = mechanism();
    v.Text("mechanism", own, mechanisms, "mechanism of the hand");
    // Visit() is not const because readers set the values. A writer only reads them.
    const_cast<Gripper*>(this)->Visit(v);
  };
  return WriteSettings(visit, with_help);
}

std::vector<AxisAlignedBox> Gripper::SoftBoxes() const { return {}; }

std::optional<AxisAlignedBox> Gripper::RegionBetween(double) const { return std::nullopt; }

double Gripper::MaxAside_m() const { return 0; }

bool Gripper::PullsAside() const { return false; }

double Gripper::WeightShare(const ObjectModel&, const Pose&, const Eigen::Vector3d&) const {
  return 0;
}

}  // namespace pickbed::grasp
