#pragma once

// The grippers among which a robot changes.

#include <memory>
#include <string>
#include <vector>

#include "grasp/candidates/candidates.h"
#include "grasp/gripper.h"

namespace pickbed::grasp {

// At least one gripper; the first one stirs the bin.
using Tools = std::vector<std::shared_ptr<const Gripper>>;

// Reads the grippers with LoadGripper(). Throws InputError as it does, and if two have one name.
Tools LoadTools(const std::vector<std::string>& names_or_paths);

// Returns the tool with this name; the first one for an empty name, as in records of earlier
// versions. Throws InputError if there is none.
const Gripper& ToolNamed(const Tools& tools, const std::string& name);

// The candidates of all tools for one object, and the tools that cannot hold it.
struct ToolCandidates {
  std::vector<std::vector<GraspCandidate>> by_tool;  // empty for a tool that cannot hold the object
  std::vector<std::string> unfit;                    // names of these tools
};

// Returns the candidates of each tool. Throws the InputError of RequireCandidates() if there is one
// tool, and an InputError that names the object and all tools if none of several can hold it.
ToolCandidates RequireToolCandidates(const ObjectModel& object, const Tools& tools,
                                     const GraspCandidateOptions& options = {});

// Returns a line for each tool that cannot hold one of the objects: "PLACE: cup_30mm cannot hold
// 'ring'; other grippers pick it\n". Empty for one tool. `place`: file, line and key of the
// setting. The objects must have convex pieces and resting directions.
std::string UnfitToolsText(const ObjectSet& objects, const Tools& tools, const std::string& place);

// At least one of the tools must be able to carry the object. Throws InputError with the weight and
// what each tool carries.
void RequireSomeToolCarries(const Tools& tools, const ObjectModel& object);

}  // namespace pickbed::grasp
