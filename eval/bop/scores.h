#pragma once

// From pose errors to the scores of the BOP challenge. Only numbers here; eval/bop/evaluate.h
// computes the errors.
//
// BOP19 (6D localisation, Hodan et al. 2020, sec. 2.4): the object and its number n of instances in
// an image are told. The n estimates of highest score count; the n most visible instances are to be
// found. Recall at a threshold = found / to be found; average recall = its mean over thresholds.
// BOP24 (6D detection): nothing is told but the image. All estimates of an image count, at most the
// 100 of highest score. Instances of less than 10 % visible need not be found, and an estimate of
// one is neither right nor wrong. Average precision of each object at each threshold as COCO
// has it (101 recall levels), mean over thresholds, then over the objects that occur.

#include <cstddef>
#include <map>
#include <vector>

namespace pickbed::bop {

inline constexpr int kMostEstimatesOfImage = 100;  // BOP24
inline constexpr double kLeastVisible = 0.1;       // BOP24

// Estimates of one object in one image against its instances there.
struct ErrorTable {
  int object_id = 0;
  std::vector<double> scores;               // of each estimate
  std::vector<double> visible;              // visible fraction of each instance
  std::vector<std::vector<double>> errors;  // [estimate][instance]
};

// Greedy, the highest score first (equal scores: the earlier one): each estimate takes the
// instance of least error below the threshold that is allowed and not taken. The instance of each
// estimate, -1 = none.
std::vector<int> MatchGreedily(const ErrorTable& table, const std::vector<bool>& allowed,
                               double threshold);

// The estimates (indices) of the `count` highest scores, highest first; all where there are fewer.
std::vector<int> HighestScores(const std::vector<double>& scores, size_t count);
// The `count` most visible instances.
std::vector<bool> MostVisible(const std::vector<double>& visible, size_t count);

struct Recall {
  int found = 0;
  int wanted = 0;
  double value() const { return wanted > 0 ? static_cast<double>(found) / wanted : 0; }
};

// BOP19: of one object in one image, `count` of which are to be found.
Recall RecallOf(const ErrorTable& table, int count, double threshold);

// A row of a precision-recall curve.
struct Detection {
  double score = 0;
  bool right = false;
};
// COCO's: mean over recalls 0, 0.01, ..., 1 of the highest precision at that recall or above.
double AveragePrecision(std::vector<Detection> detections, int wanted);

// BOP24: average precision of each object that has an instance to be found. A table without
// instances adds wrong estimates only.
std::map<int, double> AveragePrecisions(const std::vector<ErrorTable>& tables, double threshold);

}  // namespace pickbed::bop
