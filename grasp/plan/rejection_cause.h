#pragma once

// Private to grasp/plan: why the planner on poses rejects a candidate. PlanResult::rejected counts
// the candidates by the names of these causes.

#include "grasp/layer.h"

namespace pickbed::grasp {

enum Cause {
  kTilt,
  kQuality,
  kOpening,
  kBinFloor,
  kBinWall,
  kFingers,
  kPalm,
  kOutranked,
  kNotTried,
  kCauses,         // number of causes
  kFree = kCauses  // not rejected
};

// Returns the name under which a cause is counted. `cause` must be below kCauses.
inline const char* CauseName(int cause) {
  constexpr const char* kNames[kCauses] = {"tilt",
                                           "quality",
                                           "opening",
                                           "bin floor",
                                           "bin wall",
                                           "fingers meet an instance",
                                           "palm meets an instance",
                                           "outranked",
                                           "not tried"};
  return kNames[cause];
}

}  // namespace pickbed::grasp
