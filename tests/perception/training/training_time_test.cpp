#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <cmath>
#include <filesystem>

#include "perception/training/training.h"
#include "perception/training/training_clock.h"
#include "tests/support/ray_cast_views.h"
#include "tests/support/synthetic_depth.h"
#include "tests/support/temporary_folder.h"

namespace pickbed::tests {
namespace {

// Seconds that the parts of a training take on a simulated machine.
struct Costs {
  double scene_s = 8;        // rendering of a scene
  double isolated_s = 0.01;  // rendering of an isolated view
  double step_s = 3;         // training step of the network
  double search_s = 5;       // search for candidates in a view
};

class SimulatedClock {
 public:
  void Advance(double seconds) { milliseconds_ += std::lround(1000 * seconds); }
  TrainingTime Now() const { return TrainingTime(std::chrono::milliseconds(milliseconds_)); }

 private:
  std::atomic<long> milliseconds_ = 0;
};

constexpr int kHeldOutScenes = 1, kNetworkScenes = 4;
constexpr int kScenesBeforeVerifier = kHeldOutScenes + kNetworkScenes;

// Views that take simulated time. Both threads share one clock, so the scenes of the verifier wait
// for the end of the network: a renderer that ran ahead would spend the time of the network.
class TimedViews : public RayCastViews {
 public:
  TimedViews(const Costs& costs, SimulatedClock& clock)
      : RayCastViews({ObjectOf(BracketMesh())}), costs_(costs), clock_(clock) {}
  std::vector<LabelledView> Isolated(ObjectId object, const std::vector<Pose>& X_CO,
                                     const CameraIntrinsics& camera, uint64_t seed) override {
    clock_.Advance(costs_.isolated_s * static_cast<double>(X_CO.size()));
    return RayCastViews::Isolated(object, X_CO, camera, seed);
  }
  std::vector<LabelledView> ClutterScene(const ClutterSceneRequest& request) override {
    if (scenes_ >= kScenesBeforeVerifier) network_done_.wait(false);
    clock_.Advance(costs_.scene_s);
    ++scenes_;
    return RayCastViews::ClutterScene(request);
  }
  int scenes() const { return scenes_; }
  void EndNetwork() {
    network_done_ = true;
    network_done_.notify_all();
  }

 private:
  Costs costs_;
  SimulatedClock& clock_;
  std::atomic<int> scenes_ = 0;
  std::atomic<bool> network_done_ = false;
};

// A training that ends only because of its time limit.
TrainingOptions LimitedOptions(double minutes) {
  TrainingOptions options;
  options.max_minutes = minutes;
  options.clutter_scenes = kNetworkScenes;
  options.views_per_scene = 3;
  options.positive_pairs.patches_per_view = 60;
  options.iterations = 100000;
  options.batch = 16;
  options.network.descriptor = 8;
  options.held_out.clutter_scenes = kHeldOutScenes;
  options.held_out.queries = 20;
  options.held_out.book_views = 10;
  options.held_out.every = 100;
  options.held_out.patience = 0;
  options.verifier_clutter_scenes = options.verifier_room_scenes = 1000;
  options.verifier_entries = 480;
  options.verifier.iterations = 20;
  options.candidates.points = 40;
  options.candidates.candidates = options.candidates.min_candidates = 20;
  options.candidates.ambiguous_candidates = 2;
  options.fast_candidates = options.candidates;
  return options;
}

struct TimedTraining {
  double seconds = 0;  // simulated, since the start that the caller gave
  int steps = 0;       // of the network
  int reports = 0;     // of the verifier, after each view in which candidates were found
  int scenes = 0;
};

TimedTraining Train(const Costs& costs, double minutes, double prepared_s) {
  SimulatedClock clock;
  TimedViews views(costs, clock);
  const TemporaryFolder folder;
  TimedTraining timed;
  TrainingJob job{views, folder.path() / "model.net", {}, false, {}, "test sensor", {}};
  job.began = clock.Now();
  job.now = [&] { return clock.Now(); };
  clock.Advance(prepared_s);
  int shown = 0;
  job.on_progress = [&](const TrainingProgress& progress) {
    if (progress.phase == "network") clock.Advance(costs.step_s);
    if (progress.phase == "verifier") views.EndNetwork();
    if (progress.phase == "verifier" && progress.done > shown && progress.done < progress.total) {
      shown = progress.done;
      ++timed.reports;
      clock.Advance(costs.search_s);
    }
    return true;
  };
  const TrainingReport report = TrainDescriptor(job, LimitedOptions(minutes));
  EXPECT_TRUE(report.finished);
  EXPECT_TRUE(std::filesystem::exists(job.model_file));
  timed.seconds = SecondsBetween(*job.began, clock.Now());
  timed.steps = static_cast<int>(report.loss_history.size());
  timed.scenes = views.scenes();
  return timed;
}

// Rendering, network and verifier share one time limit, on any machine. The time before the
// training counts, too.
TEST(TrainingTime, LimitHoldsForAllPartsTogether) {
  constexpr double kMinutes = 10, kPrepared_s = 40;
  for (const double slowness : {1.0, 2.5}) {
    SCOPED_TRACE(slowness);
    const Costs costs{8 * slowness, 0.01 * slowness, 3 * slowness, 5 * slowness};
    const TimedTraining timed = Train(costs, kMinutes, kPrepared_s);
    EXPECT_GT(timed.seconds, 0.9 * 60 * kMinutes);
    EXPECT_LE(timed.seconds, 60 * kMinutes);
    EXPECT_GT(timed.steps, 2);
    EXPECT_GT(timed.reports, 9);
  }
}

// Searching is slow beside rendering: with the last views of each scene, it would take three times
// the time that is left.
TEST(TrainingTime, SlowSearchesStayWithinTheLimit) {
  const TimedTraining timed = Train({4, 0.01, 3, 20}, 10, 0);
  EXPECT_LE(timed.seconds, 600);
  EXPECT_GT(timed.seconds, 0.9 * 600);
}

// Each part does its smallest useful amount, even if there is no time.
TEST(TrainingTime, TooShortLimitDoesTheSmallestAmount) {
  const TimedTraining timed = Train({}, 0.5, 0);
  EXPECT_GT(timed.seconds, 30);
  // One held-out scene, at least one scene of the network, four with a bin and four rooms.
  EXPECT_GE(timed.scenes, 10);
  EXPECT_LE(timed.scenes, 13);
  // One view of each of the four clutter scenes, the begin of the rooms, and all but the last of
  // the four rooms, which have one view each.
  EXPECT_EQ(timed.reports, 8);
}

}  // namespace
}  // namespace pickbed::tests
