#pragma once

// What the two pads of a jaw can put on a part: where they touch, as friction cones on the rim of
// each patch.
//
// A pad pushes with up to its full force anywhere on its patch. A patch that is pressed evenly
// resists a turn about its normal with friction times force times the mean distance from its
// middle (Howe and Cutkosky 1996), so the rim is drawn in to that distance: force spread over the
// drawn-in rim then resists as much.

#include <optional>

#include "grasp/grasp.h"
#include "grasp/pad_contact.h"
#include "grasp/robust.h"
#include "grasp/wrench_space.h"

namespace pickbed {

struct JawHold {
  const ObjectModel& model;
  const GripperSpec& gripper;
  const SurfacePoints& surface;
  const RobustOptions& options;

  // Pads at X_OG that close from `opening_m`; nothing when the open hand hits the part on its way
  // or a pad meets no surface that faces it.
  std::optional<WrenchSet> At(const Pose& X_OG, double opening_m, double friction_factor) const;
};

// Up to 8 points of a patch's rim, drawn in as said above; in G.
std::vector<Eigen::Vector3d> RimPoints(const PadPatch& patch);

// Sets epsilon and robust of each candidate.
void JudgeJawGrasps(const ObjectModel& model, const GripperSpec& gripper,
                    const SurfacePoints& surface, const RobustOptions& options, uint64_t seed,
                    std::vector<GraspCandidate>& candidates);

}  // namespace pickbed
