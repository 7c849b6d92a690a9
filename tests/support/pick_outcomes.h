#pragma once

// Outcomes of simulated picks at published pose estimates, from another physics simulation: the
// folder pick_outcomes of the test data, whose README names the source. Each row is one pose with
// its errors and whether a grasp at that pose succeeded.

#include <algorithm>
#include <array>
#include <filesystem>
#include <map>
#include <sstream>
#include <string>
#include <vector>

#include "eval/stats/roc.h"
#include "scenes/base/files.h"
#include "tests/support/layer.h"

namespace pickbed::tests {

// Errors of a pose, as columns of the file.
inline constexpr std::array kOutcomeErrors{"mssd_m",  "add_m",        "translation_m",
                                           "vsd_020", "rotation_deg", "mspd_px"};

// One line of the file.
struct PickedPose {
  std::array<double, kOutcomeErrors.size()> errors{};
  bool picked = false;
};

// Poses of one object by one method, executed with one hand.
struct ObjectMethodPair {
  std::string hand, dataset, object, method;
  std::vector<PickedPose> poses;

  int successes() const {
    return static_cast<int>(std::ranges::count(poses, true, &PickedPose::picked));
  }
  bool has_both() const { return successes() > 0 && successes() < static_cast<int>(poses.size()); }
  // Area under the ROC curve of minus the error for success.
  double AucOf(size_t error) const {
    std::vector<ScoredOutcome> outcomes;
    for (const PickedPose& pose : poses) outcomes.push_back({-pose.errors[error], pose.picked});
    return Auc(outcomes).auc;
  }
};

// Reads the file; pairs are sorted by hand, dataset, object and method.
inline std::vector<ObjectMethodPair> ReadPickOutcomes(const std::filesystem::path& file) {
  std::istringstream lines(ReadFileBytes(file));
  const auto cells_of = [](const std::string& line) {
    std::vector<std::string> cells;
    std::istringstream stream(line);
    for (std::string cell; std::getline(stream, cell, ',');) cells.push_back(cell);
    return cells;
  };
  std::string line;
  std::getline(lines, line);
  std::map<std::string, size_t> columns;
  for (const std::string& name : cells_of(line)) columns.emplace(name, columns.size());
  std::map<std::array<std::string, 4>, ObjectMethodPair> pairs;
  while (std::getline(lines, line)) {
    const std::vector<std::string> cells = cells_of(line);
    const auto cell = [&](const char* column) { return cells.at(columns.at(column)); };
    const std::array key{cell("gripper"), cell("dataset"), cell("object"), cell("method")};
    ObjectMethodPair& pair = pairs[key];
    pair.hand = key[0];
    pair.dataset = key[1];
    pair.object = key[2];
    pair.method = key[3];
    PickedPose& pose = pair.poses.emplace_back();
    for (size_t i = 0; i < kOutcomeErrors.size(); ++i) {
      pose.errors[i] = std::stod(cell(kOutcomeErrors[i]));
    }
    pose.picked = cell("picked") == "1";
  }
  std::vector<ObjectMethodPair> sorted;
  for (auto& [key, pair] : pairs) sorted.push_back(std::move(pair));
  return sorted;
}

// Error with its median AUC over the pairs of a hand that have both outcomes.
struct RankedError {
  std::string error;
  double median_auc = 0;
};

// Returns the errors, best predictor of success first.
inline std::vector<RankedError> RankErrors(const std::vector<ObjectMethodPair>& pairs,
                                           const std::string& hand) {
  std::vector<RankedError> ranked;
  for (size_t i = 0; i < kOutcomeErrors.size(); ++i) {
    ValueClusters aucs;
    for (const ObjectMethodPair& pair : pairs) {
      if (pair.hand == hand && pair.has_both()) aucs.push_back({pair.AucOf(i)});
    }
    ranked.push_back({kOutcomeErrors[i], MedianOf(aucs)});
  }
  std::ranges::stable_sort(ranked, std::greater<>(), &RankedError::median_auc);
  return ranked;
}

}  // namespace pickbed::tests
