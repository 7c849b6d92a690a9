#pragma once

// How much better a pose explains the depth image than no part there would: the logarithm of the
// ratio of the likelihoods of the readings, pixel by pixel over what the part covers when it is
// drawn at that pose. A reading at the part's surface is likely, one in front of it is another part
// that hides it, one behind contradicts it, and none says nothing. Where the part ends in the
// picture a surface that goes on as if it did not says that it is another one. The mixture of a
// surface, what may stand before it, and outliers is that of beam models of range finders (Thrun,
// Burgard and Fox, "Probabilistic Robotics", 2005, section 6.3).

#include <memory>
#include <optional>

#include "perception/depth_to_cloud.h"
#include "scenes/face_raster.h"
#include "scenes/object_model.h"

namespace pickbed {

struct DepthEvidenceOptions {
  double sigma_m = 0.0015;      // of readings along the normal, up to 1 m; grows with z^2 beyond
  double max_sigmas = 2.5;      // farther off it is another surface
  double max_depth_bands = 4;   // where the ray grazes the surface: that many bands along it
  double min_normal_cos = 0.7;  // between the normals of part and reading
  double occlusion = 0.3;       // chance that something hides a pixel
  double outlier = 0.02;        // chance of a reading that means nothing
  // What a pixel costs, in nats, that contradicts: behind the surface; in front of it; on it but
  // turned another way. They are not those of the mixture, which takes pixels for independent.
  double violated_cost = 6;
  double hidden_cost = 0.35;
  double wrong_normal_cost = 2.5;
  // The same of a look beyond the part's outline that sees its surface go on: this far from a pixel
  // that agrees, so near to the pixel's plane and so little turned.
  double continuing_cost = 3;
  int beyond_px = 3;
  double continuing_sigmas = 1.5;
  double continuing_min_cos = 0.95;
  int max_pixels = 1500;  // looked at; evenly strided beyond
};

// Pixels of the full image, counted by their stride.
struct DepthEvidence {
  double log_ratio = 0;  // nats
  double covered = 0;    // by the part; of these:
  double agreeing = 0;   // readings on the surface, hidden behind others, ...
  double hidden = 0;     //
  double violated = 0;   // readings behind the surface
  double wrong_normal = 0;
  // Looks beyond the outline, from pixels that agree, to what is not hidden; and those of them that
  // see the surface go on.
  double beyond = 0, continuing = 0;
};

// Memory of one frame's work, for one thread.
using EvidenceScratch = FaceRaster;

class DepthEvidenceOf {
 public:
  explicit DepthEvidenceOf(const ObjectModel& model, const DepthEvidenceOptions& options = {});

  // All zero where the part is not wholly in front of the camera or outside the image. No
  // allocation once the scratch has grown. Looks at about max_pixels, or as many as the options
  // say.
  DepthEvidence operator()(const OrganizedCloud& cloud, const Pose& X_CO, EvidenceScratch& scratch,
                           std::optional<int> max_pixels = {}) const;

 private:
  double Agreement(double squared_sigmas) const;

  DepthEvidenceOptions options_;
  RasterMesh mesh_;
  Bounds bounds_O_;
  double diameter_m_ = 0;
  bool cull_back_ = false;
  std::vector<float> agreement_;  // nats, over the squared distance in sigmas
};

}  // namespace pickbed
