#pragma once

// Candidate refinement, from raw pose hypotheses to candidates for the verifier: quick score and
// vote density, clustering, ICP, ambiguous poses, features. All estimators that vote share it, with
// descriptors or point pairs, so they differ only in how raw poses are proposed.

#include <vector>

#include "perception/candidates/candidate_comparison.h"
#include "perception/candidates/estimate_trace.h"
#include "perception/icp/projective_icp.h"
#include "perception/model/pose_distance.h"
#include "perception/voting/pose_clustering.h"
#include "perception/voting/vote_density.h"
#include "scenes/base/ids.h"
#include "scenes/base/settings.h"
#include "scenes/base/stage_timer.h"

namespace pickbed::perception {

// Options of candidate refinement.
struct CandidateRefinementOptions {
  // The numbers of patches, candidates and ambiguous candidates are for up to this many visible
  // instances. A scene that shows more of them (see search_effort.h) gets proportionally more.
  double usual_instances = 20;
  int candidates = 300;      // poses refined by ICP, all objects together
  int min_candidates = 100;  // minimum number per object
  // If only planes of the background are found, many votes are on walls and other surfaces. The
  // numbers of candidates and ambiguous candidates are multiplied by this factor then. If nothing
  // is found, they are not: the scores would become unreliable.
  double fitted_background_factor = 3;
  double quick_tau_m = 0.008;  // depth band of the quick score
  // The rank of a vote is its quick score plus density_weight * log(1 + density). The density does
  // not count votes of the same patch.
  double density_weight = 0.2;
  double density_diameters = 0.2;  // kernel radius of the vote density
  // Votes within this pose distance (maximum displacement) are one candidate. It is as wide as the
  // convergence range of ICP. Half of it gives four thousand clusters per frame, and the best six
  // hundred miss half of the occluded instances.
  double cluster_diameters = 0.25;
  // Maximum correspondence distance at the start of ICP, in diameters, and its bounds. With a large
  // distance the pose slides into clutter.
  double correspondence_distance_diameters = 0.08;
  double min_correspondence_distance_m = 0.004;
  double max_correspondence_distance_m = 0.010;
  bool two_correspondence_distances = false;  // also try half of it and keep the better result
  // Number of refined poses, best first, whose ambiguous poses are tried; all objects together, at
  // most two poses per place.
  int ambiguous_candidates = 12;
  int ambiguous_poses = 3;  // ambiguous poses refined per pose, by decreasing evidence
  int drawn = 12;           // ambiguous poses per pose whose evidence is measured, by quick score
  // Whether the ambiguous poses of the pose with most evidence at each place are tried, too.
  bool rivals_of_best = false;
  // Refined poses with a lower quick score are dropped. The others are refined again with more
  // points.
  double min_quick_score = 0.05;
  int fine_points = 512;          // points of the second refinement
  int fine_steps = 10;            // iterations of the second refinement
  double merge_diameters = 0.03;  // refined poses within this pose distance are merged
  int evidence_pixels = 6000;     // pixels evaluated per candidate; fewer for ambiguous poses
  ProjectiveIcpOptions icp;       // max_correspondence_distance_m is set from the options above
  void Visit(SettingsVisitor& v);
};

// How much of the configured numbers a search uses.
struct SearchEffort {
  double scene = 1;  // for the number of visible instances in the scene or in the region
  double share = 1;  // for the share of the scene that is searched, 0..1
};

// Refines raw poses to candidates and compares the candidates of a frame.
class CandidateRefiner {
 public:
  // Results do not depend on the number of threads.
  CandidateRefiner(const ObjectSet& objects, const CandidateRefinementOptions& options,
                   int threads = 1);

