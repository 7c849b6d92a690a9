#pragma once

// What entries of a code book look like: their patches are not kept, so they are rendered again.

#include <array>
#include <optional>
#include <vector>

#include "perception/patch.h"
#include "scenes/labelled_view.h"

namespace pickbed {

struct EntryPose {
  int object = 0;
  PatchForm form;
  Pose X_PO = Pose::Identity();
};

// The part alone, seen along the patch's viewing ray from distance_m by a camera of focal_px with
// the source's noise; nothing where the middle has no reading.
std::vector<std::optional<std::array<int8_t, kPatchValues>>> EntryPatches(
    LabelledViewSource& views, const std::vector<EntryPose>& entries, double distance_m,
    double focal_px);

}  // namespace pickbed
