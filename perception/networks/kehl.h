#pragma once

// Settings of the autoencoder network of kehl.cpp.

#include <string>

#include "perception/layer.h"
#include "scenes/base/settings.h"

namespace pickbed::perception {

struct AutoencoderOptions {
  // Reconstruction target of the decoder. "itself": the input patch, as in the paper. "positive":
  // the positive patch of the isolated object, so that the descriptor does not describe clutter.
  std::string target = "positive";
  // Input channels. "rgbd": depth, red, green and blue, as in the paper. "depth_normals": depth and
  // normals. "depth": depth only.
  std::string channels = "depth_normals";
  void Visit(SettingsVisitor& v);
};

}  // namespace pickbed::perception
