#include "grasp/grippers/tools.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <map>
#include <string>
#include <vector>

#include "grasp/grippers/requirements.h"
#include "grasp/grippers/table.h"
#include "scenes/base/error.h"
#include "scenes/objects/contact.h"

namespace pickbed::grasp {
namespace {

bool Carries(const Gripper& gripper, const ObjectModel& object) {
  return CanCarry(gripper, object.mass.mass_kg, object.friction);
}

std::vector<std::string> NamesOfTools(const Tools& tools) {
  std::vector<std::string> names;
  for (const auto& tool : tools) names.push_back(tool->name);
  return names;
}

}  // namespace

Tools LoadTools(const std::vector<std::string>& names_or_paths) {
  Tools tools;
  for (const std::string& name : names_or_paths) {
    tools.push_back(LoadGripper(name));
    const bool is_new = std::none_of(tools.begin(), tools.end() - 1, [&](const auto& tool) {
      return tool->name == tools.back()->name;
    });
    CheckInput(is_new,
               fmt::format("two grippers are named {}; remove or rename one", tools.back()->name));
  }
  return tools;
}

const Gripper& ToolNamed(const Tools& tools, const std::string& name) {
  if (name.empty()) return *tools.at(0);
  for (const auto& tool : tools) {
    if (tool->name == name) return *tool;
  }
  throw InputError(UnknownNameMessage("gripper", name, NamesOfTools(tools)));
}

ToolCandidates RequireToolCandidates(const ObjectModel& object, const Tools& tools,
                                     const GraspCandidateOptions& options) {
  if (tools.size() == 1) return {{RequireCandidates(object, *tools.front(), options)}, {}};
  ToolCandidates result;
  for (const auto& tool : tools) {
    result.by_tool.emplace_back();
    if (Carries(*tool, object)) result.by_tool.back() = CachedCandidates(object, *tool, options);
    if (result.by_tool.back().empty()) result.unfit.push_back(tool->name);
  }
  CheckInput(
      result.unfit.size() < tools.size(),
      fmt::format("object '{}' can be held by none of the grippers {}; compare grippers with "
                  "`pickbed grasps {} GRIPPER`",
                  object.name, fmt::join(result.unfit, ", "), object.name));
  return result;
}

std::string UnfitToolsText(const ObjectSet& objects, const Tools& tools, const std::string& place) {
  if (tools.size() == 1) return {};
  std::map<std::string, std::vector<std::string>> unheld;  // objects by tool
  for (const auto& object : objects) {
    for (const std::string& tool : RequireToolCandidates(*object, tools).unfit) {
      unheld[tool].push_back("'" + object->name + "'");
    }
  }
  std::string text;
  for (const auto& [tool, names] : unheld) {
    text += fmt::format("{}: {} cannot hold {}; other grippers pick {}\n", place, tool,
                        fmt::join(names, ", "), names.size() == 1 ? "it" : "them");
  }
  return text;
}

void RequireSomeToolCarries(const Tools& tools, const ObjectModel& object) {
  const bool any = std::any_of(tools.begin(), tools.end(),
                               [&](const auto& tool) { return Carries(*tool, object); });
  if (any) return;
  if (tools.size() == 1) return RequireCanCarry(*tools.front(), object);
  std::string offers;
  for (const auto& tool : tools) {
    offers += fmt::format("{}{} carries {:.3g} N", offers.empty() ? "" : ", ", tool->name,
                          tool->Capacity_n(object.friction));
  }
  throw InputError(fmt::format(
      "object '{}' is too heavy for all grippers: it weighs {:.3g} kg, {:.3g} N, and of it {}; use "
      "a stronger gripper",
      object.name, object.mass.mass_kg, object.mass.mass_kg * kGravity_mps2, offers));
}

}  // namespace pickbed::grasp
