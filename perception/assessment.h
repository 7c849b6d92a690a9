#pragma once

// From raw pose hypotheses to refined candidates that a verifier can judge: quick score and density
// -> clusters -> ICP -> look-alikes -> features. Whatever proposes the raw poses, descriptors or
// point pairs, goes on through it alike, so that what differs is the proposal alone.

#include <vector>

#include "perception/candidate_comparison.h"
#include "perception/estimate_trace.h"
#include "perception/pose_embedding.h"
#include "perception/projective_icp.h"
#include "perception/vote_density.h"
#include "perception/votes.h"
#include "scenes/settings.h"
#include "scenes/stage_seconds.h"

namespace pickbed {

struct AssessmentOptions {
  int candidates = 300;        // refined by ICP, of all parts together
  int min_candidates = 100;    // for each part at least
  double quick_tau_m = 0.008;  // band of the quick score
  // A vote's rank is its quick score plus this times log(1 + density of the other patches' votes).
  double density_weight = 0.2;
  double density_diameters = 0.2;  // votes within it count for the density
  // Votes within it (largest displacement) are one candidate. As wide as ICP can reach: half of it
  // gives four thousand clusters a frame, of which the best six hundred miss half of the hidden
  // parts.
  double cluster_diameters = 0.25;
  double gate_diameters = 0.08;  // first gate of ICP
  double gate_min_m = 0.004;     // bounds of that gate: wide ones slide into clutter
  double gate_max_m = 0.010;     //
  bool two_gates = false;        // also try half the gate and keep the better
  // Of this many of the best refined poses, of all parts together, the look-alikes are tried, and
  // those refined for which there is most evidence; two poses of a place at most.
  int turned = 12;
  int look_alikes = 3;
  int drawn = 12;  // look-alikes of a pose whose evidence is measured, by quick score
  // Refined poses of a lower quick score are no candidates; the others are refined once more, by
  // more of their points.
  double least_quick_score = 0.05;
  int fine_points = 512;
  int fine_steps = 10;
  double merge_diameters = 0.03;  // refined poses within it are one
  int evidence_pixels = 6000;     // of a candidate looked at for evidence; look-alikes take fewer
  ProjectiveIcpOptions icp;       // its gates are set from the above
  void Visit(SettingsVisitor& v);
};

class CandidateAssessor {
 public:
  // Results are the same for any number of threads.
  CandidateAssessor(const ObjectSet& objects, const AssessmentOptions& options, int threads = 1);

  // Candidates from the raw poses `votes` of objects[part]; hypothesis.object = part. `patches` is
  // how many patches (or reference points) voted: densities are told to the verifier as of a usual
  // number. `share` is that of the poses of votes that may be refined. A trace gets the
  // refinements. Seconds are added under "quick", "select", "icp", "look_alikes" and "verify".
  std::vector<Candidate> Assess(const OrganizedCloud& cloud, int part,
                                const std::vector<PoseVote>& votes, int patches, double share,
                                StageSeconds& seconds, EstimateTrace* trace = nullptr) const;
  // Where the raw poses were made of votes that agree: densities are those of `cast`.
  std::vector<Candidate> Assess(const OrganizedCloud& cloud, int part,
                                const std::vector<PoseVote>& votes,
                                const std::vector<PoseVote>& cast, int patches, double share,
                                StageSeconds& seconds, EstimateTrace* trace = nullptr) const;

  // Of the pixels, those that no candidate explains well.
  std::vector<int> Unexplained(const OrganizedCloud& cloud,
                               const std::vector<Candidate>& candidates,
                               const std::vector<int>& pixels) const;

  // Fills in margins and overlaps of the features, once all candidates are known.
  void Compare(std::vector<Candidate>& candidates, StageSeconds& seconds) const;

  // By object.
  const std::vector<ModelPoints>& model_points() const { return models_; }
  const std::vector<PoseDistance>& distances() const { return distances_; }

 private:
  std::vector<RawHypothesis> QuickScored(const OrganizedCloud& cloud, int part,
                                         const std::vector<PoseVote>& votes) const;
  VoteDensity Density(int part, const std::vector<PoseVote>& votes) const;
  std::vector<RawHypothesis> Selected(std::vector<RawHypothesis> scored, const VoteDensity& density,
                                      const std::vector<PoseVote>& votes, int kept) const;
  RawHypothesis Refined(const OrganizedCloud& cloud, const RawHypothesis& start) const;
  void RefineFinely(const OrganizedCloud& cloud, RawHypothesis& pose) const;
  std::vector<RawHypothesis> AllRefined(const OrganizedCloud& cloud,
                                        const std::vector<RawHypothesis>& starts, bool look_alikes,
                                        EstimateTrace* trace) const;
  std::vector<RawHypothesis> Merged(std::vector<RawHypothesis> poses, size_t most) const;
  void AddLookAlikes(const OrganizedCloud& cloud, EstimateTrace* trace,
                     std::vector<RawHypothesis>& poses) const;
  std::vector<Pose> BestLookAlikes(const OrganizedCloud& cloud, const RawHypothesis& start,
                                   EvidenceScratch& scratch) const;
  std::vector<Candidate> WithFeatures(const OrganizedCloud& cloud,
                                      const std::vector<RawHypothesis>& poses,
                                      const VoteDensity& density, int patches) const;
  int Kept(double share) const;
  int Turned() const;  // best poses of one part whose look-alikes are tried

  ObjectSet objects_;
  AssessmentOptions options_;
  int threads_;
  std::vector<ModelPoints> models_;
  std::vector<DepthEvidenceOf> evidence_;
  std::vector<PoseDistance> distances_;
  std::vector<PoseEmbedding> embeddings_;
  std::vector<std::vector<Pose>> look_alikes_;  // turns S_O, by object
};

}  // namespace pickbed
