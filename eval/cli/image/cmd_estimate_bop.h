#pragma once

// `pickbed estimate --bop`: poses in the images of a BOP data set.

#include <string>
#include <vector>

#include "eval/cli/arguments.h"

namespace pickbed::eval {

struct BopArguments {
  std::string path;
  std::string split = "test";
  std::string task = "localisation";
  bool without_cell = false;
  bool resume = false;
  std::string roi;  // see ParseRegion(); empty = the whole image
};

// Adds --bop, --split, --task, --without-cell and --resume.
void AddBopArguments(CLI::App& app, BopArguments& bop);

// Writes the estimates of the target images as a results file of BOP. Returns the exit status.
// Throws InputError for invalid arguments and as EstimateDataset().
int EstimateBop(const BopArguments& bop, const ScenarioRequest& arguments,
                const std::vector<std::string>& estimators, const std::string& out, int threads);

// Writes a page with the stages of the estimate for `image`, "SCENE/IMAGE" or the number of a
// target. Returns and throws as EstimateBop().
int ExplainBop(const BopArguments& bop, const ScenarioRequest& arguments,
               const std::vector<std::string>& estimators, const std::string& image,
               const std::string& out);

}  // namespace pickbed::eval
