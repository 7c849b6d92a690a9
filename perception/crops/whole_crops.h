#pragma once

// Crops of whole objects in bins, where the object centers are unknown. Each crop is cut around a
// visible point, whose depth is the reference depth. The points are proposals on a pixel grid, as
// in the public draft after Kehl et al., ECCV 2016. Only depth is used; floor and walls are
// removed.
//
// Frame P of a crop is the patch frame of its point (see patch.h) with in-plane angle 0. A matching
// template votes for X_CO = X_CP * X_PO at any image position. A template is cut around the visible
// point nearest to the ray through the object center.

#include <functional>
#include <vector>

#include "perception/cloud/organized_cloud.h"
#include "perception/crops/crop_views.h"
#include "scenes/base/ids.h"

namespace pickbed::perception {

struct WholeViewOptions {
  // Templates from all directions, at all in-plane angles. The angles are 15 degrees apart; the
  // last one is one step before the first.
  CropViewOptions templates{
      .template_level = 2, .full_sphere = true, .in_plane = 24, .in_plane_max_rad = 3.0107};
  int isolated = 1500;       // training views of an isolated object, at random orientations
  int clutter_scenes = 60;   // for training, per object
  int views_per_scene = 3;   // views of each clutter scene
  double min_visible = 0.5;  // minimum visible fraction of a training instance
  // Maximum distance of a training crop's point from the ray through the object center, in
  // diameters.
  double off_center = 0.06;
  void Visit(SettingsVisitor& v);
};

// Templates of one object.
struct WholeTemplates {
  ObjectCrops crops;  // orientations are R_PO
  std::vector<Pose> X_PO;
};

// Renders the templates of one object. Throws InputError if a view does not show the object.
WholeTemplates MakeWholeTemplates(LabelledViewSource& views, ObjectId object,
                                  const CropViewOptions& options, uint64_t seed);

// Makes a training set for all objects: templates, and training views of the isolated object and of
// clutter scenes, with distractors and noise. on_share receives the progress, 0..1; it may be
// empty, and returns false to stop. The result is then incomplete.
CropTrainingSet MakeWholeTrainingSet(LabelledViewSource& views, const WholeViewOptions& options,
                                     uint64_t seed,
                                     const std::function<bool(double share)>& on_share);

// Returns a depth-only frame of the foreground; depth is 0 elsewhere.
RgbdFrame ForegroundFrame(const OrganizedCloud& cloud);

// Returns the foreground pixels on every `grid_px`-th row and column.
std::vector<int> GridProposals(const OrganizedCloud& cloud, int grid_px);

// Cuts one crop of side side_m per pixel; each pixel must be a foreground pixel.
CropSet CutWholeCrops(const OrganizedCloud& cloud, const std::vector<int>& pixels, double side_m);

}  // namespace pickbed::perception
