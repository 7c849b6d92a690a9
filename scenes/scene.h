#pragma once

// A settled snapshot of a bin: plain data from which every picture and every physics world of a
// trial is rebuilt. This is the truth; perception must not include it.

#include <string>
#include <vector>

#include "scenes/bin.h"
#include "scenes/object_model.h"
#include "scenes/pose.h"

namespace pickbed {

struct PosedObject {
  int instance = 0;  // id that stays the same while others are picked; id image holds instance + 1
  int object = 0;    // index into the ObjectSet
  Pose X_WO = Pose::Identity();
};

struct Scene {
  Bin bin;
  std::vector<PosedObject> objects;
};

}  // namespace pickbed
