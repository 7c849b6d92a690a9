#include "perception/icp/final_refinement.h"

#include "perception/verify/pose_features.h"
#include "scenes/base/error.h"
#include "scenes/base/parallel.h"

namespace pickbed::perception {
namespace {

RefinePose MakePclIcp(const OrganizedCloud& cloud, const RefinerOptions& options) {
  return [icp = std::make_shared<const PclIcp>(cloud, options.pcl_icp)](
             const ModelPoints& model, const Pose& X_CO) { return icp->Refine(model, X_CO); };
}

RefinePose MakeBidirectionalIcp(const OrganizedCloud& cloud, const RefinerOptions& options) {
  return [&cloud, icp = options.bidirectional_icp](const ModelPoints& model, const Pose& X_CO) {
    return BidirectionalIcp(cloud, model, X_CO, icp);
  };
}

RefinePose MakeNothing(const OrganizedCloud&, const RefinerOptions&) { return {}; }

constexpr RefinerRow kRefiners[] = {
    {"pcl_icp", "PCL's ICP against the depth image; a result with a worse fit is discarded",
     &MakePclIcp},
    {"two_way_icp",
     "surface, outline and cover residuals in one ICP with restarts; for real frames",
     &MakeBidirectionalIcp},
    {"none", "no refinement; poses are reported as the estimator found them", &MakeNothing},
};

void RefineHypothesis(const RefinePose& refine, const OrganizedCloud& cloud,
                      const ModelPoints& model, PoseHypothesis& hypothesis) {
  const IcpResult result = refine(model, hypothesis.X_CO);
  const bool refined = result.status == IcpStatus::kRefined;
  if (refined) {
    hypothesis.unrefined_X_CO = hypothesis.X_CO;
    hypothesis.X_CO = result.X_CO;
  }
  hypothesis.fit = MeasureFit(cloud, model, hypothesis.X_CO);
  hypothesis.fit.reciprocal_condition_number = result.reciprocal_condition_number;
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

void RefinerOptions::Visit(SettingsVisitor& v) {
  v.Group(
      "pcl_icp", [this](SettingsVisitor& g) { pcl_icp.Visit(g); }, "options of refiner pcl_icp");
  v.Group(
      "bidirectional_icp", [this](SettingsVisitor& g) { bidirectional_icp.Visit(g); },
      "options of refiner two_way_icp");
}

void RefineFinally(const std::string& refiner, const OrganizedCloud& cloud,
                   std::span<const ModelPoints> models, const RefinerOptions& options, int threads,
                   std::vector<PoseHypothesis>& hypotheses) {
  CheckSettings("RefinerOptions", options);
  const RefinerRow& row = RefinerNamed(refiner);
  if (hypotheses.empty()) return;
  const RefinePose refine = row.make(cloud, options);
  if (!refine) return;
  ForRanges(static_cast<int>(hypotheses.size()), threads, [&](int begin, int end) {
    for (int i = begin; i < end; ++i) {
      RefineHypothesis(refine, cloud, models[hypotheses[i].object], hypotheses[i]);
    }
  });
}

}  // namespace pickbed::perception
