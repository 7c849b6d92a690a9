#pragma once

// Clock of a training with a time limit.

#include <chrono>
#include <functional>

#include "perception/layer.h"

namespace pickbed::perception {

using TrainingTime = std::chrono::steady_clock::time_point;

// Returns the present time. Tests replace the clock.
using TrainingClock = std::function<TrainingTime()>;

// Returns the time `seconds` after another.
inline TrainingTime Later(TrainingTime time, double seconds) {
  return time +
         std::chrono::duration_cast<TrainingTime::duration>(std::chrono::duration<double>(seconds));
}

// Returns the seconds from one time to another.
inline double SecondsBetween(TrainingTime from, TrainingTime to) {
  return std::chrono::duration<double>(to - from).count();
}

}  // namespace pickbed::perception