  // Returns candidates from the raw poses `votes` of objects[object]; hypothesis.object = object.
  // - patches: number of patches or reference points that voted; normalises the vote density
  // - effort: multiplies the configured numbers of candidates
  // - seconds: times are added under "quick", "select", "icp", "ambiguous_poses" and "verify"
  // - trace: if given, the refinements are appended
  std::vector<Candidate> RefineCandidates(const OrganizedCloud& cloud, ObjectId object,
                                          const std::vector<PoseVote>& votes, int patches,
                                          const SearchEffort& effort, StageSeconds& seconds,
                                          EstimateTrace* trace = nullptr) const;
  // The same for raw poses that are modes of votes; the density is computed from the votes `cast`.
  std::vector<Candidate> RefineCandidates(const OrganizedCloud& cloud, ObjectId object,
                                          const std::vector<PoseVote>& votes,
                                          const std::vector<PoseVote>& cast, int patches,
                                          const SearchEffort& effort, StageSeconds& seconds,
                                          EstimateTrace* trace = nullptr) const;

  // Returns the mean of the objects' largest silhouettes, m^2.
  double silhouette_m2() const { return silhouette_m2_; }
  // Returns the scene's part of the effort, from the pixels that are searched; at least 1.
  double SceneEffort(const OrganizedCloud& cloud, const std::vector<int>& pixels) const;

  // Returns the pixels that no evident candidate explains.
  std::vector<int> Unexplained(const OrganizedCloud& cloud,
                               const std::vector<Candidate>& candidates,
                               const std::vector<int>& pixels) const;

  // Fills the margin and overlap features. Call it once, with all candidates of the frame.
  void Compare(std::vector<Candidate>& candidates, StageSeconds& seconds) const;

  // One entry per object.
  const std::vector<ModelPoints>& model_points() const { return models_; }
  const std::vector<PoseDistance>& distances() const { return distances_; }

 private:
  std::vector<RawHypothesis> QuickScored(const OrganizedCloud& cloud, ObjectId object,
                                         const std::vector<PoseVote>& votes) const;
  VoteDensity Density(ObjectId object, const std::vector<PoseVote>& votes) const;
  std::vector<RawHypothesis> Selected(std::vector<RawHypothesis> scored, const VoteDensity& density,
                                      int kept) const;
  RawHypothesis Refined(const OrganizedCloud& cloud, const RawHypothesis& start) const;
  void RefineFinely(const OrganizedCloud& cloud, RawHypothesis& pose) const;
  std::vector<RawHypothesis> AllRefined(const OrganizedCloud& cloud,
                                        const std::vector<RawHypothesis>& starts,
                                        bool ambiguous_poses, EstimateTrace* trace) const;
  std::vector<RawHypothesis> Merged(std::vector<RawHypothesis> poses, size_t max_count) const;
  std::vector<RawHypothesis> BestAtEachPlace(const std::vector<RawHypothesis>& poses,
                                             int max_at_place, int max_count) const;
  std::vector<RawHypothesis> RefinedAmbiguousPoses(const OrganizedCloud& cloud,
                                                   const std::vector<RawHypothesis>& starts,
                                                   EstimateTrace* trace) const;
  bool IsNearAny(const RawHypothesis& pose, const std::vector<RawHypothesis>& others,
                 double diameters) const;
  std::vector<RawHypothesis> MissingRivals(const OrganizedCloud& cloud,
                                           const std::vector<RawHypothesis>& starts,
                                           const std::vector<Candidate>& candidates,
                                           EstimateTrace* trace) const;
  std::vector<RawHypothesis> BestAmbiguousPoses(const OrganizedCloud& cloud,
                                                const RawHypothesis& start,
                                                EvidenceScratch& scratch) const;
  std::vector<Candidate> WithFeatures(const OrganizedCloud& cloud,
                                      const std::vector<RawHypothesis>& poses,
                                      const VoteDensity& density, double patches) const;
  int Kept(const SearchEffort& effort) const;
  // Number of poses of one object whose ambiguous poses are tried.
  int AmbiguousStarts(double scene_effort) const;

  ObjectSet objects_;
  CandidateRefinementOptions options_;
  int threads_;
  std::vector<ModelPoints> models_;
  std::vector<DepthEvidenceOf> evidence_;
  std::vector<PoseDistance> distances_;
  std::vector<PoseEmbedding> embeddings_;
  std::vector<std::vector<Pose>> ambiguous_poses_;  // transforms S_O, by object
  double silhouette_m2_ = 0;                        // largest, mean over the objects
};

}  // namespace pickbed::perception
