#pragma once

#include "perception/cloud/organized_cloud.h"
#include "tests/support/layer.h"

namespace pickbed::tests {

// No plane is removed: all points of the image stay in the cloud.
inline constexpr CloudOptions kKeepAll{.min_plane_share = 1};

}  // namespace pickbed::tests
