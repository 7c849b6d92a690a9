#include "eval/trial/stage_oracle.h"

#include <algorithm>
#include <array>

#include "perception/cloud/organized_cloud.h"
#include "perception/icp/final_refinement.h"
#include "perception/model/model_points.h"
#include "scenes/base/error.h"

namespace pickbed::eval {
namespace {

constexpr OracleStages kPerception{true, true, true, true, false};
constexpr OracleStages kAll{true, true, true, true, true};
constexpr std::array<OracleRow, 6> kRows{{
    {"detection", "exactly the visible instances are proposed", {.detection = true}},
    {"pose", "poses are true before refinement", {.pose = true}},
    {"refinement", "a right pose is kept and made exact by the refinement", {.refinement = true}},
    {"grasp", "grasps are planned and checked in the true scene", {.grasp = true}},
    {"perception", "the poses of all instances are known, and the camera measures exactly",
     kPerception},
    {"everything", "the poses of all instances are known, and grasps are planned in the true scene",
     kAll},
}};

class TruthSubstitution {
 public:
  TruthSubstitution(std::vector<PoseHypothesis> estimated, const InstanceMatcher& visible)
      : estimated_(std::move(estimated)), visible_(visible), instances_(visible.instances()) {
    Sort();
  }

  void Detection() {
    const std::vector<int> matched = MatchedInstances();
    std::vector<bool> covered(instances_.size(), false);
    std::vector<PoseHypothesis> kept;
    for (size_t i = 0; i < estimated_.size(); ++i) {
      if (matched[i] < 0) continue;
      covered[matched[i]] = true;
      kept.push_back(std::move(estimated_[i]));
    }
    estimated_ = std::move(kept);
    for (size_t p = 0; p < instances_.size(); ++p) {
      if (covered[p]) continue;
      PoseHypothesis proposed;
      proposed.object = instances_[p].object;
      proposed.X_CO = instances_[p].X_CO;
      proposed.score = 0.5 + 0.5 * instances_[p].visible_fraction;
      proposed.fit.inlier_share = instances_[p].visible_fraction;
      proposed.fit.hidden_share = 1 - instances_[p].visible_fraction;
      estimated_.push_back(std::move(proposed));
    }
    Sort();
  }

  void Poses() {
    const std::vector<int> matched = MatchedInstances();
    for (size_t i = 0; i < estimated_.size(); ++i) {
      if (matched[i] >= 0) SetTrue(matched[i], estimated_[i]);
    }
  }

  void Refinement() {
    std::vector<bool> taken(instances_.size(), false);
    for (PoseHypothesis& h : estimated_) {
      std::vector<Pose> in_hand{h.X_CO};
      if (h.unrefined_X_CO) in_hand.push_back(*h.unrefined_X_CO);
      in_hand.insert(in_hand.end(), h.suppressed_X_CO.begin(), h.suppressed_X_CO.end());
      for (const Pose& X_CO : in_hand) {
        const int position = FirstFreeCorrect(visible_.ByDistance(h.object, X_CO), taken);
        if (position < 0) continue;
        taken[position] = true;
        SetTrue(position, h);
        break;
      }
    }
  }

  std::vector<PoseHypothesis> Take() { return std::move(estimated_); }

 private:
  void Sort() {
    std::stable_sort(estimated_.begin(), estimated_.end(),
                     [](const auto& a, const auto& b) { return a.score > b.score; });
  }

  void SetTrue(int position, PoseHypothesis& h) const {
    h.X_CO = instances_[position].X_CO;
    h.unrefined_X_CO.reset();
    h.suppressed_X_CO.clear();
  }

  // Returns the index of the matched instance for each hypothesis, -1 = none.
  std::vector<int> MatchedInstances() const {
    std::vector<bool> taken(instances_.size(), false);
    std::vector<int> matched;
    for (const PoseHypothesis& h : estimated_) {
      const double limit_m = kMatchDiameters * visible_.model(h.object).diameter_m;
      const int nearest = visible_.NearestFree(h.object, h.X_CO, limit_m, taken);
      if (nearest >= 0) taken[nearest] = true;
      matched.push_back(nearest);
    }
    return matched;
  }

  std::vector<PoseHypothesis> estimated_;
  const InstanceMatcher& visible_;
  const std::vector<TrueInstance>& instances_;  // of visible_
};

}  // namespace

std::span<const OracleRow> OracleTable() { return kRows; }

const OracleRow& OracleNamed(const std::string& name) {
  std::vector<std::string> names;
  for (const OracleRow& row : kRows) {
    if (name == row.name) return row;
    names.push_back(row.name);
  }
  throw InputError(UnknownNameMessage("stage", name, names));
}

std::vector<PoseHypothesis> SubstituteTruth(std::vector<PoseHypothesis> estimated,
                                            const InstanceMatcher& visible,
                                            const OracleStages& truth) {
  TruthSubstitution substitution(std::move(estimated), visible);
  if (truth.detection) substitution.Detection();
  if (truth.pose) substitution.Poses();
  if (truth.refinement) substitution.Refinement();
  return substitution.Take();
}

struct OracleRefiner::Impl {
  std::vector<ModelPoints> models;
  std::string refiner;
};

OracleRefiner::OracleRefiner(const ObjectSet& objects, const std::string& refiner)
    : impl_(std::make_unique<Impl>()) {
  impl_->refiner = RefinerNamed(refiner).name;
  for (const auto& object : objects) impl_->models.push_back(MakeModelPoints(*object));
}

OracleRefiner::~OracleRefiner() = default;

void OracleRefiner::Refine(const RgbdFrame& frame, const KnownBackground& background,
                           std::vector<PoseHypothesis>& hypotheses) const {
  const OrganizedCloud cloud = BuildCloud(frame, background);
  RefineFinally(impl_->refiner, cloud, impl_->models, 1, hypotheses);
}

}  // namespace pickbed::eval
