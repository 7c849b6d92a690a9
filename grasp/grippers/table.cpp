#include "grasp/grippers/table.h"

#include <algorithm>
#include <array>
#include <filesystem>

#include "grasp/grippers/parallel_jaw.h"
#include "grasp/grippers/suction_cup.h"
#include "scenes/base/error.h"
#include "scenes/objects/object_catalog.h"

namespace pickbed::grasp {
namespace {

template <typename Mechanism>
std::unique_ptr<Gripper> Make() {
  return std::make_unique<Mechanism>();
}

constexpr std::array<GripperRow, 2> kGrippers{{
    {ParallelJaw::kMechanism, "two coupled fingers on a slider with a force limit",
     Make<ParallelJaw>},
    {SuctionCup::kMechanism,
     "a bellows whose lip seals on an object until pull or moment breaks the seal",
     Make<SuctionCup>},
}};

std::filesystem::path GripperFile(const std::string& name_or_path) {
  if (std::filesystem::path(name_or_path).extension() == ".yaml") return name_or_path;
  const std::vector<std::string> names = GripperNames();
  CheckInput(std::find(names.begin(), names.end(), name_or_path) != names.end(),
             UnknownNameMessage("gripper", name_or_path, names));
  return AssetsDir() / "grippers" / (name_or_path + ".yaml");
}

}  // namespace

std::span<const GripperRow> GripperTable() { return kGrippers; }

std::vector<std::string> MechanismNames(std::span<const GripperRow> rows) {
  std::vector<std::string> names;
  for (const GripperRow& row : rows) names.push_back(row.name);
  return names;
}

std::shared_ptr<const Gripper> LoadGripper(const std::string& name_or_path,
                                           std::span<const GripperRow> rows) {
  const std::filesystem::path file = GripperFile(name_or_path);
  std::unique_ptr<Gripper> gripper;
  ReadSettingsFile(file, [&](SettingsVisitor& v) {
    std::string mechanism = rows.front().name;
    v.Text("mechanism", mechanism, MechanismNames(rows), "mechanism of the hand");
    const auto row = std::find_if(rows.begin(), rows.end(),
                                  [&](const GripperRow& known) { return mechanism == known.name; });
    gripper = row->make();
    gripper->Visit(v);
  });
  gripper->name = file.stem().string();
  gripper->Validate(file.string());
  return gripper;
}

std::vector<std::string> GripperNames() { return StemsIn(AssetsDir() / "grippers", ".yaml"); }

}  // namespace pickbed::grasp
