#pragma once

// Progress on stderr: one line that is rewritten on a terminal, plain lines elsewhere, or one JSON
// object a line for machines.

#include <chrono>
#include <string>
#include <vector>

#include "eval/statistics.h"

namespace pickbed {

// From now on every ProgressLine writes JSON: {"message": "..."}, or of a ProgressState
//   {"what": "trial", "done": 12, "total": 40, "per_s": 0.5, "left_s": 56.0, "note": "...",
//    "attempts": 30, "successes": 27, "success_rate": 0.9, "success_ci95": [0.76, 0.97]}
// where note and what follows may be missing, and left_s is null while nobody knows.
void WriteProgressAsJson();

// How far a loop over things of one kind is.
struct ProgressState {
  std::string what = "trial";
  int done = 0, total = 0;
  int done_before = 0;  // by an earlier call: they say nothing of the rate
  bool counts_successes = false;
  std::vector<Cluster> outcomes;  // successes of attempts, a cluster a trial
  std::string note;               // what else is worth a word
};

class ProgressLine {
 public:
  ProgressLine();
  ~ProgressLine();  // ends a line that is still open
  ProgressLine(const ProgressLine&) = delete;
  ProgressLine& operator=(const ProgressLine&) = delete;

  // On a terminal replaces the line; elsewhere prints a line, at most one a second unless
  // `important`.
  void Show(const std::string& text, bool important = false);
  // The last one of all is always shown.
  void Show(const ProgressState& state);
  // The rate counts from now on.
  void Restart();
  double elapsed_s() const;

 private:
  using Clock = std::chrono::steady_clock;
  bool IsDue(bool important);
  void Print(const std::string& text);
  bool terminal_;
  bool open_ = false;
  Clock::time_point start_;
  Clock::time_point shown_;
};

// "trial 12/40  0.50 trials/s  left 0:56  picked 27/30 = 90.0 % [76.0, 97.0]"
std::string ProgressText(const ProgressState& state, double elapsed_s);
std::string ProgressJson(const ProgressState& state, double elapsed_s);

// "1:05" or "2:03:04"; "?" when negative or not finite.
std::string FormatDuration(double seconds);

}  // namespace pickbed
