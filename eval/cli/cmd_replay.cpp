#include <fmt/format.h>

#include <algorithm>

#include "eval/cli/arguments.h"
#include "eval/cli/commands.h"
#include "eval/export/pick_animation.h"
#include "eval/replay/replay.h"
#include "eval/replay/stage_files.h"
#include "eval/runtime/progress.h"
#include "eval/summary/result_files.h"
#include "scenes/base/error.h"
#include "scenes/base/files.h"

namespace pickbed::eval {
namespace {

constexpr int kDiffers = 1;

void SayWhatChanged(const RecordedTrial& recorded) {
  for (const std::string& change : recorded.changes) {
    fmt::print("changed since the trial ran: {}\n", change);
  }
  if (recorded.crashed) {
    fmt::print("no stage was recorded because the worker process of this trial crashed: {}\n",
               recorded.crashed->why);
  }
}

// Notifies several observers.
class Observers : public TrialObserver {
 public:
  Observers(TrialObserver& files, PickAnimation* animation)
      : files_(files), animation_(animation) {}

  void OnStage(TrialStage stage, const AttemptState& attempt) override {
    files_.OnStage(stage, attempt);
    if (animation_ != nullptr) animation_->OnStage(stage, attempt);
  }
  MotionListener ListenToMotion() override {
    return animation_ != nullptr ? animation_->ListenToMotion() : MotionListener();
  }

 private:
  TrialObserver& files_;
  PickAnimation* animation_;
};

// Throws InputError if the hand did not move in the trial or in this attempt.
void RequireMotion(const RecordedTrial& recorded, const std::string& address, int attempt) {
  CheckInput(!recorded.crashed,
             fmt::format("{}: the trial crashed, so there is no pick to animate", address));
  const auto& attempts = recorded.result.attempts;
  CheckInput(std::any_of(attempts.begin(), attempts.end(), UsedHand),
             fmt::format("{}: no attempt of the trial executed a grasp, so there is no pick to "
                         "animate; choose another trial",
                         address));
  if (attempt < 0) return;
  CheckInput(static_cast<size_t>(attempt) < attempts.size(),
             fmt::format("{}: --attempt {}: the trial has attempts 0 to {}", address, attempt,
                         attempts.size() - 1));
  CheckInput(UsedHand(attempts[attempt]),
             fmt::format("{}: --attempt {} executed no grasp; choose another of the {} attempts",
                         address, attempt, attempts.size()));
}

}  // namespace

int ReplayCommand(int argc, char** argv) {
  CLI::App app(
      "Repeats one trial from its record, compares the hash of each stage of each attempt, and "
      "names the first stage that differs. Writes all stages: pictures, point clouds (PLY) and the "
      "scene (GLB). The exit status is 1 if a stage differs.",
      "pickbed replay");
  std::string address_text, out, catalog = "objects";
  app.add_option("RUN#TRIAL", address_text,
                 "results folder and number of the trial, for example results/demo#2; with --list "
                 "the number is optional")
      ->required();
  app.add_option("--out", out, "folder for the files [RUN/replay/trial_NNNN]");
  app.add_option("--catalog", catalog, "folder with your own objects")->capture_default_str();
  bool animate = false;
  int only_attempt = -1;
  app.add_flag("--animate", animate,
               "also write an animation of each pick and stir: attempt_NN_pick.glb for 3D viewers "
               "and attempt_NN_pick.gif");
  app.add_option("--attempt", only_attempt, "number of the only attempt to animate, from 0 [all]")
      ->check(CLI::NonNegativeNumber)
      ->needs("--animate");
  bool verbose = false;
  app.add_flag("--verbose", verbose, "print the hashes of all stages, also of equal ones");
  bool programs = false;
  AddProgramsArgument(app, programs);
  bool list = false;
  app.add_flag(
         "--list", list,
         "only list the trials of the run: number, bin, attempts, successes and status (finished, "
         "crashed, or damaged with the reason)")
      ->excludes("--animate");
  app.footer("Example: pickbed replay results/demo#2 --animate --attempt 0");
  if (!ParseArguments(app, argc, argv)) return 0;

  if (list) {
    const bool numbered = address_text.find('#') != std::string::npos;
    fmt::print("{}", TrialList(numbered ? ParseTrialAddress(address_text).run
                                        : std::filesystem::path(address_text)));
    return 0;
  }
  const TrialAddress address = ParseTrialAddress(address_text);
  const RecordedTrial recorded = ReadRecordedTrial(address, catalog);
  RequireProgramsAllowed(recorded.spec, address_text, programs);
  SayWhatChanged(recorded);
  if (animate) RequireMotion(recorded, address_text, only_attempt);
  const std::filesystem::path folder =
      out.empty() ? address.run / kReplayFolder / fmt::format("trial_{:04}", address.trial)
                  : std::filesystem::path(out);
  StageFiles files(folder);
  PickAnimation animation(folder, /*with_gif=*/true, only_attempt);
  Observers observers(files, animate ? &animation : nullptr);
  ReplayReport report;
  {
    ProgressLine progress;
    report = ReplayTrial(recorded, &observers, [&](std::string_view what, double share) {
      progress.Show(fmt::format("{}: {}", what, WholePercentText(share)));
    });
  }
  WriteFileAtomically(folder / kStagesFile, ReplayCsv(report));
  fmt::print("{}stages in {}\n", ReplayTable(report, verbose), folder.string());
  if (animate) {
    fmt::print("{} animation{} in {}\n", animation.written(), animation.written() == 1 ? "" : "s",
               folder.string());
  }
  return report.FirstDifference() == nullptr ? 0 : kDiffers;
}

}  // namespace pickbed::eval
