#pragma once

// Grasp candidates of an object for any gripper, with all quality measures, computed once and
// cached on disk.

#include <functional>
#include <vector>

#include "grasp/candidates/antipodal.h"
#include "grasp/candidates/robustness.h"
#include "grasp/candidates/suction.h"
#include "grasp/grasp.h"
#include "grasp/gripper.h"
#include "grasp/place/placement.h"

namespace pickbed::grasp {

// Options of all candidate generators and quality measures.
struct GraspCandidateOptions {
  AntipodalOptions antipodal = {};  // for jaws
  SuctionOptions suction = {};      // for suction cups
  RobustOptions robust = {};
  PlaceOptions place = {};
  void Visit(SettingsVisitor& v);
};

// Computes the candidates of Gripper::MakeCandidates() and sets `place_quality`, so that all
// quality measures are set. Returns an empty list if the gripper cannot hold the object; this is
// not an error.
std::vector<GraspCandidate> MakeCandidates(const ObjectModel& model, const Gripper& gripper,
                                           Rng& rng, const GraspCandidateOptions& options = {});

// Like MakeCandidates, but reads from the cache and fills it if necessary. The key is the object
// (mesh, mass, friction, symmetries, convex pieces, resting directions), the gripper and the
// options. Equal inputs give equal candidates, with or without a cache.
std::vector<GraspCandidate> CachedCandidates(const ObjectModel& model, const Gripper& gripper,
                                             const GraspCandidateOptions& options = {});

// Selects up to `wanted` candidates: the best of each approach direction in turn. So some
// candidates approach from above however the object rests. Among candidates that are the `same`,
// only the best is kept.
std::vector<GraspCandidate> SpreadOverDirections(
    std::vector<GraspCandidate> all, int wanted,
    const std::function<bool(const GraspCandidate&, const GraspCandidate&)>& same);

}  // namespace pickbed::grasp
