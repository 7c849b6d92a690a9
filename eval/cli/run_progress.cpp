#include "eval/cli/run_progress.h"

#include <fmt/format.h>

#include <memory>
#include <stdexcept>

#include "eval/summary/setting_notes.h"
#include "grasp/grippers/tools.h"
#include "scenes/base/ids_format.h"
#include "sim/convex/convex_pieces.h"
#include "sim/drop/resting_poses.h"

namespace pickbed::eval {

ProgressState ProgressOf(const RunState& state) {
  ProgressState shown;
  shown.done = state.done;
  shown.total = state.total;
  shown.done_before = state.done_before;
  shown.counts_successes = true;
  shown.outcomes = state.trials;
  shown.note = state.stop;
  if (state.crashed > 0) {
    shown.note += fmt::format("{}{} crashed", shown.note.empty() ? "" : ", ", state.crashed);
  }
  return shown;
}

RunListener ShowOn(ProgressLine& progress, const std::function<bool()>& stop) {
  auto last = std::make_shared<ProgressState>();
  RunListener listener;
  listener.on_trial = [&progress, last](const RunState& state) {
    *last = ProgressOf(state);
    progress.Show(*last);
  };
  listener.on_message = [&progress, last](const std::string& line) {
    if (last->total == 0) return progress.Show(line);
    ProgressState noted = *last;
    noted.note = line;
    progress.Show(noted);
  };
  listener.on_warning = [&progress](const std::string& line) { progress.Note(line); };
  listener.stop = stop;
  return listener;
}

ObjectProgress ShowObjectsOn(ProgressLine& progress) {
  constexpr double kShort_s = 2;
  return [&progress](int done, int total) {
    if (done == 1) progress.Restart();
    if (progress.elapsed_s() < kShort_s) return;
    ProgressState state;
    state.what = "object";
    state.done = done;
    state.total = total;
    progress.Show(state);
  };
}

std::string UnfitTools(const ScenarioSpec& spec, const ObjectSet& objects) {
  if (spec.gripper.names.size() == 1 || !NeedsPoses(spec)) return {};
  ObjectSet wanted;
  for (size_t i = 0; i < objects.size(); ++i) {
    if (!spec.objects[i].distractor) wanted.push_back(objects[i]);
  }
  return WithSettingsKey(spec, "gripper", [&] {
    return UnfitToolsText(WithRestingDirections(WithConvexPieces(wanted)),
                          LoadTools(spec.gripper.names), spec.At("gripper"));
  });
}

void RequireNoCrash(const std::vector<CrashedTrial>& crashed) {
  if (crashed.empty()) return;
  const CrashedTrial& first = crashed.front();
  const std::string message = fmt::format(
      "{} trials crashed twice and are recorded as crashed, the first is trial {} "
      "(seed {}, scene {}): {}; --resume --retry-crashed repeats them",
      crashed.size(), first.trial, first.seed, first.bin_index, first.why);
  const bool lack_memory =
      std::all_of(crashed.begin(), crashed.end(),
                  [](const CrashedTrial& trial) { return LacksMemory(trial.why); });
  CheckInput(!lack_memory, message);
  throw std::runtime_error(message);
}

}  // namespace pickbed::eval
