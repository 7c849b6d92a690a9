#pragma once

// What a network says of patches, for those who make votes of it.

#include "perception/codebook.h"
#include "perception/pose_targets.h"

namespace pickbed {

struct PatchVoter {
  PatchChannels channels = PatchChannels::kDepthNormals;  // of the patches that it sees
  DescribePatches describe;
  RegressPoses regress;  // empty: it regresses none
  int parts = 1;         // of which it regresses poses
};

}  // namespace pickbed
