#pragma once

// Settings of the auto-encoder of kehl.cpp, and of its training.

#include <string>

#include "scenes/settings.h"

namespace pickbed {

struct TrainingOptions;  // training.h

struct AutoencoderOptions {
  // What the decoder shall give back: the patch itself, as in the paper, or its twin, the same
  // place of the part seen alone, so that clutter is no part of what is described.
  std::string target = "twin";
  // What is seen of a part: rgbd is depth, red, green and blue, as in the paper; depth_normals is
  // depth and the normal; depth is that alone.
  std::string channels = "depth_normals";
  void Visit(SettingsVisitor& v);
};

// By default for `pickbed train kehl`.
TrainingOptions KehlTraining();

}  // namespace pickbed
