#pragma once

// Progress for people on stderr: one line that is rewritten on a terminal, plain lines elsewhere.

#include <chrono>
#include <string>

namespace pickbed {

class ProgressLine {
 public:
  ProgressLine();
  ~ProgressLine();  // ends a line that is still open
  ProgressLine(const ProgressLine&) = delete;
  ProgressLine& operator=(const ProgressLine&) = delete;

  // On a terminal replaces the line; elsewhere prints a line, at most one a second unless
  // `important`.
  void Show(const std::string& text, bool important = false);
  double elapsed_s() const;

 private:
  using Clock = std::chrono::steady_clock;
  bool terminal_;
  bool open_ = false;
  Clock::time_point start_;
  Clock::time_point shown_;
};

// "1:05" or "2:03:04"; "?" when negative or not finite.
std::string FormatDuration(double seconds);

}  // namespace pickbed
