#pragma once

// Where the points of a sweep end early: ScenarioSpec::stop_width, by eval/sequential_stop.h, over
// the scenes 0, 1, ... in this order, whatever the order in which workers finish them. Trials of
// later scenes that were under way by then count nowhere.

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "eval/sequential_stop.h"
#include "eval/trial.h"

namespace pickbed {

struct Sweep;

// How far a point is.
struct StopState {
  double width = 0;   // wanted
  int scenes = 0;     // looked at, from 0 on; those without an attempt tell nothing
  double mean = 0;    // pick success, each scene counting as much as another
  Interval interval;  // holds at all times jointly with 95 %
  bool reached = false;
};

class PointStop {
 public:
  explicit PointStop(double width) : stop_(width), width_(width) {}
  // Successes of attempts in a scene; nothing of one that crashed. In any order.
  void Add(int scene, const Cluster& outcome);
  bool Counts(int scene) const { return !stop_.Reached() || scene < scenes_; }
  StopState state() const;

 private:
  SequentialStop stop_;
  double width_;
  std::map<int, Cluster> later_;  // whose turn has not come
  int scenes_ = 0;
};

// Of the trials of one point and the scenes that crashed; nothing where it is to stop nowhere.
std::optional<StopState> StopOf(const std::vector<TrialResult>& trials,
                                const std::vector<int>& crashed_scenes, double width);

// Of all points of a sweep.
class SweepStop {
 public:
  explicit SweepStop(const Sweep& sweep);
  bool enabled() const { return !points_.empty(); }
  void Add(const TrialResult& result);
  // Of a trial; true when its point ends by it.
  bool Add(int trial, const Cluster& outcome);
  bool Counts(int trial) const;
  // "2 of 3 points are narrow enough"; of one point its interval and the wanted width.
  std::string Note() const;

 private:
  const Sweep& sweep_;
  std::map<int, PointStop> points_;  // those that may stop, by number
};

// Throws InputError where a point may end early, for a shard sees no other's scenes.
void RequireNoStop(const Sweep& sweep);

// "stops after 23 bins: 0.912 in [0.871, 0.950], no wider than 0.080"
std::string StopText(const StopState& state);

}  // namespace pickbed
