#pragma once

// Draws sheets of tiles that explain an estimate: patches with their nearest codebook entries, and
// poses with the model points that support or contradict them.

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "eval/explain/draw_stages.h"
#include "scenes/base/ids.h"

namespace pickbed::eval {

using PatchValues = std::array<int8_t, kPatchValues>;

struct NeighborTile {
  std::optional<PatchValues> patch;  // of the codebook entry; nullopt = could not be rendered
  ObjectId object{0};
  Pose X_CO = Pose::Identity();  // pose for which it votes
  Rgb8 color;                    // border color of the tile
  std::string caption;
};
struct QueryTile {
  const TracedPatch* patch = nullptr;
  Eigen::Vector2d pixel;  // patch center in the frame
  double side_px = 0;     // side of the patch, frame px
  double view_px = 0;     // side of the image crops around it, frame px
  std::vector<NeighborTile> neighbors;
};
// Draws one block per query. Its first column is the patch above its place in the image. Further
// columns show each neighbour's patch above the pose for which it votes.
Image<Rgb8> PatchSheet(const Board& board, ObjectOutlines& outlines,
                       const std::vector<QueryTile>& queries, PatchChannels channels,
                       const std::vector<LegendEntry>& legend);

// Draws a patch by depth (near is warm), shaded by its normals, or in its colors. Unknown pixels
// are dark.
Image<Rgb8> PatchPicture(const PatchValues& values, PatchChannels channels);

struct PoseTile {
  ObjectId object{0};
  Pose X_CO = Pose::Identity();
  Rgb8 color;  // border color of the tile
  std::vector<JudgedPoint> points;
  std::string title, caption;
};
// Returns the color of a model point by its agreement with the image.
Rgb8 FitColor(PointFit fit);
// Returns the legend of these colors.
std::vector<LegendEntry> FitLegend();
// Draws one tile per pose: the image around it, its outline, and its model points in the color of
// their fit.
Image<Rgb8> PoseGallery(const Board& board, ObjectOutlines& outlines, const ObjectSet& objects,
                        const std::vector<ModelPoints>& models, const std::vector<PoseTile>& tiles);

}  // namespace pickbed::eval
