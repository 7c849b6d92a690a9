#pragma once

// Views to test crop methods with, under one condition each: what a method was not shown when it
// was made. Truth stands beside each view.

#include <span>
#include <string>
#include <vector>

#include "perception/crop_views.h"

namespace pickbed {

// The same objects as different sources see them.
struct CropSources {
  LabelledViewSource* clean = nullptr;  // an ideal sensor, one lamp
  LabelledViewSource* noisy = nullptr;  // a real sensor's noise
  LabelledViewSource* relit = nullptr;  // other lamps and materials
};

struct CropCondition {
  const char* name;
  const char* help;
  bool noisy = false;
  bool relit = false;
  bool background = false;
  double occluded = 0;  // share of the part's pixels
};

std::span<const CropCondition> CropConditionTable();

struct CropTest {
  RgbdFrame frame;
  Pose X_CO = Pose::Identity();
  double occluded = 0;  // share that is
};

// The part at these orientations, see CropPose().
// background: other parts beside and behind it and a tilted, coloured wall behind all. occluded:
// another part of similar size slid in before it, in the image, from a random side, until it hides
// the share; of several tries the one that comes nearest. No sensor noise is added where two views
// are joined.
std::vector<CropTest> MakeCropTests(const CropSources& sources, int object,
                                    const CropCondition& condition, const Rotations& R_CO,
                                    const CropViewOptions& options, uint64_t seed);

}  // namespace pickbed
