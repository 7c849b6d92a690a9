#include "eval/report/views_3d.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "eval/cell/simulated_cell.h"
#include "eval/export/scene_glb.h"
#include "eval/report/completed_shapes.h"
#include "eval/trial/recorded_scene.h"
#include "grasp/grippers/table.h"

namespace pickbed::eval {
std::span<const ViewLayer> ViewLayers() {
  static constexpr std::array<ViewLayer, 7> kLayers{{
      {"truth", "true poses", "#cdcdd2"},
      {"hypothesis", "estimated poses, low to high score",
       "linear-gradient(90deg, #f06c05, #ecece8, #40a0ff)", true},
      {"hand", "hand", "#3c424c"},
      {"completed", "completed segments, each in its color",
       "linear-gradient(90deg, #56b4e9, #e69f00, #009e73)", true},
      {"possible", "possible matter", "#cfe6f5", true},
      {"cloud", "measured points", "repeating-radial-gradient(#888 0 1px, #fff 1px 3px)"},
      {"bin", "bin", "#8c96a5"},
  }};
  return kLayers;
}

std::vector<ViewChoice> ChooseViews(std::span<const ConfigurationTrials> configurations,
                                    int maximum,
                                    const std::function<bool(const ViewChoice&)>& suits) {
  std::vector<ViewChoice> failed, picked;
  std::vector<int> earlier_failures;  // number of earlier failures with the same reason
  std::map<FailureReason, int> seen;
  for (size_t p = 0; p < configurations.size(); ++p) {
    for (size_t t = 0; t < configurations[p].trials.size(); ++t) {
      const std::vector<AttemptRecord>& picks = configurations[p].trials[t].attempts;
      for (size_t attempt = 0; attempt < picks.size(); ++attempt) {
        if (!picks[attempt].grasp || (suits && !suits({p, t, attempt}))) continue;
        const FailureReason failure = picks[attempt].failure;
        if (failure == FailureReason::kNone) {
          picked.push_back({p, t, attempt});
        } else {
          failed.push_back({p, t, attempt});
          earlier_failures.push_back(seen[failure]++);
        }
      }
    }
  }
  std::vector<size_t> order(failed.size());
  for (size_t i = 0; i < order.size(); ++i) order[i] = i;
  std::stable_sort(order.begin(), order.end(),
                   [&](size_t a, size_t b) { return earlier_failures[a] < earlier_failures[b]; });
  std::vector<ViewChoice> choices;
  const size_t for_failed = static_cast<size_t>(maximum) - (picked.empty() || maximum == 0 ? 0 : 1);
  for (size_t i = 0; i < std::min(order.size(), for_failed); ++i)
    choices.push_back(failed[order[i]]);
  if (maximum > 0 && !picked.empty()) choices.push_back(picked.front());
  return choices;
}

struct ViewMaker::Impl {
  Tools tools;
  std::string success_rule;
  SimulatedCell cell;
  ReportOptions options;
  CompletedShapes shapes;
};

ViewMaker::ViewMaker(const ScenarioSpec& spec, const ObjectSet& objects,
                     const ReportOptions& options)
    : impl_(new Impl{LoadTools(spec.gripper.names), spec.policy.success,
                     SimulatedCell(spec, objects), options, CompletedShapes(spec)}) {}

ViewMaker::~ViewMaker() = default;

std::string ViewMaker::Glb(const TrialResult& trial, size_t number) {
  SimulatedCell& cell = impl_->cell;
  const Scene scene = SceneOfAttempt(trial, number, {cell, impl_->tools, impl_->success_rule});
  const AttemptRecord& attempt = trial.attempts[number];
  const Observation view = cell.Capture(scene, trial.bin_index, attempt.attempt);
  const Image<float>& depth_m = view.frame.depth_m;
  const double pixels = static_cast<double>(depth_m.width()) * depth_m.height();
  const int stride_px = std::max(
      1, static_cast<int>(std::ceil(std::sqrt(pixels / std::max(1, impl_->options.cloud_points)))));
  const GlbCloud cloud = ObservedCloud(view.frame, view.calibration.camera.X_WC(), stride_px);
  const ObjectSet true_objects = cell.TrueObjects(trial.bin_index);
  SceneGlbOptions options;
  options.max_faces = impl_->options.view_triangles;
  return SceneGlb(
      {.scene = scene,
       .objects = cell.objects(),
       .hypotheses = attempt.hypotheses,
       .grasp = attempt.grasp ? &*attempt.grasp : nullptr,
       .gripper = &ToolNamed(impl_->tools, attempt.grasp ? attempt.grasp->tool : std::string()),
       .cloud = impl_->options.cloud_points > 0 ? &cloud : nullptr,
       .true_objects = &true_objects,
       .completed = impl_->shapes.Of(cell, scene, true_objects, view)},
      options);
}

}  // namespace pickbed::eval
