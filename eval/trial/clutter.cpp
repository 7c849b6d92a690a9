#include "eval/trial/clutter.h"

#include <algorithm>

#include "eval/trial/grasp_choice.h"
#include "sim/drop/fill_level.h"

namespace pickbed::eval {

std::vector<int> CountsByLayer(std::span<const int> layers) {
  std::vector<int> counts;
  for (const int layer : layers) {
    if (layer > static_cast<int>(counts.size())) counts.resize(layer);
    ++counts[layer - 1];
  }
  return counts;
}

GraspableCount CountGraspable(const TrialSetup& setup, const Scene& scene,
                              std::span<const double> visible_fractions, int max_tested) {
  if (!setup.has_poses) return {};
  std::vector<EstimatedPose> poses;
  std::vector<int> counted;
  for (size_t i = 0; i < scene.objects.size(); ++i) {
    poses.push_back({scene.objects[i].object, scene.objects[i].X_WO});
    const bool counts = visible_fractions[i] >= kCountedVisibility;
    if (counts && setup.cell.IsWanted(scene.objects[i].object)) {
      counted.push_back(static_cast<int>(i));
    }
  }
  const size_t tested = std::min<size_t>(counted.size(), max_tested);
  if (tested == 0) return {};
  std::vector<int> targets;
  for (size_t i = 0; i < tested; ++i) targets.push_back(counted[i * counted.size() / tested]);
  const int count = static_cast<int>(tested);
  return {count, grasp::CountReachable(InputsOf(setup, poses, {}, targets), count)};
}

ClutterStatistics MeasureClutter(const SimulatedCell& cell, const Scene& scene, BinIndex bin_index,
                                 const Observation& view) {
  const sim::FillStatistics fill = sim::MeasureFill(scene, cell.TrueObjects(bin_index));
  ClutterStatistics clutter;
  clutter.instances = static_cast<int>(scene.objects.size());
  clutter.fill_level = fill.fill_level;
  clutter.layers = CountsByLayer(fill.layers);
  for (size_t i = 0; i < scene.objects.size(); ++i) {
    if (!cell.IsWanted(scene.objects[i].object)) continue;
    clutter.visible_fraction.push_back(view.visible_fractions[i]);
    clutter.counted += view.visible_fractions[i] >= kCountedVisibility;
  }
  return clutter;
}

}  // namespace pickbed::eval
