#include "eval/sweep/trial_worker.h"

#include <fmt/format.h>

#include <chrono>
#include <cstdio>
#include <memory>

#include "eval/stats/statistics.h"
#include "eval/sweep/attempt_pictures.h"
#include "eval/sweep/run_images.h"
#include "eval/trial/counts_by_bin.h"

namespace pickbed::eval {
namespace {

constexpr std::chrono::seconds kSayEvery{2};

// State of a worker: its store, and the data of its current configuration.
struct WorkerState {
  ResultsStore store;
  StageSeconds seconds;  // since the last reply
  const Configuration* configuration = nullptr;
  DoTrial do_trial = nullptr;
};

// Reply line of a finished trial: executed grasps, successes, seconds.
std::string ReplyOf(const Cluster& outcome, StageSeconds& seconds) {
  return fmt::format("{} {} {} {} {}", outcome.samples, outcome.hits, seconds["start"],
                     seconds["trials"], seconds["store"]);
}

void GoTo(const Configuration& configuration, const SweepOptions& options,
          const WorkerPlan::Say& say, WorkerState& state) {
  if (state.configuration == &configuration) return;
  const StageTimer timer(state.seconds, "start");
  state.do_trial = nullptr;  // frees the meshes and networks of the previous configuration first
  state.do_trial = options.make(configuration, say);
  state.configuration = &configuration;
}

std::string DoItem(WorkerState& state, const Configuration& configuration,
                   const SweepOptions& options, int trial, const WorkerPlan::Say& say) {
  // An earlier worker may have been killed after it stored the trial and before its reply.
  if (const auto stored = state.store.OutcomeOf(trial)) {
    StageSeconds seconds;
    std::swap(seconds, state.seconds);
    return ReplyOf(*stored, seconds);
  }
  GoTo(configuration, options, say, state);
  const BinIndex bin_index(trial - configuration.first_trial);
  PictureOrder pictures{PicturesWanted::kNone, PicturesOf(options.out, trial)};
  if (bin_index < options.picture_trials) {
    pictures.wanted = PicturesWanted::kAll;
  } else if (bin_index < options.failure_picture_trials) {
    pictures.wanted = PicturesWanted::kOfFailedPicks;
  }
  TrialResult result;
  {
    const StageTimer timer(state.seconds, "trials");
    result = state.do_trial(bin_index, pictures);
  }
  result.trial = trial;
  result.bin_index = bin_index;
  result.configuration = configuration.number;
  {
    const StageTimer timer(state.seconds, "store");
    state.store.Write(result);
  }
  StageSeconds seconds;
  std::swap(seconds, state.seconds);
  Cluster outcome;
  SuccessOfAttempts()(result, outcome);
  return ReplyOf(outcome, seconds);
}

// Notifies the writer of the images and the observer that makes pictures, which may be null.
class WithImages : public TrialObserver {
 public:
  WithImages(TrialObserver* pictures, RunImageWriter& images)
      : pictures_(pictures), images_(images) {}
  void OnStage(TrialStage stage, const AttemptState& attempt) override {
    images_.OnStage(stage, attempt);
    if (pictures_ != nullptr) pictures_->OnStage(stage, attempt);
  }
  MotionListener ListenToMotion() override {
    return pictures_ != nullptr ? pictures_->ListenToMotion() : MotionListener();
  }

 private:
  TrialObserver* pictures_;
  RunImageWriter& images_;
};

}  // namespace

Cluster TakeReply(const std::string& reply, StageSeconds& seconds) {
  Cluster outcome;
  double start_s = 0, trial_s = 0, store_s = 0;
  std::sscanf(reply.c_str(), "%d %d %lf %lf %lf", &outcome.samples, &outcome.hits, &start_s,
              &trial_s, &store_s);
  seconds["start"] += start_s;
  seconds["trials"] += trial_s;
  seconds["store"] += store_s;
  return outcome;
}

WorkerPlan::DoItem StartWorker(const Sweep& sweep, const SweepOptions& options,
                               const StoreHead& head, const std::filesystem::path& folder,
                               const WorkerPlan::Say& say) {
  StageSeconds seconds;
  const auto open = [&] {
    const StageTimer timer(seconds, "store");
    return ResultsStore(folder, head);
  };
  auto state = std::make_shared<WorkerState>(WorkerState{open(), {}});
  state->seconds = seconds;
  // With several configurations, the first trial decides which one is prepared.
  if (sweep.configurations.size() == 1) GoTo(sweep.configurations.front(), options, say, *state);
  return [state, &sweep, &options, say](int trial) {
    return DoItem(*state, ConfigurationOf(sweep, trial), options, trial, say);
  };
}

MakeDoTrial PickingTrials(const TrialOptions& trial_options, const std::filesystem::path& bop_out) {
  return [trial_options, bop_out](const Configuration& configuration,
                                  const WorkerPlan::Say& say) -> DoTrial {
    using Clock = std::chrono::steady_clock;
    const auto on_progress = [say, said = Clock::time_point()](std::string_view what,
                                                               double share) mutable {
      if (Clock::now() - said < kSayEvery) return;
      said = Clock::now();
      say(fmt::format("{}: {}", what, WholePercentText(share)));
    };
    TrialOptions own_options = trial_options;
    own_options.on_warning = say.warning;
    auto runner = std::make_shared<TrialRunner>(configuration.spec, configuration.objects,
                                                on_progress, own_options);
    return [runner, bop_out, seed = configuration.spec.seed](BinIndex bin_index,
                                                             const PictureOrder& order) {
      PickPictures all(order.folder);
      FailedPickPictures failed(order.folder);
      TrialObserver* pictures = nullptr;
      if (order.wanted == PicturesWanted::kAll) pictures = &all;
      if (order.wanted == PicturesWanted::kOfFailedPicks) pictures = &failed;
      if (bop_out.empty()) return runner->Run(bin_index, pictures);
      RunImageWriter images(bop_out, seed, bin_index);
      WithImages both(pictures, images);
      TrialResult result = runner->Run(bin_index, &both);
      images.Finish();
      return result;
    };
  };
}

}  // namespace pickbed::eval
