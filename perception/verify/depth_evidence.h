#pragma once

// Evidence of the depth image for a pose: log-likelihood ratio of the readings with the object at
// the pose and without it. It is summed over the pixels that the object covers when it is rendered.
// A reading on the surface supports the pose, and a reading in front is an occluder. A reading
// behind contradicts the pose, and a hole has no effect. A surface that continues beyond the
// object's outline belongs to something else. The mixture of surface, occluder and outliers follows
// the beam models of range finders (Thrun, Burgard and Fox, "Probabilistic Robotics", 2005,
// section 6.3).

#include <memory>
#include <optional>

#include "perception/cloud/organized_cloud.h"
#include "perception/verify/pose_support.h"
#include "scenes/base/settings.h"
#include "scenes/camera/mesh_raster.h"
#include "scenes/objects/object_model.h"

namespace pickbed::perception {

struct DepthEvidenceOptions {
  double sigma_m = 0.0015;  // noise along the normal, up to 1 m; grows with z^2 beyond
  double max_sigmas = 2.5;  // half width of the surface band; readings outside are another surface
  double max_depth_bands = 4;   // maximum distance along the ray, in bands, for grazing rays
  double min_normal_cos = 0.7;  // between the normals of model and reading
  double occlusion = 0.3;       // prior probability that a pixel is occluded
  double outlier = 0.02;        // probability of a meaningless reading
  // Costs of a contradicting pixel, in nats: behind the surface, in front of it, on it with another
  // normal. They differ from the mixture, which assumes independent pixels.
  double violated_cost = 6;
  double hidden_cost = 0.35;
  double wrong_normal_cost = 2.5;
  // Cost of a sample beyond the outline where the surface continues, in nats. The sample is
  // beyond_px from an agreeing pixel, within continuing_sigmas of its plane, with a normal that
  // differs less than continuing_min_cos.
  double continuing_cost = 3;
  int beyond_px = 3;
  double continuing_sigmas = 1.5;
  double continuing_min_cos = 0.95;
  int max_pixels = 1500;  // approximate number of pixels evaluated; larger areas are strided evenly
  void Visit(SettingsVisitor& v);
};

// Log-likelihood ratio and pixel counts. Counts are scaled by the stride to the full image.
struct DepthEvidence {
  double log_ratio = 0;     // nats
  double covered = 0;       // pixels covered by the object; the next four are subsets
  double agreeing = 0;      // readings on the surface
  double hidden = 0;        // readings in front of the surface
  double violated = 0;      // readings behind the surface
  double wrong_normal = 0;  // readings on the surface with another normal
  // Unoccluded samples beyond the outline, from agreeing pixels; and those where the surface
  // continues.
  double beyond = 0, continuing = 0;
};

// Reusable memory for one thread.
using EvidenceScratch = FaceRaster;

// Evaluates the evidence for poses of one object.
class DepthEvidenceOf {
 public:
  // Throws InputError for options out of range.
  explicit DepthEvidenceOf(const ObjectModel& model, const DepthEvidenceOptions& options = {});

  // Evaluates about max_pixels pixels; by default the number in the options. The result is zero if
  // the object is partly behind the camera or outside the image. Does not allocate once the scratch
  // has grown.
  // Adds the pixels to `support` if given.
  DepthEvidence operator()(const OrganizedCloud& cloud, const Pose& X_CO, EvidenceScratch& scratch,
                           std::optional<int> max_pixels = {},
                           PoseSupportMeasure* support = nullptr) const;

 private:
  double Agreement(double squared_sigmas) const;

  DepthEvidenceOptions options_;
  RasterMesh mesh_;
  Bounds bounds_O_;
  double diameter_m_ = 0;
  bool cull_back_ = false;
  std::vector<float> agreement_;  // table of nats by the squared distance in sigmas
};

}  // namespace pickbed::perception
