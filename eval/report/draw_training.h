#pragma once

// Pictures of what a descriptor network learned from and what it finds.

#include <span>
#include <string>
#include <vector>

#include "perception/held_out.h"
#include "scenes/image.h"
#include "scenes/object_model.h"

namespace pickbed {

// A patch of patch.h, `zoom` pixels a pixel: normals as colours (facing the camera = light blue),
// darker the farther, or its own colours; background dark, surface without a normal grey.
Image<Rgb8> DrawPatch(std::span<const int8_t> patch, PatchChannels channels, int zoom);

// Pairs that were learned from, side by side: from a pile, from the isolated view; `per_part` of
// each part at most.
Image<Rgb8> DrawPairs(const std::vector<PatchPairs>& pairs, PatchChannels channels,
                      const ObjectSet& objects, int per_part);

// Query, found, true; `count` at most, of right and of wrong answers half each where there are
// enough, spread over the parts.
Image<Rgb8> DrawAnswers(const std::vector<HeldOutAnswer>& answers, const HeldOutSet& set,
                        PatchChannels channels, const ObjectSet& objects, int count);

// Descriptors along their first two principal axes, a dot a query: coloured by part or, of one
// part, by the side that is seen (x, y, z of the viewing direction as red, green, blue).
Image<Rgb8> DrawEmbedding(const std::vector<HeldOutAnswer>& answers, const ObjectSet& objects,
                          int width, int height);

// count x 2 coordinates of `rows` (count x length) about their mean along the directions of the
// largest variance, largest first.
Eigen::MatrixX2f PrincipalCoordinates(const Eigen::MatrixXf& rows);

}  // namespace pickbed
