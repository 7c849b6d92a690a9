#include "grasp/planners/table.h"

#include <array>
#include <vector>

#include "grasp/cloud/cloud_antipodal.h"
#include "grasp/cloud/cloud_suction.h"
#include "grasp/completed/completed_planner.h"
#include "grasp/planners/pose_planner.h"
#include "grasp/planners/program_planner.h"
#include "scenes/base/error.h"

namespace pickbed::grasp {
namespace {

template <typename T>
std::unique_ptr<Planner> Make(const PlannerSetup& setup) {
  return std::make_unique<T>(setup);
}

template <bool kGivesPoses>
std::unique_ptr<Planner> MakeProgram(const PlannerSetup& setup) {
  return std::make_unique<ProgramPlanner>(setup, kGivesPoses);
}

constexpr std::array<PlannerRow, 7> kPlanners{{
    {kPosePlanner, "grasp candidates of the known objects at their estimated poses", true,
     Make<PosePlanner>},
    {"cloud_antipodal", "opposing faces of the observed surface, without poses and object models",
     false, Make<CloudAntipodal>},
    {"cloud_suction", "flat places of the observed surface, for suction cups", false,
     Make<CloudSuction>},
    {"completed", "completed shapes of unknown objects, without poses and object models", false,
     Make<CompletedPlanner>, true},
    {"skirt", "like completed, with the seen surface and 15 mm behind it as the shape", false,
     Make<CompletedPlanner>, true, "skirt"},
    {"process", "another program, which works on the image (planner.command or planner.connect)",
     false, MakeProgram<false>},
    {"process_poses", "another program, which works on the image and the estimated poses", true,
     MakeProgram<true>},
}};

}  // namespace

std::span<const PlannerRow> PlannerTable() { return kPlanners; }

const PlannerRow& PlannerNamed(const std::string& name) {
  std::vector<std::string> names;
  for (const PlannerRow& row : kPlanners) {
    if (name == row.name) return row;
    names.push_back(row.name);
  }
  throw InputError(UnknownNameMessage("planner", name, names));
}

}  // namespace pickbed::grasp
