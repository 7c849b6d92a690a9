#include "eval/calibrate/samples.h"

#include <fmt/format.h>

#include <algorithm>

#include "eval/store/results_store.h"
#include "eval/store/store_check.h"
#include "eval/summary/result_files.h"
#include "eval/sweep/run.h"
#include "eval/trial/oracle_estimator.h"
#include "scenes/base/error.h"
#include "scenes/scenario/scenario_text.h"

namespace pickbed::eval {
namespace {

// The configuration with this number, or the only one.
const StoredConfiguration& ChosenConfiguration(const std::string& run, const StoreHead& head,
                                               std::optional<int> number) {
  CheckInput(number || head.configurations.size() == 1,
             fmt::format("{} has {} configurations; choose one by its number ({} lists "
                         "them)",
                         run, head.configurations.size(), kConfigurationsFile));
  for (const StoredConfiguration& configuration : head.configurations) {
    if (!number || configuration.number == *number) return configuration;
  }
  throw InputError(fmt::format("{} has no configuration {}; the numbers are 0 to {}", run, *number,
                               head.configurations.size() - 1));
}

void RequireOwnScores(const std::string& run, const StoredConfiguration& configuration,
                      const EstimatorSpec& estimator) {
  CheckInput(estimator.name != kOracleName,
             fmt::format("{}: its estimator is the oracle, whose score is the visible fraction; "
                         "calibrate a run of a real estimator",
                         run));
  CheckInput(
      TruthIn(configuration.identity) == OracleStages(),
      fmt::format("{}: stages of it were replaced by ground truth; calibrate the run that was "
                  "repeated",
                  run));
  CheckInput(estimator.calibration.empty(),
             fmt::format("{}: its scores are calibrated already by {}; calibrate a run without "
                         "estimator.calibration",
                         run, estimator.calibration));
}

}  // namespace

CalibrationSamples SamplesOf(const std::vector<TrialResult>& trials) {
  CalibrationSamples samples;
  for (const TrialResult& trial : trials) {
    std::vector<ScoredOutcome> poses, picks;
    for (const AttemptRecord& attempt : trial.attempts) {
      if (attempt.has_own_image()) {
        for (const HypothesisRecord& pose : attempt.hypotheses) {
          poses.push_back({pose.raw_score, pose.correct});
        }
      }
      if (!attempt.grasp || attempt.chosen < 0) continue;
      picks.push_back({attempt.hypotheses.at(attempt.chosen).raw_score,
                       attempt.failure == FailureReason::kNone});
    }
    if (poses.empty()) continue;
    samples.poses.push_back(std::move(poses));
    samples.picks.push_back(std::move(picks));
  }
  return samples;
}

CalibrationSamples ReadSamples(const std::filesystem::path& run, std::optional<int> configuration) {
  const ResultsStore store = ResultsStore::OpenToRead(run);
  const StoredConfiguration& chosen =
      ChosenConfiguration(run.string(), store.head(), configuration);
  const ScenarioSpec spec = ScenarioOfText(chosen.settings, run, "settings of " + run.string());
  RequireOwnScores(run.string(), chosen, spec.estimator);
  const std::vector<TrialResult> trials =
      store.Read(chosen.first_trial, chosen.first_trial + chosen.trials);
  for (const TrialResult& trial : trials) {
    CheckTrial(trial, {spec.objects.size(), spec.occlusion.bands.size()},
               (run / kStoreFile).string());
  }
  const bool has_poses = std::any_of(trials.begin(), trials.end(), [](const TrialResult& trial) {
    return std::any_of(trial.attempts.begin(), trial.attempts.end(),
                       [](const AttemptRecord& attempt) { return !attempt.pose_free; });
  });
  CheckInput(has_poses || trials.empty(),
             fmt::format("{}: its planner {} works without poses, so there are no scores of poses; "
                         "calibrate a run with an estimator",
                         run.string(), spec.planner.name));
  CalibrationSamples samples = SamplesOf(trials);
  samples.run = run.string();
  samples.estimator = spec.estimator;
  return samples;
}

}  // namespace pickbed::eval
