#pragma once

// Sheets of tiles that explain an estimate: patches with their neighbours, and poses with the model
// points that speak for and against them.

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "eval/report/draw_explain.h"

namespace pickbed::explain {

using PatchValues = std::array<int8_t, kPatchValues>;

struct NeighborTile {
  std::optional<PatchValues> patch;  // of the code book's entry; nothing = could not be rendered
  int object = 0;
  Pose X_CO = Pose::Identity();  // that it votes for
  Rgb8 color;                    // of its frame
  std::string caption;
};
struct QueryTile {
  const TracedPatch* patch = nullptr;
  Eigen::Vector2d pixel;  // of its middle
  double side_px = 0;     // of the patch in the image
  double view_px = 0;     // of the crops about it
  std::vector<NeighborTile> neighbors;
};
// A block a query: its patch over its place in the image, then each neighbour's patch over the pose
// that it votes for.
Image<Rgb8> PatchSheet(const Board& board, PartOutlines& outlines,
                       const std::vector<QueryTile>& queries, PatchChannels channels,
                       const std::vector<LegendEntry>& legend);

// A patch by depth (near is warm), shaded by its normals, or in its colours; dark where nothing is
// known.
Image<Rgb8> PatchPicture(const PatchValues& values, PatchChannels channels);

struct PoseTile {
  int object = 0;
  Pose X_CO = Pose::Identity();
  Rgb8 color;  // of its frame
  std::vector<JudgedPoint> points;
  std::string title, caption;
};
Rgb8 FitColor(PointFit fit);
std::vector<LegendEntry> FitLegend();
// A tile a pose: the image about it with its outline, and its model points by what they found.
Image<Rgb8> PoseGallery(const Board& board, PartOutlines& outlines, const ObjectSet& objects,
                        const std::vector<ModelPoints>& models, const std::vector<PoseTile>& tiles);

}  // namespace pickbed::explain
