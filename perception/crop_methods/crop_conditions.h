#pragma once

// Test views for crop methods, each under one condition that the method's templates do not show.
// Each view has its ground truth.

#include <span>
#include <string>
#include <vector>

#include "perception/crops/crop_views.h"
#include "scenes/base/ids.h"

namespace pickbed::perception {

// Sources of views of the same objects.
struct CropSources {
  LabelledViewSource* clean = nullptr;  // an ideal sensor, one lamp
  LabelledViewSource* noisy = nullptr;  // noise of a real sensor
  LabelledViewSource* relit = nullptr;  // other lamps and materials
};

// One condition of the test views.
struct CropCondition {
  const char* name;
  const char* help;
  bool noisy = false;
  bool relit = false;
  bool background = false;
  double occluded = 0;  // target share of the object's pixels that is hidden
};

// Returns all conditions.
std::span<const CropCondition> CropConditionTable();

// A test view and its ground truth.
struct CropTest {
  RgbdFrame frame;
  Pose X_CO = Pose::Identity();
  double occluded = 0;  // actual share that is hidden
};

// Renders the object at these orientations, see CropPose(), under the condition.
// - background: other objects are beside and behind the object, before a tilted, colored wall
// - occluded: another object of similar size is moved across the image, from a random direction,
//   until it hides the share. The best of several samples is used.
// No sensor noise is added at the seams of composed views.
std::vector<CropTest> MakeCropTests(const CropSources& sources, ObjectId object,
                                    const CropCondition& condition, const Rotations& R_CO,
                                    const CropViewOptions& options, uint64_t seed);

}  // namespace pickbed::perception
