#pragma once

// Small patches of the observed surface, and the borders between them. Patches take the place of
// pixels in the segmentation of objects, because the normal of a patch is less noisy than the
// normal of a pixel (the supervoxels of Papon et al., "Voxel cloud connectivity segmentation", CVPR
// 2013, in the pixels of one image).

#include <Eigen/Core>
#include <vector>

#include "perception/cloud/organized_cloud.h"

namespace pickbed::perception {

struct PatchOptions {
  int block_px = 8;              // edge of the largest patch
  double step_m = 0.008;         // step across the surface that separates neighbours, at 1 m
  double max_normal_rad = 0.44;  // angle between the normals of neighbours in one patch
  void Visit(SettingsVisitor& v);
};

// A patch of surface.
struct SurfacePatch {
  Eigen::Vector3f center_C = Eigen::Vector3f::Zero();  // mean of its points, m
  Eigen::Vector3f normal_C = Eigen::Vector3f::Zero();  // unit, towards the camera; zero = unknown
  Eigen::Vector3f color = Eigen::Vector3f::Zero();     // mean red, green and blue, 0..1
  int pixels = 0;
};

// Border of two patches, in pairs of neighbouring pixels.
struct PatchBorder {
  int a = 0, b = 0;   // patches, a < b
  int smooth_px = 0;  // pairs without a step
  int step_px = 0;    // pairs with a step
};

struct SurfacePatches {
  std::vector<int> of_pixel;  // patch of each pixel; -1 = background or no reading
  std::vector<SurfacePatch> patches;
  std::vector<PatchBorder> borders;  // ordered by a, then b
};

// Divides the foreground of a cloud into patches: the connected pieces of each square block, cut at
// steps and at creases. A step is measured across the surface, so that a slanted plane has none.
// Throws InputError for options out of range.
SurfacePatches FindPatches(const OrganizedCloud& cloud, const PatchOptions& options = {});

}  // namespace pickbed::perception
