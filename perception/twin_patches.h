#pragma once

// Training pairs: a patch from a pile and its twin, cut from the same part alone at nearly the same
// place, from nearly the same direction and at nearly the same in-plane angle. The pile shows what
// a query looks like, clutter included; the twin what a code book entry near its pose looks like.

#include <vector>

#include "perception/labelled_patches.h"

namespace pickbed {

struct TwinOptions {
  int patches_per_view = 200;  // of a pile view, about
  double min_visible = 0.1;    // visible fraction of an instance to learn from
  int twins_per_instance = 3;  // isolated views of each instance of a pile view
  // How far the twin's pose lies off, as the nearest entry of a code book does: sigmas.
  double turn_rad = 0.08;     // of the part about a random axis
  double in_plane_rad = 0.1;  // of the patch about the viewing ray
  double shift_px = 1.5;      // of the patch's pixel, each axis
  void Visit(SettingsVisitor& v);
};

// Row i of both belongs together.
struct PatchPairs {
  LabelledPatches anchors;  // from piles
  LabelledPatches codes;    // from isolated views
  size_t size() const { return anchors.size(); }
};

// Pairs of all views of one pile, in equal parts from every instance seen well enough, appended to
// by_object[its object]. forms: of the patches, by object. Where the twin shows another side of the
// part at the anchor's place there is no pair.
void AppendTwinPatches(LabelledViewSource& source, const std::vector<LabelledView>& pile,
                       const std::vector<PatchForm>& forms, const TwinOptions& options, Rng& rng,
                       std::vector<PatchPairs>& by_object);

}  // namespace pickbed
