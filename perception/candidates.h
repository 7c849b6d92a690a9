#pragma once

// From a cloud to refined pose candidates: points -> patches -> descriptors -> neighbours in the
// code book -> votes -> quick score and density -> clusters -> ICP -> features for the verifier.
// The learned estimator and the training of its verifier share it, so that the verifier learns on
// exactly what it will judge.

#include <memory>
#include <vector>

#include "perception/codebook.h"
#include "perception/estimate_trace.h"
#include "perception/neighbors.h"
#include "perception/projective_icp.h"
#include "perception/verify.h"
#include "scenes/stage_seconds.h"

namespace pickbed {

struct CandidateOptions {
  int points = 600;            // patches of a frame
  int neighbors = 8;           // votes of a patch
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
  double gate_diameters = 0.08;   // first gate of ICP
  double gate_min_m = 0.004;      // bounds of that gate: wide ones slide into clutter
  double gate_max_m = 0.010;      //
  bool two_gates = false;         // also try half the gate and keep the better
  int turned = 12;                // of the best refined poses of a part, its look-alikes are tried
  double merge_diameters = 0.03;  // refined poses within it are one
  ProjectiveIcpOptions icp;       // its gates are set from the above
  NeighborOptions index;
  void Visit(SettingsVisitor& v);
};

struct Candidate {
  PoseHypothesis hypothesis;  // score = ICP's overlap; fit is filled
  VerifyFeatures features;
};

// What a part brings with it.
struct CandidatePart {
  std::shared_ptr<const ObjectModel> model;
  double side_m = 0;  // of its patches
  ObjectCodes codes;
};

class CandidateFinder {
 public:
  CandidateFinder(std::vector<CandidatePart> parts, DescribePatches describe,
                  const CandidateOptions& options);
  ~CandidateFinder();

  // Candidates of all parts; hypothesis.object is the index into `parts`. Seconds are added under
  // "patches", "network", "neighbors", "quick", "select", "icp" and "verify". A trace gets patches,
  // votes and refinements.
  std::vector<Candidate> Find(const OrganizedCloud& cloud, Rng& rng, StageSeconds& seconds,
                              EstimateTrace* trace = nullptr) const;

  const std::vector<ModelPoints>& model_points() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace pickbed
