#pragma once

// Pictures of the training pairs of a descriptor network, of its answers and of its descriptors.

#include <span>
#include <string>
#include <vector>

#include "eval/layer.h"
#include "perception/training/held_out.h"
#include "scenes/image/image.h"
#include "scenes/objects/object_model.h"

namespace pickbed::eval {

// Draws a patch (patch.h), enlarged `zoom` times. Normals are colors (facing the camera = light
// blue), darker with distance; or the patch has its own colors. The background is dark, a surface
// without a normal is gray.
Image<Rgb8> DrawPatch(std::span<const int8_t> patch, PatchChannels channels, int zoom);

// Draws positive training pairs side by side: patch of a clutter scene, patch of the isolated view;
// at most `per_object` per object.
Image<Rgb8> DrawPairs(const std::vector<PatchPairs>& pairs, PatchChannels channels,
                      const ObjectSet& objects, int per_object);

// Draws at most `count` answers as query, found and true patch. Half are right and half wrong, if
// there are enough. They are spread over the objects.
Image<Rgb8> DrawAnswers(const std::vector<HeldOutAnswer>& answers, const HeldOutSet& set,
                        PatchChannels channels, const ObjectSet& objects, int count);

// Draws the descriptors along their first two principal axes, one dot per query. Dots are colored
// by object. With one object, the color is the viewing direction (x, y, z as red, green, blue).
Image<Rgb8> DrawEmbedding(const std::vector<HeldOutAnswer>& answers, const ObjectSet& objects,
                          int width, int height);

// Returns the coordinates (count x 2) of `rows` (count x length) relative to their mean, along the
// two directions of largest variance, largest first.
Eigen::MatrixX2f PrincipalCoordinates(const Eigen::MatrixXf& rows);

}  // namespace pickbed::eval
