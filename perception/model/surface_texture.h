#pragma once

// Surface texture of an object, for example a label or a printed side. With a color camera it
// distinguishes the object from a distractor of the same shape, which depth cannot.

#include <Eigen/Core>
#include <optional>
#include <span>
#include <vector>

#include "perception/cloud/organized_cloud.h"
#include "scenes/geometry/triangle_mesh.h"
#include "scenes/objects/object_model.h"

namespace pickbed::perception {

struct ModelPoints;

// Colors of an object's model points.
struct SurfaceTexture {
  std::vector<Eigen::Vector3f> colors;  // of ModelPoints::points_O, 0..255; empty = no texture
  // Symmetries of the shape, identity first. Depth does not distinguish these poses, so the image
  // may show any of them.
  std::vector<Pose> symmetries_O;
};

// Returns the colors at surface samples. `points` are in frame O; points[i] is on the mesh
// triangle triangles[i]. Texture colors are averaged over the footprint of one pixel for an object
// about 60 pixels wide.
SurfaceTexture MakeSurfaceTexture(const ObjectModel& model, std::span<const Eigen::Vector3d> points,
                                  std::span<const int> triangles);

// Returns the Pearson correlation between model and image colors over the visible points at X_CO,
// the maximum over the symmetric poses. Its standard error is added, so that few points give weak
// evidence against a pose. Each channel of each side of the object is relative to its own mean, so
// strength and tint of the light do not matter. Returns nothing if the object or the image has no
// colors, or if any symmetric pose shows too few points or too little contrast.
std::optional<double> TextureCorrelation(const OrganizedCloud& cloud, const ModelPoints& model,
                                         const Pose& X_CO);

// Minimum correlation at which the texture counts as found.
inline constexpr double kTextureFound = 0.5;

// Lowers the score of a pose according to a low correlation. A found texture does not raise it: the
// verifier's score already assumes a real object.
double ScoreWithTexture(double score, std::optional<double> texture_correlation);

}  // namespace pickbed::perception
