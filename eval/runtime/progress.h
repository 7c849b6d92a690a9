#pragma once

// Progress output on stderr: one rewritten line on a terminal, plain lines elsewhere, or one JSON
// object per line for programs.

#include <chrono>
#include <string>
#include <vector>

#include "eval/stats/statistics.h"

namespace pickbed::eval {

// Switches every ProgressLine to JSON: {"message": "..."}, or for a ProgressState
//   {"what": "trial", "done": 12, "total": 40, "per_s": 0.5, "left_s": 56.0, "note": "...",
//    "executed_grasps": 30, "successes": 27, "success_rate": 0.9, "success_ci95": [0.76, 0.97]}
// The fields from `note` on are optional. `left_s` is null while it is unknown, and `success_ci95`
// with too few trials (eval/metrics/interval_json.h).
void WriteProgressAsJson();

// Progress of a loop over items of one kind.
struct ProgressState {
  std::string what = "trial";
  int done = 0, total = 0;
  int done_before = 0;  // done by an earlier run; not counted in the rate
  double later_s = 0;   // expected duration of work after these items; part of the time left
  bool counts_successes = false;
  std::vector<Cluster> outcomes;  // successes and executed grasps, one cluster per trial
  std::string note;               // further text
};

// Writer of the progress output.
class ProgressLine {
 public:
  ProgressLine();
  ~ProgressLine();  // ends an open line
  ProgressLine(const ProgressLine&) = delete;
  ProgressLine& operator=(const ProgressLine&) = delete;

  // Replaces the line on a terminal. Elsewhere it prints a line, at most one per second unless
  // `important`, and an unchanged text or number of items only once per minute.
  void Show(const std::string& text, bool important = false);
  // Prints a line that stays, above the progress.
  void Note(const std::string& line);
  // Same as Show() for a text with times; `content` is the text without them.
  void ShowTimed(const std::string& text, const std::string& content);
  // Shows the state; the last state (done == total) is always shown.
  void Show(const ProgressState& state);
  // Restarts the clock of the rate.
  void Restart();
  double elapsed_s() const;

 private:
  using Clock = std::chrono::steady_clock;
  bool IsDue(const std::string& content, bool important);
  void Print(const std::string& text);
  void PrintMessage(const std::string& text);
  bool terminal_;
  bool open_ = false;
  Clock::time_point start_;
  Clock::time_point shown_;
  std::string content_;  // of the last line, without times
};

// Example: "trial 12/40  0.50 trials/s  left 0:56  picked 27/30 = 90.0 % [76.0, 97.0]".
std::string ProgressText(const ProgressState& state, double elapsed_s);
// Returns the same state as one JSON object, for programs.
std::string ProgressJson(const ProgressState& state, double elapsed_s);

// Formats as "1:05" or "2:03:04"; "?" if negative or not finite.
std::string FormatDuration(double seconds);

}  // namespace pickbed::eval
