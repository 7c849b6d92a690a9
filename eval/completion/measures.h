#pragma once

// Measures of a completion against the true shape.

#include <array>
#include <vector>

#include "eval/layer.h"
#include "perception/completion/completed_volume.h"
#include "perception/completion/random_view.h"

namespace pickbed::eval {

// Distance up to which hidden surface counts as found.
inline constexpr float kHiddenTolerance_m = 0.002f;
// Tolerance of the F-score, share of the diameter.
inline constexpr float kFScoreShare = 0.01f;
inline constexpr int kCalibrationBins = 10;

struct CompletionMeasures {
  double iou = 0;
  double chamfer = 0;       // mean distance of both directions, share of the diameter; 1 if empty
  double f_score = 0;       // of surface points within kFScoreShare of the diameter
  double hidden_found = 0;  // share of the hidden true surface within kHiddenTolerance_m
  // Cells by probability that are not 0: number, sum of the probabilities, number inside.
  std::array<std::array<double, 3>, kCalibrationBins> calibration{};
};

// Returns points (m, in C) on the surface of a level, on the lines between centers of cells.
std::vector<Eigen::Vector3f> SurfacePoints(const CompletedVolume& volume, float level);

// Returns points (m, in C) on the true surface within the volume's cube, by bisection between the
// centers of its cells. `truth` is TrueVolume() (eval/completion/draw.h).
std::vector<Eigen::Vector3f> TrueSurfacePoints(const ViewedSolid& solid, const RandomView& drawn,
                                               const CompletedVolume& truth);

// Compares a completion with the truth on the same cells. Cells above `level` are full. `surface`
// are TrueSurfacePoints().
CompletionMeasures MeasureCompletion(const CompletedVolume& completed, const CompletedVolume& truth,
                                     const std::vector<Eigen::Vector3f>& surface,
                                     const RandomView& drawn, double diameter_m,
                                     float level = 0.5f);

}  // namespace pickbed::eval
