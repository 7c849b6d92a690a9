#pragma once

// Grasp candidates of a part for any gripper, with every quality, made once and kept on disk.

#include <vector>

#include "grasp/antipodal.h"
#include "grasp/place.h"
#include "grasp/robust.h"
#include "grasp/suction_candidates.h"

namespace pickbed {

struct GraspCandidateOptions {
  AntipodalOptions antipodal = {};  // jaws
  SuctionOptions suction = {};      // cups
  RobustOptions robust = {};
  PlaceOptions place = {};
  void Visit(SettingsVisitor& v);
};

// As the gripper's mechanism makes them. Empty when the gripper cannot hold the part: a result, not
// an error.
std::vector<GraspCandidate> MakeCandidates(const ObjectModel& model, const GripperSpec& gripper,
                                           Rng& rng, const GraspCandidateOptions& options = {});

// The same from the cache, keyed by what the part is (mesh, mass, friction, symmetries, convex
// pieces, how it rests), the gripper and the options; made and stored when missing. Same inputs,
// same candidates, with or without a cache.
std::vector<GraspCandidate> CachedCandidates(const ObjectModel& model, const GripperSpec& gripper,
                                             const GraspCandidateOptions& options = {});

}  // namespace pickbed
