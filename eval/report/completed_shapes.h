#pragma once

// Completed segments of an image, and a page that explains how the image of unknown objects is
// picked: segments, completed shapes, grasp and ground truth.

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "eval/explain/explain.h"
#include "eval/trial/trial_setup.h"
#include "grasp/completed/occupancy_shape.h"

namespace pickbed::eval {

// Makes the completed shapes that a planner sees.
class CompletedShapes {
 public:
  // Throws InputError for an unknown segmentation or completion.
  explicit CompletedShapes(const ScenarioSpec& spec);
  ~CompletedShapes();

  // Returns whether the planner of the scenario completes shapes. Without, there are none.
  bool has_any() const { return shapes_ != nullptr; }

  // Returns the shapes in an image of the scene, highest first, with at most kShownCells cells
  // along each axis. `objects` are in their true sizes.
  static constexpr int kShownCells = 32;
  std::vector<grasp::OccupancyShape> Of(const SimulatedCell& cell, const Scene& scene,
                                        const ObjectSet& objects, const Observation& view) const;

 private:
  std::unique_ptr<SegmentShapes> shapes_;  // null: the planner completes none
};

// Returns whether a planner completes shapes, so that ExplainUnknown() can explain it.
bool CompletesShapes(const std::string& planner);

// Explains the first pick of a bin for a planner that completes shapes: writes explain_trial_N.html
// and its pictures into `folder`. Throws InputError for another planner.
[[nodiscard]] ExplanationPage ExplainUnknown(const ScenarioSpec& spec, const ObjectSet& objects,
                                             const std::string& title, BinIndex bin_index,
                                             const std::filesystem::path& folder);

}  // namespace pickbed::eval
