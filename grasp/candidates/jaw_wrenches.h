#pragma once

// Wrenches that the two pads of a jaw can exert on an object, modelled as friction cones on the rim
// of each contact patch.
//
// A pad can push with up to its full force anywhere on its patch. A uniformly pressed patch resists
// rotation about its normal with friction times force times the mean distance from its center (Howe
// and Cutkosky 1996). So the rim is contracted to that mean distance; force on the contracted rim
// then has the same resistance.

#include <optional>

#include "grasp/candidates/pad_contact.h"
#include "grasp/candidates/robustness.h"
#include "grasp/candidates/wrench_space.h"
#include "grasp/grasp.h"

namespace pickbed::grasp {

// Evaluates the contact wrenches of a jaw; keeps references to its members.
struct JawHold {
  const ObjectModel& model;
  const HandSpec& hand;
  const SurfacePoints& surface;
  const RobustOptions& options;

  // Wrenches of pads that close from `opening_m` at X_OG. Returns nullopt if the open hand hits the
  // object on its approach, or if a pad meets no surface that faces it.
  std::optional<WrenchSet> At(const Pose& X_OG, double opening_m, double friction_factor) const;
};

// Up to 8 points of the rim of a patch in G, contracted as described above.
std::vector<Eigen::Vector3d> RimPoints(const PadPatch& patch);

// Sets epsilon of each candidate, rounded down by at most the tolerance of `depth`. `clearance_m`:
// see AntipodalGrasps. Candidates beyond the stroke are left unchanged.
void SetJawEpsilon(const ObjectModel& model, const HandSpec& hand, double clearance_m,
                   const SurfacePoints& surface, const RobustOptions& options,
                   std::vector<GraspCandidate>& candidates, const WrenchDepthOptions& depth = {});

// Sets epsilon and robust of each candidate in the same way.
void JudgeJawGrasps(const ObjectModel& model, const HandSpec& hand, double clearance_m,
                    const SurfacePoints& surface, const RobustOptions& options, uint64_t seed,
                    std::vector<GraspCandidate>& candidates);

}  // namespace pickbed::grasp
