#include "perception/candidates/candidate_comparison.h"

#include <algorithm>

#include "perception/verify/depth_evidence.h"
#include "perception/verify/physical_consistency.h"

namespace pickbed::perception {
namespace {

// Whether the pose agrees with nearly all of its visible pixels, and these are many.
bool Explains(const VerifyFeatures& f) {
  constexpr float kMinAgreeing = 0.3f, kMaxContradicted = 0.12f;
  return f[kAgreeingFeature] > kMinAgreeing &&
         f[kViolatedFeature] + f[kWrongNormalFeature] < kMaxContradicted * f[kAgreeingFeature];
}

Eigen::Vector3d CenterOf(const Candidate& candidate, const ModelPoints& model) {
  return candidate.hypothesis.X_CO * model.center_O.cast<double>();
}

}  // namespace

bool Crowding::Admit(const Eigen::Vector3d& center_C, int max_poses) {
  const auto is_near = [&](const Eigen::Vector3d& other) {
    return (center_C - other).norm() < radius_m_;
  };
  if (std::count_if(centers_C_.begin(), centers_C_.end(), is_near) >= max_poses) return false;
  centers_C_.push_back(center_C);
  return true;
}

void FillMargins(const PoseDistance& distance, const ModelPoints& model,
                 const std::vector<Candidate*>& candidates) {
  constexpr double kRivalDiameters = 0.3, kOtherPoseDiameters = 0.12;
  const double near_m = kRivalDiameters * distance.diameter_m();
  std::vector<Eigen::Vector3d> centers_C;
  for (const Candidate* c : candidates) centers_C.push_back(CenterOf(*c, model));
  for (size_t i = 0; i < candidates.size(); ++i) {
    Candidate& candidate = *candidates[i];
    float margin = 1;
    for (size_t j = 0; j < candidates.size(); ++j) {
      const float over = EvidenceMargin(candidate.evidence, candidates[j]->evidence);
      if (over >= margin || j == i) continue;
      if ((centers_C[i] - centers_C[j]).norm() > near_m) continue;
      const Pose& X_CO = candidates[j]->hypothesis.X_CO;
      if (distance(candidate.hypothesis.X_CO, X_CO) > kOtherPoseDiameters) margin = over;
    }
    candidate.features[kMarginFeature] = margin;
  }
}

std::vector<const Candidate*> EvidentCandidates(const std::vector<Candidate>& candidates,
                                                const std::vector<ModelPoints>& models) {
  std::vector<const Candidate*> explaining;
  for (const Candidate& candidate : candidates) {
    if (Explains(candidate.features)) explaining.push_back(&candidate);
  }
  std::stable_sort(
      explaining.begin(), explaining.end(),
      [](const Candidate* a, const Candidate* b) { return a->evidence > b->evidence; });
  std::vector<Crowding> places;
  for (const ModelPoints& model : models) {
    places.emplace_back(kSamePlaceDiameters * model.diameter_m);
  }
  std::vector<const Candidate*> evident;
  for (const Candidate* candidate : explaining) {
    const ObjectId object = candidate->hypothesis.object;
    if (places[object].Admit(CenterOf(*candidate, models[object]), 1)) evident.push_back(candidate);
  }
  return evident;
}

double OverlapWith(const std::vector<const Candidate*>& evident, const Candidate& candidate,
                   const std::vector<ModelPoints>& models) {
  constexpr double kMaxOverlap = 0.25;
  const ObjectId object = candidate.hypothesis.object;
  const ModelPoints& model = models[object];
  const Eigen::Vector3d center_C = CenterOf(candidate, model);
  double deepest = 0;
  for (const Candidate* other : evident) {
    const bool same_object = other->hypothesis.object == object;
    if (!same_object && other->evidence <= candidate.evidence) continue;
    const ModelPoints& theirs = models[other->hypothesis.object];
    const double apart_m = (CenterOf(*other, theirs) - center_C).norm();
    if (same_object && apart_m < kSamePlaceDiameters * model.diameter_m) continue;
    const double depth_m =
        PenetrationDepth(model, candidate.hypothesis.X_CO, theirs, other->hypothesis.X_CO);
    deepest = std::max(deepest, depth_m / std::min(model.diameter_m, theirs.diameter_m));
  }
  return std::min(kMaxOverlap, deepest);
}

}  // namespace pickbed::perception
