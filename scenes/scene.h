#pragma once

// A settled snapshot of a bin as plain data. Every picture and every physics world of a trial is
// rebuilt from it. It is ground truth, so perception must not include this header.

#include <string>
#include <vector>

#include "scenes/base/ids.h"
#include "scenes/bin/bin.h"
#include "scenes/geometry/pose.h"
#include "scenes/objects/object_model.h"

namespace pickbed::scenes {

// How an instance differs from its model, as a share of the model's value: 0.1 = 10 % more.
struct InstanceDeviation {
  double friction = 0;
  double mass = 0;
  friend bool operator==(const InstanceDeviation&, const InstanceDeviation&) = default;
};

// One instance in the bin.
struct PosedObject {
  InstanceId instance{0};  // the id image contains instance + 1
  ObjectId object{0};
  Pose X_WO = Pose::Identity();
  InstanceDeviation deviation = {};
};

// A bin and the instances in it.
struct Scene {
  Bin bin;
  std::vector<PosedObject> objects;
};

}  // namespace pickbed::scenes
