#pragma once

// Patches whose pose is known, and those of isolated views, of which code books are made.

#include <functional>
#include <span>
#include <vector>

#include "perception/patch.h"
#include "scenes/labelled_view.h"
#include "scenes/settings.h"

namespace pickbed {

struct LabelledPatches {
  std::vector<int8_t> values;  // count x 4 x 32 x 32, see patch.h
  std::vector<Pose> X_PO;      // the part in the frame of each patch
  size_t size() const { return X_PO.size(); }
  std::span<const int8_t> patch(size_t i) const {
    return {values.data() + i * kPatchValues, static_cast<size_t>(kPatchValues)};
  }
};

struct IsolatedOptions {
  int views = 3000;
  int patches_per_view = 8;
  double distance_m = 0.85;      // camera to part
  double distance_spread = 0.1;  // views lie within distance_m * (1 -+ spread)
  double focal_px = 680;
  void Visit(SettingsVisitor& v);
};

// A camera of the given focal length whose image just holds a sphere of this diameter.
CameraIntrinsics CropCamera(double diameter_m, const IsolatedOptions& options);

// Calls take(patches of a block of views) until all views are done: uniform rotations, uniform
// in-plane angles, uniform pixels of the part. share = done so far, 0..1; take returns false to
// stop.
void ForEachIsolatedBlock(LabelledViewSource& views, int object, const PatchForm& form,
                          const IsolatedOptions& options, uint64_t seed,
                          const std::function<bool(LabelledPatches patches, double share)>& take);

// Cuts the patches and labels them with the part's pose.
void AppendPatches(const OrganizedCloud& cloud, std::span<const int> pixels,
                   std::span<const double> angles_rad, const PatchForm& form, const Pose& X_CO,
                   LabelledPatches& patches);

// Patches that are cut already, one or all.
void AppendPatch(const LabelledPatches& from, size_t row, LabelledPatches& to);
void AppendAll(const LabelledPatches& from, LabelledPatches& to);

// The cloud of a view without background: no plane is taken for a table.
OrganizedCloud IsolatedCloud(const LabelledView& view);

// Foreground pixels by instance of the view.
std::vector<std::vector<int>> PixelsByInstance(const LabelledView& view,
                                               const OrganizedCloud& cloud);

}  // namespace pickbed
