#pragma once

// `pickbed estimate IMAGE`: poses in one image of a user, without a data set.

#include <string>
#include <vector>

#include "eval/cli/arguments.h"

namespace pickbed::eval {

struct ImageArguments {
  std::string depth;
  std::string intrinsics;
  double depth_scale_mm = 0;
  std::vector<std::string> meshes;
  std::string unit;  // of the meshes; empty = guessed
  std::vector<std::string> objects;
};

// Adds --depth, --intrinsics, --depth-scale, --mesh, --unit and --object.
void AddImageArguments(CLI::App& app, ImageArguments& image);

// Returns whether the arguments name an image and not a scenario.
bool IsImage(const ScenarioRequest& arguments, const ImageArguments& image);

// Estimates the poses with these settings. `roi`: see ParseRegion(); empty = the whole image.
// Returns the exit status.
int EstimateImage(const ScenarioRequest& arguments, const ImageArguments& image,
                  const EstimatorSpec& estimator, const ScenarioSpec& settings,
                  const std::string& roi, const std::string& out, int threads);

}  // namespace pickbed::eval
