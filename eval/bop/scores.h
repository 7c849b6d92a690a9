#pragma once

// Converts pose errors to the scores of the BOP challenge. This file only handles numbers;
// eval/bop/score_accumulator.h computes the errors.
//
// BOP19 (6D localisation, Hodan et al. 2020, sec. 2.4): the object and its number n of instances in
// an image are given. The n estimates with the highest scores count; the n most visible instances
// are to be found. Recall at a threshold = found / to be found. Average recall = its mean over
// thresholds.
// BOP24 (6D detection): only the image is given. All estimates of an image count, at most the 100
// with the highest scores (200 for xyzibd). Estimates of an object that the image does not have do
// not count, as in the BOP toolkit. Instances less than 10 % visible need not be found, and
// an estimate of such an instance is neither right nor wrong. Average precision is computed for
// each object at each threshold, as in COCO (101 recall levels). Its mean is taken over thresholds,
// then over the objects that occur. bop24_mAP is the mean over MSSD and MSPD. BOP25: bop25_mAP is
// the part of bop24_mAP for MSSD. bop25_mAP_mm is the same for MSSD in mm, with thresholds of 2, 4,
// ... 20 mm.

#include <cstddef>
#include <map>
#include <vector>

#include "eval/layer.h"

namespace pickbed::eval {

inline constexpr int kMaxEstimatesOfImage = 100;   // BOP24
inline constexpr int kMaxEstimatesOfXyzibd = 200;  // the same for the data set xyzibd
inline constexpr double kMinVisible = 0.1;         // BOP24

// Errors of all estimates of one object in one image against its instances there.
struct ErrorTable {
  int object_id = 0;
  std::vector<double> scores;               // one per estimate
  std::vector<double> visible;              // visible fraction of each instance
  std::vector<std::vector<double>> errors;  // [estimate][instance]
};

// Matches estimates greedily, highest score first (equal scores: the earlier one). Each estimate
// takes the instance with the smallest error below the threshold that is allowed and not yet taken.
// Returns the index of the matched instance for each estimate, -1 = none.
std::vector<int> MatchGreedily(const ErrorTable& table, const std::vector<bool>& allowed,
                               double threshold);

// Returns the indices of the `count` highest scores, highest first; all if there are fewer.
std::vector<int> HighestScores(const std::vector<double>& scores, size_t count);
// Returns one flag per instance: true for the `count` most visible ones.
std::vector<bool> MostVisible(const std::vector<double>& visible, size_t count);

struct Recall {
  int found = 0;
  int wanted = 0;
  double value() const { return wanted > 0 ? static_cast<double>(found) / wanted : 0; }
};

// Computes the BOP19 recall of one object in one image, in which `count` instances are to be found.
Recall RecallOf(const ErrorTable& table, int count, double threshold);

// One estimate in a precision-recall curve.
struct Detection {
  double score = 0;
  bool right = false;
};
// Computes COCO's average precision: the mean over recalls 0, 0.01, ..., 1 of the highest precision
// at that recall or above. Recalls are compared as the BOP toolkit does, in floating point: 7 of 10
// does not reach the level 0.7, because 70 * 0.01 is larger.
double AveragePrecision(std::vector<Detection> detections, int wanted);

// Computes the BOP24 average precision of each object that has an instance to be found. A table
// without instances only adds wrong estimates.
std::map<int, double> AveragePrecisions(const std::vector<ErrorTable>& tables, double threshold);

// Recall of the instances with at least some visible fraction.
struct FloorRecall {
  double visible_min = 0;
  int instances = 0;
  int correct = 0;            // with MSSD under a tenth of the diameter
  double average_recall = 0;  // mean over the MSSD thresholds of BOP
};

}  // namespace pickbed::eval
