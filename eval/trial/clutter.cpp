#include "eval/trial/clutter.h"

#include "eval/trial/grasp_choice.h"
#include "sim/drop/fill_level.h"

namespace pickbed::eval {

ClutterStatistics MeasureClutter(const TrialSetup& setup, const Scene& scene, BinIndex bin_index,
                                 const Observation& view) {
  const sim::FillStatistics fill = sim::MeasureFill(scene, setup.cell.TrueObjects(bin_index));
  ClutterStatistics clutter;
  clutter.instances = static_cast<int>(scene.objects.size());
  clutter.fill_level = fill.fill_level;
  for (const int layer : fill.layers) {
    if (layer > static_cast<int>(clutter.layers.size())) clutter.layers.resize(layer);
    ++clutter.layers[layer - 1];
  }
  std::vector<EstimatedPose> poses;
  for (const PosedObject& posed : scene.objects) poses.push_back({posed.object, posed.X_WO});
  PlanOptions options;
  options.max_grasps = 1;
  for (size_t i = 0; i < scene.objects.size(); ++i) {
    if (!setup.cell.IsWanted(scene.objects[i].object)) continue;
    clutter.visible_fraction.push_back(view.visible_fractions[i]);
    if (view.visible_fractions[i] < kCountedVisibility) continue;
    ++clutter.counted;
    const int target = static_cast<int>(i);
    const std::vector<PlanInput> inputs = InputsOf(setup, poses, {}, {&target, 1});
    clutter.graspable += !PlanWithTools(inputs, options).grasps.empty();
  }
  return clutter;
}

}  // namespace pickbed::eval
