#pragma once

// Pictures of completions: input, completion and truth.

#include <string>
#include <vector>

#include "eval/layer.h"
#include "perception/completion/completed_volume.h"
#include "perception/completion/random_view.h"
#include "scenes/image/image.h"

namespace pickbed::eval {

// Returns the truth on the cells of another volume: 1 inside the solid, else 0.
CompletedVolume TrueVolume(const ViewedSolid& solid, const RandomView& drawn,
                           const CompletedVolume& cells);

// Draws the surface at `level` as seen along +z (from the camera) or along -x, shaded by its
// normal. Pixels without a surface are white.
Image<Rgb8> DrawVolume(const CompletedVolume& volume, float level, bool from_side, int size_px);

struct CompletionTile {
  std::string caption;
  SegmentView view;
  CompletedVolume completed;
  CompletedVolume truth;
};
// Draws a line of pictures for each: depth, completion from the camera and from the side, truth
// from the camera and from the side. Cells of a completion above `fixed_level` are full; 0 =
// perception::LevelForIou() of each.
Image<Rgb8> DrawCompletions(const std::vector<CompletionTile>& tiles, float fixed_level = 0);

}  // namespace pickbed::eval
