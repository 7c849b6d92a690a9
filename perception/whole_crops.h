#pragma once

// Crops of whole parts in bins, where nobody knows their centres: each is cut around a point that
// is seen and stands for its depth, as the proposals on a grid of pixels in the public draft after
// Kehl et al., ECCV 2016. Only depth is used, and floor and walls are taken out.
//
// A crop's frame P is the patch frame of its point (patch.h, no turn about the ray), so that a
// template votes for X_CO = X_CP * X_PO wherever in the image its likeness is seen. A template is
// cut around the visible point nearest to the ray through the part's centre.

#include <functional>
#include <vector>

#include "perception/crop_lesson.h"
#include "perception/depth_to_cloud.h"

namespace pickbed {

struct WholeViewOptions {
  // Templates all around and at all turns. The last angle lies one spacing before the first.
  CropViewOptions templates{
      .template_level = 2, .full_sphere = true, .in_plane = 24, .in_plane_max_rad = 3.0107};
  int alone = 1500;          // views of a part alone at random orientations to learn from
  int piles = 60;            // a part, to learn from
  int views_per_pile = 3;    //
  double min_visible = 0.5;  // visible fraction of an instance to learn from
  double off_center = 0.06;  // of a crop's point from the centre's ray, over the diameter
  void Visit(SettingsVisitor& v);
};

struct WholeTemplates {
  ObjectCrops crops;  // orientations are in P
  std::vector<Pose> X_PO;
};

// Templates of one part. Throws InputError for a part that a view does not show.
WholeTemplates MakeWholeTemplates(LabelledViewSource& views, int object,
                                  const CropViewOptions& options, uint64_t seed);

// Of every part: templates, and as training views of it alone and in piles, with clutter and
// noise. on_share (may be empty) returns false to stop; what comes back is then unfinished.
CropLesson MakeWholeLesson(LabelledViewSource& views, const WholeViewOptions& options,
                           uint64_t seed, const std::function<bool(double share)>& on_share);

// The depth of the foreground alone.
RgbdFrame ForegroundFrame(const OrganizedCloud& cloud);

// Foreground pixels of every `grid_px`-th row and column.
std::vector<int> GridProposals(const OrganizedCloud& cloud, int grid_px);

// One crop for each pixel, which must have a point.
CropSet CutWholeCrops(const OrganizedCloud& cloud, const std::vector<int>& pixels, double side_m);

}  // namespace pickbed
