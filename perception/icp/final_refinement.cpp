#include "perception/icp/final_refinement.h"

#include <cassert>
#include <cmath>

#include "perception/icp/bidirectional_icp.h"
#include "perception/icp/pcl_icp.h"
#include "perception/icp/projective_icp.h"
#include "perception/verify/pose_features.h"
#include "scenes/base/error.h"
#include "scenes/base/finite_counts.h"
#include "scenes/base/parallel.h"

namespace pickbed::perception {
namespace {

struct NoOptions {
  void Visit(SettingsVisitor&) {}
};

// A refiner made from its options and a function that prepares a frame.
template <typename Options, RefinePose (*kForFrame)(const OrganizedCloud&, const Options&)>
class RefinerWith : public PoseRefiner {
 public:
  void Visit(SettingsVisitor& v) override { options_.Visit(v); }
  RefinePose ForFrame(const OrganizedCloud& cloud) const override {
    return kForFrame(cloud, options_);
  }

 private:
  Options options_;
};

template <typename Options, RefinePose (*kForFrame)(const OrganizedCloud&, const Options&)>
std::unique_ptr<PoseRefiner> Make() {
  return std::make_unique<RefinerWith<Options, kForFrame>>();
}

RefinePose PclIcpFor(const OrganizedCloud& cloud, const PclIcpOptions& options) {
  return [icp = std::make_shared<const PclIcp>(cloud, options)](
             const ModelPoints& model, const Pose& X_CO) { return icp->Refine(model, X_CO); };
}

RefinePose BidirectionalIcpFor(const OrganizedCloud& cloud,
                               const BidirectionalIcpOptions& options) {
  return [&cloud, options](const ModelPoints& model, const Pose& X_CO) {
    return BidirectionalIcp(cloud, model, X_CO, options);
  };
}

RefinePose ProjectiveIcpFor(const OrganizedCloud& cloud, const ProjectiveIcpOptions& options) {
  return [&cloud, options](const ModelPoints& model, const Pose& X_CO) {
    return ProjectiveIcp(cloud, model, X_CO, options);
  };
}

RefinePose NothingFor(const OrganizedCloud&, const NoOptions&) { return {}; }

constexpr RefinerRow kRefiners[] = {
    {"pcl_icp", "PCL's ICP against the depth image; a result with a worse fit is discarded",
     &Make<PclIcpOptions, &PclIcpFor>},
    {"bidirectional_icp",
     "surface, outline and cover residuals in one ICP with restarts; for real frames",
     &Make<BidirectionalIcpOptions, &BidirectionalIcpFor>},
    {"projective_icp",
     "ICP with the pixel at the projection of each model point; the fastest, it may lower the fit",
     &Make<ProjectiveIcpOptions, &ProjectiveIcpFor>},
    {"none", "no refinement; poses are reported as the estimator found them",
     &Make<NoOptions, &NothingFor>},
};

void RefineHypothesis(const RefinePose& refine, const OrganizedCloud& cloud,
                      const ModelPoints& model, PoseHypothesis& hypothesis) {
  assert(hypothesis.X_CO.matrix().allFinite());
  const IcpResult result = refine(model, hypothesis.X_CO);
  const bool is_finite =
      result.X_CO.matrix().allFinite() && std::isfinite(result.reciprocal_condition_number);
  if (!is_finite) CountNotFinite(FiniteBoundary::kRefinedPoses);
  const bool refined = result.status == IcpStatus::kRefined && is_finite;
  if (refined) {
    hypothesis.unrefined_X_CO = hypothesis.X_CO;
    hypothesis.X_CO = result.X_CO;
  }
  hypothesis.fit = MeasureFit(cloud, model, hypothesis.X_CO);
  hypothesis.fit.reciprocal_condition_number = is_finite ? result.reciprocal_condition_number : 0;
  hypothesis.fit.refinement_kept = refined;
}

}  // namespace

std::span<const RefinerRow> RefinerTable() { return kRefiners; }

const RefinerRow& RefinerNamed(const std::string& name) {
  std::vector<std::string> names;
  for (const RefinerRow& row : kRefiners) {
    if (row.name == name) return row;
    names.push_back(row.name);
  }
  throw InputError(UnknownNameMessage("refiner", name, names));
}

void RefineFinally(const PoseRefiner& refiner, const OrganizedCloud& cloud,
                   std::span<const ModelPoints> models, int threads,
                   std::vector<PoseHypothesis>& hypotheses) {
  if (hypotheses.empty()) return;
  const RefinePose refine = refiner.ForFrame(cloud);
  if (!refine) return;
  ForRanges(static_cast<int>(hypotheses.size()), threads, [&](int begin, int end) {
    for (int i = begin; i < end; ++i) {
      RefineHypothesis(refine, cloud, models[hypotheses[i].object], hypotheses[i]);
    }
  });
}

void RefineFinally(const std::string& refiner, const OrganizedCloud& cloud,
                   std::span<const ModelPoints> models, int threads,
                   std::vector<PoseHypothesis>& hypotheses) {
  RefineFinally(*RefinerNamed(refiner).make(), cloud, models, threads, hypotheses);
}

}  // namespace pickbed::perception
