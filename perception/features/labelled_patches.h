#pragma once

// Patches with a known object pose, and patches of isolated views from which codebooks are made.

#include <functional>
#include <span>
#include <vector>

#include "perception/features/patch.h"
#include "scenes/base/ids.h"
#include "scenes/base/settings.h"
#include "scenes/labelled_view.h"

namespace pickbed::perception {

// Patches with the object pose in each patch frame.
struct LabelledPatches {
  std::vector<int8_t> values;  // count x 4 x 32 x 32, see patch.h
  std::vector<Pose> X_PO;      // object pose in the frame of each patch
  size_t size() const { return X_PO.size(); }
  std::span<const int8_t> patch(size_t i) const {
    return {values.data() + i * kPatchValues, static_cast<size_t>(kPatchValues)};
  }
};

// Views of an isolated object from which patches are cut.
struct IsolatedOptions {
  int views = 3000;
  int patches_per_view = 8;
  double distance_m = 0.85;      // camera to object
  double distance_spread = 0.1;  // distances are uniform in distance_m * (1 -+ spread)
  double focal_px = 680;
  void Visit(SettingsVisitor& v);
};

// Returns a camera with the given focal length whose image just contains a sphere of this diameter
// at the smallest distance.
CameraIntrinsics CropCamera(double diameter_m, const IsolatedOptions& options);

// Renders isolated views of the object in blocks and calls `take` with the patches of each block.
// Rotations, in-plane angles and pixels of the object are uniform. `share` is the progress, 0..1;
// `take` returns false to stop.
void ForEachIsolatedBlock(LabelledViewSource& views, ObjectId object, const PatchForm& form,
                          const IsolatedOptions& options, uint64_t seed,
                          const std::function<bool(LabelledPatches patches, double share)>& take);

// Cuts patches at the pixels, labels them with the object pose X_CO and appends them.
void AppendPatches(const OrganizedCloud& cloud, std::span<const int> pixels,
                   std::span<const double> angles_rad, const PatchForm& form, const Pose& X_CO,
                   LabelledPatches& patches);

// Appends the patch `row` of another set.
void AppendPatch(const LabelledPatches& from, size_t row, LabelledPatches& to);
// Appends all patches of another set.
void AppendAll(const LabelledPatches& from, LabelledPatches& to);

// Builds the cloud of a view without background; no plane is removed as a table.
OrganizedCloud IsolatedCloud(const LabelledView& view);

// Returns the foreground pixel indices of each instance of the view.
std::vector<std::vector<int>> PixelsByInstance(const LabelledView& view,
                                               const OrganizedCloud& cloud);

}  // namespace pickbed::perception
