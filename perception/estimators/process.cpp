#include "perception/estimators/process.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>

#include "scenes/base/error.h"
#include "scenes/base/files.h"
#include "scenes/plugin/plugin_client.h"
#include "scenes/plugin/plugin_messages.h"

namespace pickbed::perception {
namespace {

PluginAddress AddressOf(const EstimatorSetup& setup) {
  return {setup.spec.command, setup.spec.connect, setup.spec.timeout_s, setup.log_dir};
}

// The minimum score does not apply to raw scores, whose scale is unknown.
double MinScore(const EstimatorSpec& spec) {
  return HasRawScores(spec) ? -std::numeric_limits<double>::infinity() : spec.min_score;
}

PluginSetup MessageOf(const EstimatorSetup& setup, const ObjectSet& objects,
                      const std::optional<Bin>& bin) {
  PluginSetup message{objects};
  message.intrinsics = setup.intrinsics;
  message.working_distance_m = setup.working_distance_m;
  message.bin = bin ? &*bin : nullptr;
  message.min_score = MinScore(setup.spec);
  message.model = setup.spec.model;
  message.mode = setup.spec.mode;
  return message;
}

class ProcessEstimator : public PoseEstimator {
 public:
  explicit ProcessEstimator(const EstimatorSetup& setup)
      : objects_(setup.objects),
        bin_(setup.bin),
        scores_(HasRawScores(setup.spec) ? PluginScores::kAny : PluginScores::kProbabilities),
        min_score_(MinScore(setup.spec)),
        working_distance_m_(setup.working_distance_m),
        client_(AddressOf(setup), "estimator", [&](MessageWriter& message) {
          WriteSetup(MessageOf(setup, objects_, bin_),
                     (setup.cache_dir.empty() ? CacheDir() : setup.cache_dir) / kPluginMeshesFolder,
                     message);
        }) {}

  EstimateResult Estimate(const EstimatorInput& input, Rng& rng) override {
    RequireNeeds(input);
    EstimateResult result;
    try {
      result.hypotheses = Ask(input, rng, result.seconds);
    } catch (const PluginError& error) {
      const std::string text =
          fmt::format("estimator '{}' {}", client_.identity().name, error.what());
      if (input.is_first && error.fault == PluginFault::kMalformed) throw InputError(text);
      result.failure = {error.fault == PluginFault::kTimeout ? FailureReason::kEstimatorTimeout
                                                             : FailureReason::kEstimatorCrashed,
                        text, error.traceback};
    }
    return result;
  }

 private:
  // Throws InputError if the images lack what the program needs.
  void RequireNeeds(const EstimatorInput& input) const {
    const auto require = [&](const char* need, bool is_there, const char* remedy) {
      const auto& needs = client_.identity().needs;
      CheckInput(
          is_there || std::find(needs.begin(), needs.end(), need) == needs.end(),
          fmt::format("estimator '{}' needs '{}'; {}", client_.identity().name, need, remedy));
    };
    require(kNeedsColor, !input.frame.color.empty(), "the images have no color");
    require(kNeedsBin, input.background.has_value(), "the pose of the bin is unknown");
    require(kNeedsCounts, !input.instances.empty(),
            "the number of instances is known only for BOP images in the task localisation");
  }

  std::vector<PoseHypothesis> Ask(const EstimatorInput& input, Rng& rng, StageSeconds& seconds) {
    PluginFrame frame{input.frame};
    frame.X_WC = input.X_WC;
    if (input.background) frame.X_CB = input.background->X_CB;
    frame.counts = input.instances;
    frame.seed = rng.Next();
    MessageWriter request;
    WriteEstimate(frame, objects_, request);
    const StageTimer timer(seconds, "process");
    return Hypotheses(
        ReadPoses(client_.Ask(request), objects_, working_distance_m_, nullptr, scores_),
        input.instances);
  }

  // Keeps the best poses, at most as many per object as there are instances.
  std::vector<PoseHypothesis> Hypotheses(std::vector<PluginPose> poses,
                                         const std::vector<int>& instances) const {
    std::stable_sort(poses.begin(), poses.end(),
                     [](const auto& a, const auto& b) { return a.score > b.score; });
    std::vector<int> left = instances;
    std::vector<PoseHypothesis> hypotheses;
    for (const PluginPose& pose : poses) {
      if (pose.score < min_score_ || (!left.empty() && left[pose.object]-- <= 0)) continue;
      PoseHypothesis& hypothesis = hypotheses.emplace_back();
      hypothesis.object = pose.object;
      hypothesis.X_CO = pose.X_CO;
      hypothesis.score = pose.score;
    }
    return hypotheses;
  }

  ObjectSet objects_;       // the setup message refers to them
  std::optional<Bin> bin_;  // known to the program
  PluginScores scores_;
  double min_score_;
  double working_distance_m_;
  PluginClient client_;
};

}  // namespace

std::unique_ptr<PoseEstimator> MakeProcessEstimator(const EstimatorSetup& setup) {
  return std::make_unique<ProcessEstimator>(setup);
}

}  // namespace pickbed::perception
