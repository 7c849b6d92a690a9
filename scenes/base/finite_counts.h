#pragma once

// Counters of values that are not finite (NaN or infinite). A stage that receives or makes such
// values drops them, so that no later stage sees them, and counts them here. The counts are for
// diagnosis. They never change a result.

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "scenes/base/stage_timer.h"

namespace pickbed::scenes {

// Boundaries between stages at which values are checked.
enum class FiniteBoundary { kDepth, kPoints, kNormals, kRefinedPoses, kScores, kPoses, kGrasps };

// Names of the boundaries, in the same order.
inline constexpr std::array kFiniteBoundaryNames = {"depth",  "points", "normals", "refined_poses",
                                                    "scores", "poses",  "grasps"};

// The counters of the process.
inline std::array<std::atomic<int64_t>, kFiniteBoundaryNames.size()> not_finite_counters{};

// Adds to the counter of a boundary. Any thread may call it.
inline void CountNotFinite(FiniteBoundary boundary, int64_t count = 1) {
  not_finite_counters[static_cast<size_t>(boundary)] += count;
}

// Prefix of the stages of TakeNotFiniteCounts().
inline constexpr const char* kNotFinitePrefix = "not_finite/";

// Returns whether a stage of the timings is such a counter and not a duration.
inline bool IsNotFiniteCount(const std::string& stage) {
  return stage.starts_with(kNotFinitePrefix);
}

// Returns the counters that are not 0, as stages of the timings: kNotFinitePrefix and the name of
// the boundary. Then sets all counters of the process to 0.
inline StageSeconds TakeNotFiniteCounts() {
  StageSeconds counts;
  for (size_t i = 0; i < kFiniteBoundaryNames.size(); ++i) {
    const int64_t count = not_finite_counters[i].exchange(0);
    if (count == 0) continue;
    counts[std::string(kNotFinitePrefix) + kFiniteBoundaryNames[i]] = static_cast<double>(count);
  }
  return counts;
}

// Returns a line for each counter that is not 0, and sets all of them to 0.
inline std::vector<std::string> NotFiniteWarnings() {
  std::vector<std::string> lines;
  for (const auto& [stage, count] : TakeNotFiniteCounts()) {
    std::string name = stage.substr(std::string_view(kNotFinitePrefix).size());
    std::ranges::replace(name, '_', ' ');
    lines.push_back(fmt::format("dropped values that are not finite: {:.0f} of {}", count, name));
  }
  return lines;
}

}  // namespace pickbed::scenes
