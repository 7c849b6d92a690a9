#pragma once

// Wall time by stage, in seconds. It is stored separately from the results, because results must be
// reproducible byte by byte.

#include <chrono>
#include <map>
#include <string>

namespace pickbed::scenes {

using StageSeconds = std::map<std::string, double>;

// Adds the time between construction and destruction to `seconds[stage]`. If `seconds` is part of a
// result that is returned, the timer must end in a block before the return statement.
class StageTimer {
 public:
  StageTimer(StageSeconds& seconds, std::string stage)
      : seconds_(seconds), stage_(std::move(stage)), start_(Clock::now()) {}
  ~StageTimer() {
    seconds_[stage_] += std::chrono::duration<double>(Clock::now() - start_).count();
  }
  StageTimer(const StageTimer&) = delete;
  StageTimer& operator=(const StageTimer&) = delete;

 private:
  using Clock = std::chrono::steady_clock;
  StageSeconds& seconds_;
  std::string stage_;
  Clock::time_point start_;
};

}  // namespace pickbed::scenes
