#pragma once

// Grasp candidates for a command that is no use without one.

#include <vector>

#include "grasp/candidates.h"

namespace pickbed {

// Candidates from the cache. Where there are none, throws InputError that says what the part lacks
// and which of the grippers that come with the program can hold it.
std::vector<GraspCandidate> RequireCandidates(const ObjectModel& part, const GripperSpec& gripper,
                                              const GraspCandidateOptions& options = {});

}  // namespace pickbed
