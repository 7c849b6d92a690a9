#include "grasp/require_candidates.h"

#include <fmt/format.h>

#include "scenes/check.h"

namespace pickbed {
namespace {

// "cup_30mm has 12, jaw_14cm has 200"; empty when no other gripper has any.
std::string Offers(const ObjectModel& part, const std::string& without,
                   const GraspCandidateOptions& options) {
  std::string offers;
  for (const std::string& name : GripperNames()) {
    if (name == without) continue;
    const size_t count = CachedCandidates(part, LoadGripper(name), options).size();
    if (count > 0) offers += fmt::format("{}{} has {}", offers.empty() ? "" : ", ", name, count);
  }
  return offers;
}

}  // namespace

std::vector<GraspCandidate> RequireCandidates(const ObjectModel& part, const GripperSpec& gripper,
                                              const GraspCandidateOptions& options) {
  auto candidates = CachedCandidates(part, gripper, options);
  if (!candidates.empty()) return candidates;
  const std::string offers = Offers(part, gripper.name, options);
  throw InputError(fmt::format(
      "part '{}' has no {} for gripper '{}', {}", part.name, MechanismOf(gripper).needs,
      gripper.name,
      offers.empty() ? "and no other gripper that comes with the program can hold it"
                     : fmt::format("but {}: pickbed grasps {} GRIPPER", offers, part.name)));
}

}  // namespace pickbed
