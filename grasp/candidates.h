#pragma once

// Grasp candidates of a part for any gripper, with every quality, made once and kept on disk.

#include <span>
#include <vector>

#include "grasp/antipodal.h"
#include "grasp/robust.h"
#include "grasp/suction_candidates.h"

namespace pickbed {

struct GraspCandidateOptions {
  AntipodalOptions antipodal = {};  // jaws
  SuctionOptions suction = {};      // cups
  RobustOptions robust = {};
  void Visit(SettingsVisitor& v);
};

// How candidates for a mechanism (a row of MechanismTable) are found.
struct CandidateMaker {
  const char* mechanism;
  const char* needs;  // what a part must have to be held so, in words
  std::vector<GraspCandidate> (*make)(const ObjectModel& model, const GripperSpec& gripper,
                                      Rng& rng, const GraspCandidateOptions& options);
};
std::span<const CandidateMaker> CandidateMakerTable();

// Throws InputError for a mechanism that no row is for.
const CandidateMaker& CandidateMakerOf(const GripperSpec& gripper);

// Empty when the gripper cannot hold the part: a result, not an error.
std::vector<GraspCandidate> MakeCandidates(const ObjectModel& model, const GripperSpec& gripper,
                                           Rng& rng, const GraspCandidateOptions& options = {});

// The same from the cache, keyed by what the part is (mesh, mass, friction), the gripper and the
// options; made and stored when missing. Same inputs, same candidates, with or without a cache.
std::vector<GraspCandidate> CachedCandidates(const ObjectModel& model, const GripperSpec& gripper,
                                             const GraspCandidateOptions& options = {});

}  // namespace pickbed
