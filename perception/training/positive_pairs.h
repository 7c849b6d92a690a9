#pragma once

// Positive training pairs: a patch from a clutter scene and a patch of the isolated object. Both
// have nearly the same surface point, viewing direction and in-plane angle. The first is like a
// query, with clutter. The second is like a codebook entry with nearly the same pose.

#include <vector>

#include "perception/features/labelled_patches.h"

namespace pickbed::perception {

struct PositivePairOptions {
  int patches_per_view = 200;  // approximate number of pairs per view of a clutter scene
  double min_visible = 0.1;    // minimum visible fraction of a training instance
  int pairs_per_instance = 3;  // isolated views per instance in a view
  // Standard deviations of the pose difference of a pair. They simulate the distance to the nearest
  // codebook entry.
  double rotation_rad = 0.08;  // rotation of the object about a random axis
  double in_plane_rad = 0.1;   // rotation of the patch about the viewing ray
  double shift_px = 1.5;       // shift of the patch's pixel along each axis
  void Visit(SettingsVisitor& v);
};

// Pairs of patches; rows i of both sets are a pair.
struct PatchPairs {
  LabelledPatches anchors;  // from clutter scenes
  LabelledPatches codes;    // from isolated views
  size_t size() const { return anchors.size(); }
};

// Makes pairs from all views of one clutter scene and appends them to by_object[object]. All
// sufficiently visible instances contribute equally. `forms` is by object. A pair is dropped if the
// isolated view shows another surface point at the anchor's position.
void AppendPositivePatches(LabelledViewSource& source,
                           const std::vector<LabelledView>& clutter_scene,
                           const std::vector<PatchForm>& forms, const PositivePairOptions& options,
                           Rng& rng, std::vector<PatchPairs>& by_object);

}  // namespace pickbed::perception
