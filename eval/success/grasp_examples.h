#pragma once

// Examples of grasps of unknown objects that succeeded or failed, for the network that rates grasps
// (grasp/completed/success_network.h). They are executed in copies of simulated scenes.

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "eval/layer.h"
#include "scenes/base/settings.h"
#include "scenes/scenario/planner_spec.h"

namespace pickbed::eval {

// Grasps of one group of bins.
struct GraspExamples {
  std::vector<float> inputs;     // grasps x grasp::kSuccessInputs
  std::vector<uint8_t> success;  // 1 = the grasp picked an object
  std::vector<int32_t> image;    // number of its image; the grasps of an image are alternatives
};

// Kinds of groups. Odd groups are deep, so that both kinds grow together.
enum class GroupKind { kShallow, kDeep };
inline GroupKind KindOf(int group) {
  return group % 2 == 1 ? GroupKind::kDeep : GroupKind::kShallow;
}

// How the grasps of an image are chosen.
struct ExampleOptions {
  int shallow_rounds = 6;     // rounds of clutter_unseen in a group
  int deep_attempts = 40;     // images of a bin of deep_unknown
  int shallow_attempts = 12;  // images of a round
  int best = 8;               // grasps with the best scores, at different places
  int random = 10;            // other grasps
  // Network whose chances are the scores; none = by the logistic function. Grasps that a network
  // overrates are found only if it ranks them.
  std::string ranking = kNoSuccessModel;
  void Visit(SettingsVisitor& v);
};

// Executes grasps in the bins of one group. They are bins of the preset deep_unknown or
// clutter_unseen with objects of seen families (scenes/shape_families), which are in no other
// group. A few grasps of each image are executed in copies of the scene: those with the best scores
// and random ones. Then the scene continues with the best grasp. `on_image` is called after each
// image and may throw to end the group.
GraspExamples MakeGraspExamples(int group, const ExampleOptions& options,
                                const std::function<void()>& on_image);

// Writes a file atomically. `key` names the group and its options.
void SaveGraspExamples(const std::filesystem::path& file, const std::string& key,
                       const GraspExamples& examples);
// Throws InputError that names the file if it is missing, damaged or has another key. An empty key
// fits all files.
GraspExamples LoadGraspExamples(const std::filesystem::path& file, const std::string& key);

// Returns the key of a group.
std::string ExamplesKey(int group, const ExampleOptions& options);

}  // namespace pickbed::eval
