#pragma once

// Renders the patches of codebook entries. The codebook does not store the patches themselves.

#include <array>
#include <optional>
#include <vector>

#include "eval/layer.h"
#include "perception/features/patch.h"
#include "scenes/base/ids.h"
#include "scenes/labelled_view.h"

namespace pickbed::eval {

// Codebook entry: an object, and its pose in the patch frame P.
struct EntryPose {
  ObjectId object{0};
  PatchForm form;
  Pose X_PO = Pose::Identity();
};

// Renders a single object for each entry and cuts its patch. The camera looks along the viewing ray
// of the patch from `distance_m`, with focal length `focal_px` and the sensor noise of `views`.
// Returns one patch per entry, nullopt if the patch center has no depth reading.
std::vector<std::optional<std::array<int8_t, kPatchValues>>> EntryPatches(
    LabelledViewSource& views, const std::vector<EntryPose>& entries, double distance_m,
    double focal_px);

}  // namespace pickbed::eval
