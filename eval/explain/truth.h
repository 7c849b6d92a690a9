#pragma once

// Compares the poses of an explained image with ground truth, and finds the stage that fails for
// each instance.

#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "eval/metrics/pose_errors.h"
#include "eval/trial/instance_matcher.h"
#include "perception/candidates/estimate_trace.h"
#include "scenes/base/ids.h"

namespace pickbed::eval {

// Computes the errors of many thousand poses. For speed, MSSD uses only the 300 vertices that are
// farthest out.
class PoseJudge {
 public:
  PoseJudge(const ObjectSet& objects, std::vector<TrueInstance> instances);

  // Returns the nearest instance of the object.
  InstanceMatch operator()(ObjectId object, const Pose& X_CO) const {
    return matcher_.Nearest(object, X_CO);
  }
  const std::vector<TrueInstance>& instances() const { return matcher_.instances(); }

 private:
  std::shared_ptr<const std::vector<MetricModel>> models_;  // shared by copies of this object
  InstanceMatcher matcher_;
};

// Correctness of a reported pose. Each correct pose takes an instance; a further correct pose of
// the same instance is kSecond.
enum class Verdict { kUnknown, kRight, kSecond, kWrong };
// Judges poses, which must be sorted by descending score.
std::vector<Verdict> JudgeSet(const PoseJudge& judge,
                              const std::vector<PoseHypothesis>& hypotheses);

// First stage after which no data was left that leads to a correct pose of the instance.
enum class FailingStage {
  kFound,          // no stage failed
  kHardlyVisible,  // under 10 % visible: it need not be found
  kPoints,         // no patch was cut on it
  kVotes,          // no vote within ICP's reach
  kSelection,      // votes within reach, but none was selected for refinement
  kIcp,            // refined, but to a wrong pose
  kMerging,        // refined to the correct pose, but merged into another candidate
  kVerifier,       // the correct candidate scored too low
  kPoseSelection,  // the correct candidate was suppressed by another one
  kCount,          // as many poses of the object as the given count scored higher
  kRefiner,        // the final refinement moved the pose away
};
// Name of the stage, and a sentence of explanation.
struct FailingStageText {
  const char* name;
  const char* help;
};
// Returns the name and the sentence of a stage.
FailingStageText TextOf(FailingStage stage);

// Returns whether the number of instances of the object was given to the estimator, and at least
// that many of its poses were accepted with at least this score.
bool CountUsedUp(const EstimateTrace& trace, ObjectId object, double score);

// A vote is within ICP's reach if its MSSD to the true pose is below this many diameters.
inline constexpr double kReachDiameters = 0.25;

// Evidence for one instance at each stage. Errors are MSSD in diameters.
struct InstanceDiagnosis {
  int points = 0;                       // patches on its surface
  int votes_near = 0, votes_right = 0;  // votes within ICP's reach; correct votes
  double best_start = std::numeric_limits<double>::infinity();    // smallest error before ICP
  double best_refined = std::numeric_limits<double>::infinity();  // smallest error after ICP
  double best_score = -1;  // highest score of a correct candidate; -1 = none
  FailingStage failing_stage = FailingStage::kFound;
};

// Returns one entry per instance of `judge`. `vote_errors` has one entry per trace.votes; `models`
// has one entry per object; `hypotheses` are the reported poses.
std::vector<InstanceDiagnosis> DiagnoseInstances(const PoseJudge& judge, const EstimateTrace& trace,
                                                 const std::vector<InstanceMatch>& vote_errors,
                                                 const std::vector<ModelPoints>& models,
                                                 const std::vector<PoseHypothesis>& hypotheses);

}  // namespace pickbed::eval
