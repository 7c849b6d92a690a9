#pragma once

// The pattern of colours that a part wears, a label or a printed side. Where the camera gives
// colour it tells the part from a foreign thing of the same shape, which depth alone cannot.

#include <Eigen/Core>
#include <optional>
#include <span>
#include <vector>

#include "perception/depth_to_cloud.h"
#include "scenes/object_model.h"
#include "scenes/triangle_mesh.h"

namespace pickbed {

struct ModelPoints;

struct SurfacePrint {
  std::vector<Eigen::Vector3f> colors;  // of ModelPoints::points_O, 0..255; empty = one colour
  // The part's symmetries, identity first: of poses that depth cannot tell apart any may be seen.
  std::vector<Pose> symmetries_O;
};

// Colours at `points`, samples of the part's surface in O, each on the triangle of that index; a
// texture's are means over what a pixel sees where the part is some 60 pixels wide.
SurfacePrint MakeSurfacePrint(const ObjectModel& model, std::span<const Eigen::Vector3d> points,
                              std::span<const int> triangles);

// How well the image may show the part's colours at X_CO: Pearson's correlation of the two over the
// points that the camera sees, plus its standard error, so that few points say little. Each channel
// of each side is taken about its own mean: neither the light's strength nor its tint matters. The
// best of the symmetric poses. Nothing where the part or the image has no colours, or any symmetric
// pose shows too few points or too little of a pattern to tell.
std::optional<double> PrintCorrelation(const OrganizedCloud& cloud, const ModelPoints& model,
                                       const Pose& X_CO);

// From it on the pattern is there.
inline constexpr double kPrintFound = 0.5;

// The score of a pose, less what its correlation speaks against it. A pattern that is found as told
// adds nothing: the verifier's score already holds for parts.
double ScoreWithPrint(double score, std::optional<double> print_correlation);

}  // namespace pickbed
