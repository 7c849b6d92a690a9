#pragma once

// The targets by format. targets.cpp lists them.

#include <vector>

#include "tests/fuzz/targets.h"

namespace pickbed::tests {

std::vector<FuzzTarget> SettingsTargets();  // scenarios, sweeps and what they name
std::vector<FuzzTarget> MeshTargets();      // meshes, their materials and textures, and objects
std::vector<FuzzTarget> ImageTargets();     // color, depth and mask images
std::vector<FuzzTarget> FrameTargets();     // point clouds and intrinsics
std::vector<FuzzTarget> DatasetTargets();   // BOP data sets and results
std::vector<FuzzTarget> StoreTargets();     // stores of results, also of shards
std::vector<FuzzTarget> ModelTargets();     // trained models and states of trainings
std::vector<FuzzTarget> GraspTargets();     // grasps, tolerance models and calibrations
std::vector<FuzzTarget> MessageTargets();   // messages of plug-ins
std::vector<FuzzTarget> CacheTargets();     // files of the cache

}  // namespace pickbed::tests
