#include "eval/runtime/progress.h"

#include <fmt/format.h>
#include <unistd.h>

#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "eval/metrics/interval_json.h"

namespace pickbed::eval {
namespace {

constexpr std::chrono::milliseconds kPlainLineEvery{1000};
constexpr std::chrono::milliseconds kTerminalLineEvery{100};
constexpr std::chrono::seconds kEqualLineEvery{60};
constexpr char kEraseLine[] = "\r\033[K";
constexpr double kShortest_s = 1e-9;

bool g_as_json = false;

struct Rate {
  double per_s = 0;
  double left_s = 0;  // infinite while no item is done
};

Rate RateOf(const ProgressState& state, double elapsed_s) {
  const double per_s = (state.done - state.done_before) / std::max(elapsed_s, kShortest_s);
  return {per_s, (state.total - state.done) / per_s + state.later_s};
}

struct Success {
  int executed_grasps = 0, successes = 0;
  Interval ci95;
  double rate() const {
    return executed_grasps > 0 ? static_cast<double>(successes) / executed_grasps : 0;
  }
};

Success SuccessOf(const std::vector<Cluster>& outcomes) {
  Success success;
  for (const Cluster& trial : outcomes) {
    success.executed_grasps += trial.samples;
    success.successes += trial.hits;
  }
  success.ci95 = ClusterInterval(outcomes);
  return success;
}

}  // namespace

void WriteProgressAsJson() { g_as_json = true; }

ProgressLine::ProgressLine()
    : terminal_(isatty(STDERR_FILENO) == 1 && !g_as_json), start_(Clock::now()), shown_(start_) {
  shown_ -= kPlainLineEvery;
}

ProgressLine::~ProgressLine() {
  if (open_) fmt::print(stderr, "\n");
}

bool ProgressLine::IsDue(const std::string& content, bool important) {
  Clock::duration every = terminal_ ? kTerminalLineEvery : kPlainLineEvery;
  if (!terminal_ && content == content_) every = kEqualLineEvery;
  if (!important && Clock::now() - shown_ < every) return false;
  shown_ = Clock::now();
  content_ = content;
  return true;
}

void ProgressLine::Print(const std::string& text) {
  if (terminal_) {
    fmt::print(stderr, "{}{}", kEraseLine, text);
    open_ = true;
  } else {
    fmt::print(stderr, "{}\n", text);
  }
}

void ProgressLine::PrintMessage(const std::string& text) {
  Print(g_as_json ? nlohmann::json{{"message", text}}.dump() : text);
}

void ProgressLine::Show(const std::string& text, bool important) {
  if (IsDue(text, important)) PrintMessage(text);
}

void ProgressLine::Note(const std::string& line) {
  PrintMessage(line);
  if (!terminal_) return;
  fmt::print(stderr, "\n");
  open_ = false;
}

void ProgressLine::ShowTimed(const std::string& text, const std::string& content) {
  if (IsDue(content, false)) PrintMessage(text);
}

void ProgressLine::Show(const ProgressState& state) {
  const std::string content = fmt::format("{} {}/{}", state.what, state.done, state.total);
  if (!IsDue(content, state.done == state.total && state.done > state.done_before)) return;
  Print(g_as_json ? ProgressJson(state, elapsed_s()) : ProgressText(state, elapsed_s()));
}

void ProgressLine::Restart() { start_ = Clock::now(); }

double ProgressLine::elapsed_s() const {
  return std::chrono::duration<double>(Clock::now() - start_).count();
}

std::string ProgressText(const ProgressState& state, double elapsed_s) {
  const Rate rate = RateOf(state, elapsed_s);
  std::string text = fmt::format("{} {}/{}  {:.2f} {}s/s  left {}", state.what, state.done,
                                 state.total, rate.per_s, state.what, FormatDuration(rate.left_s));
  if (state.counts_successes) {
    const Success success = SuccessOf(state.outcomes);
    text += fmt::format("  picked {}/{} = {}", success.successes, success.executed_grasps,
                        RateText(success.rate(), success.ci95));
  }
  if (!state.note.empty()) text += fmt::format("  ({})", state.note);
  return text;
}

std::string ProgressJson(const ProgressState& state, double elapsed_s) {
  const Rate rate = RateOf(state, elapsed_s);
  nlohmann::ordered_json json{{"what", state.what},
                              {"done", state.done},
                              {"total", state.total},
                              {"per_s", rate.per_s},
                              {"left_s", nullptr}};
  if (std::isfinite(rate.left_s)) json["left_s"] = rate.left_s;
  if (state.counts_successes) {
    const Success success = SuccessOf(state.outcomes);
    json["executed_grasps"] = success.executed_grasps;
    json["successes"] = success.successes;
    json["success_rate"] = success.rate();
    AddInterval(json, "success_ci95", success.ci95);
  }
  if (!state.note.empty()) json["note"] = state.note;
  return json.dump();
}

std::string FormatDuration(double seconds) {
  if (!std::isfinite(seconds) || seconds < 0) return "?";
  const long total = std::lround(seconds);
  const long hours = total / 3600, minutes = total / 60 % 60;
  if (hours > 0) return fmt::format("{}:{:02}:{:02}", hours, minutes, total % 60);
  return fmt::format("{}:{:02}", minutes, total % 60);
}

}  // namespace pickbed::eval
