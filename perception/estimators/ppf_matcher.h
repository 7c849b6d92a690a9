#pragma once

// Point pair features of one object (Drost et al. 2010) with OpenCV's surface_matching, behind an
// interface without OpenCV types.

#include <memory>
#include <vector>

#include "perception/cloud/organized_cloud.h"
#include "perception/model/model_points.h"
#include "scenes/base/settings.h"
#include "scenes/geometry/pose.h"

namespace pickbed::perception {

struct PpfMatchOptions {
  double model_sampling = 0.07;         // sampling step over the model's bounding box, per axis
  double scene_voxel_diameters = 0.06;  // voxel side; one scene point per voxel is used
  double scene_step = 0.1;              // share of scene points that are reference points
  // Side of square windows, half a side apart, in which the scene is matched; 0 = the whole scene.
  // OpenCV also looks up pairs wider than the object, which only give chance votes. Windows exclude
  // them.
  double window_diameters = 0;
  // Poses nearer than this are averaged; 0 = none. OpenCV's defaults interpret the relative
  // sampling step as metres, which merges all poses. Both values are therefore always set.
  double cluster_m = 0;
  double cluster_deg = 15;
  void Visit(SettingsVisitor& v);
};

struct PpfIcpOptions {
  int iterations = 30;
  float tolerance = 0.005f;
  float rejection = 2.5f;  // limit of a correspondence, in sigmas of the residual
  int levels = 4;
  void Visit(SettingsVisitor& v);
};

// Proposes and refines poses of one object.
class PpfMatcher {
 public:
  PpfMatcher(const ModelPoints& model, const PpfMatchOptions& options);
  ~PpfMatcher();

  // Returns foreground points with a normal, one per voxel. Row i is x y z nx ny nz in C, m.
  std::vector<float> SceneRows(const OrganizedCloud& cloud) const;

  // Returns poses X_CO, within each window by decreasing number of votes. Each reference point
  // gives one pose.
  std::vector<Pose> Match(const std::vector<float>& scene_rows) const;

  // Refines poses with OpenCV's ICP. A pose for which it fails is not finite.
  std::vector<Pose> Refine(const std::vector<float>& scene_rows, const std::vector<Pose>& poses,
                           const PpfIcpOptions& options) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace pickbed::perception
