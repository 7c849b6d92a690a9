#include "eval/progress.h"

#include <fmt/format.h>
#include <unistd.h>

#include <cmath>
#include <cstdio>

namespace pickbed {
namespace {

constexpr std::chrono::seconds kPlainLineEvery{1};
constexpr char kEraseLine[] = "\r\033[K";

}  // namespace

ProgressLine::ProgressLine()
    : terminal_(isatty(STDERR_FILENO) == 1), start_(Clock::now()), shown_(start_) {
  shown_ -= kPlainLineEvery;
}

ProgressLine::~ProgressLine() {
  if (open_) fmt::print(stderr, "\n");
}

void ProgressLine::Show(const std::string& text, bool important) {
  if (terminal_) {
    fmt::print(stderr, "{}{}", kEraseLine, text);
    open_ = true;
    return;
  }
  if (!important && Clock::now() - shown_ < kPlainLineEvery) return;
  shown_ = Clock::now();
  fmt::print(stderr, "{}\n", text);
}

double ProgressLine::elapsed_s() const {
  return std::chrono::duration<double>(Clock::now() - start_).count();
}

std::string FormatDuration(double seconds) {
  if (!std::isfinite(seconds) || seconds < 0) return "?";
  const long total = std::lround(seconds);
  const long hours = total / 3600, minutes = total / 60 % 60;
  if (hours > 0) return fmt::format("{}:{:02}:{:02}", hours, minutes, total % 60);
  return fmt::format("{}:{:02}", minutes, total % 60);
}

}  // namespace pickbed
