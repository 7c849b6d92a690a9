#pragma once

// Poses of an explained image against the truth, and the stage at which each part was lost.

#include <limits>
#include <string>
#include <vector>

#include "eval/matching.h"
#include "eval/metrics.h"
#include "perception/estimate_trace.h"

namespace pickbed {

struct TruePart {
  int object = 0;
  Pose X_CO = Pose::Identity();
  double visible_fraction = 1;
};

struct PoseVerdict {
  int part = -1;  // the nearest of its kind; -1 = there is none
  double diameters = std::numeric_limits<double>::infinity();  // MSSD
  bool right() const { return diameters < kCorrectDiameters; }
};

// Errors of many thousand poses: MSSD over the few hundred vertices that lie farthest out.
class PoseJudge {
 public:
  PoseJudge(const ObjectSet& objects, std::vector<TruePart> parts);

  PoseVerdict operator()(int object, const Pose& X_CO) const;
  const std::vector<TruePart>& parts() const { return parts_; }

 private:
  std::vector<MetricModel> models_;
  std::vector<Eigen::Vector3d> means_O_;
  std::vector<TruePart> parts_;
};

// Of poses in falling order of score: right ones each take a part; a second one on a part is none.
enum class Verdict { kUnknown, kRight, kSecond, kWrong };
std::vector<Verdict> JudgeSet(const PoseJudge& judge,
                              const std::vector<PoseHypothesis>& hypotheses);

// The first stage after which nothing was left that would have found the part.
enum class LostAt {
  kFound,
  kHardlyVisible,  // it need not be found
  kPoints,         // no patch was cut on it
  kVotes,          // no vote in ICP's reach
  kSelection,      // such votes, but none was chosen to be refined
  kIcp,            // refined, but to a wrong pose
  kMerging,        // refined to the right pose, which was no candidate of its own
  kVerifier,       // the right candidate scored too low
  kFinalSet,       // it gave way to another
  kCount,          // as many of the object as were told of scored higher
  kRefiner,        // the final refiner moved it away
};
// One word or two, and a sentence.
struct LostAtText {
  const char* name;
  const char* help;
};
LostAtText TextOf(LostAt lost);

// Whether the estimator was told how many of the object there are, and as many poses of it were
// accepted with at least this score.
bool CountUsedUp(const EstimateTrace& trace, int object, double score);

// Votes within this of a part's pose are in ICP's reach, in diameters (MSSD).
inline constexpr double kReachDiameters = 0.25;

struct PartFate {
  int points = 0;                                               // patches on its surface
  int votes_near = 0, votes_right = 0;                          // in ICP's reach; right
  double best_start = std::numeric_limits<double>::infinity();  // error, diameters, before ICP
  double best_refined = std::numeric_limits<double>::infinity();
  double best_score = -1;  // of right candidates; -1 = there is none
  LostAt lost = LostAt::kFound;
};

// By part. `vote_errors` of trace.votes; `hypotheses` is the estimator's answer.
std::vector<PartFate> FatesOf(const PoseJudge& judge, const EstimateTrace& trace,
                              const std::vector<PoseVerdict>& vote_errors,
                              const std::vector<ModelPoints>& models,
                              const std::vector<PoseHypothesis>& hypotheses);

}  // namespace pickbed
