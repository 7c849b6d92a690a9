#pragma once

// Color consistency: the instances of one object in an image have one color. A pose whose pixels
// have a different color is probably on a distractor. Neither the color of the object nor the
// light has to be known.

#include <Eigen/Core>
#include <optional>
#include <span>
#include <vector>

#include "perception/cloud/organized_cloud.h"
#include "perception/model/model_points.h"
#include "perception/pose_hypothesis.h"
#include "scenes/base/ids.h"

namespace pickbed::perception {

// Common color of the instances of each object in one image. It compares the chromaticity, which
// does not depend on shading or light strength.
class CommonColors {
 public:
  // Estimates the colors from the `accepted` hypotheses, which must show different instances.
  // Nothing is known about an object with few accepted hypotheses, and about any object if the
  // image has no color. `models` is by object index. Cloud and models must outlive this object.
  CommonColors(const OrganizedCloud& cloud, const std::vector<ModelPoints>& models,
               std::span<const PoseHypothesis> accepted);

  // Lowers the score of a hypothesis whose color differs from the other instances of its object,
  // and returns whether it did. The distance is in units of the object's own spread: if instances
  // differ in color, no pose is lowered. Textured objects (see surface_texture.h) are never
  // lowered, because their sides differ.
  bool LowerIfOdd(PoseHypothesis& hypothesis) const;

 private:
  // Chromaticity shared by the instances of an object.
  struct CommonColor {
    Eigen::Vector2d center;
    double spread = 0;
  };
  std::optional<CommonColor> Estimate(std::span<const PoseHypothesis> accepted,
                                      ObjectId object) const;

  const OrganizedCloud& cloud_;
  const std::vector<ModelPoints>& models_;
  std::vector<std::optional<CommonColor>> by_object_;
};

}  // namespace pickbed::perception
