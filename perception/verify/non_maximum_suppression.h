#pragma once

// Non-maximum suppression: removes hypotheses that claim the same pixels as a better hypothesis or
// penetrate it.

#include <span>
#include <vector>

#include "perception/cloud/organized_cloud.h"
#include "perception/model/model_points.h"
#include "perception/pose_hypothesis.h"
#include "scenes/base/settings.h"

namespace pickbed::perception {

struct NonMaximumSuppressionOptions {
  double claim_m = 0.004;         // a hypothesis claims the pixels this near to its model surface
  double max_shared_share = 0.4;  // maximum share of a hypothesis's pixels claimed by better ones
  int pixel_stride = 2;           // only every pixel_stride-th row and column is evaluated
  // Maximum penetration over the smaller diameter. Poses accurate to a few hundredths of the
  // diameter may overlap this much when the instances touch.
  double max_penetration_share = 0.08;
  void Visit(SettingsVisitor& v);
};

// Returns the kept hypotheses by decreasing score; equal scores keep the input order.
// - A hypothesis that claims no pixel is dropped.
// - A suppressed pose is added to suppressed_X_CO of the winner, if both are of the same object.
//   The winner claims most of its pixels, or is penetrated by it.
// - If `instances` is given, at most this many hypotheses of each object are kept; surplus ones do
//   not suppress others.
// `models` and `instances` are by object index. Throws InputError if their sizes differ, and
// for options out of range.
std::vector<PoseHypothesis> SuppressNonMaxima(const OrganizedCloud& cloud,
                                              const std::vector<ModelPoints>& models,
                                              std::vector<PoseHypothesis> hypotheses,
                                              const NonMaximumSuppressionOptions& options = {},
                                              std::span<const int> instances = {});

}  // namespace pickbed::perception
