#pragma once

// Error of a depth image, measured from the image itself. Nothing is known about the camera.
//
// The error of a structured-light or time-of-flight camera grows with the square of the distance
// (Khoshelham and Elberink 2012), so lengths are stated at 1 m.

#include "perception/layer.h"
#include "scenes/image/image.h"

namespace pickbed::perception {

struct DepthStatistics {
  double noise_at_1m_m = 0;  // standard deviation between neighbours on smooth surfaces, along z
  double step_at_1m_m = 0;   // usual difference of neighbours that differ: the quantisation
  double hole_share = 0;     // of the pixels between the first and the last reading of a row

  // Standard deviation of both errors together, at 1 m. A step has a uniform error.
  double Error_m() const;
};

// Measures the readings of every fourth row. Errors that neighbours share do not count. Noise and
// step are 0 for fewer than 100 readings with both neighbours.
DepthStatistics MeasureDepth(const Image<float>& depth_m);

// Largest error of the sensors of the training, standard deviation at 1 m.
inline constexpr double kMaxTrainedError_m = 0.004;

// Factor for lengths that guard against noise: 1 within the range of the training, else the ratio
// to it, at most 4.
double ErrorScale(const DepthStatistics& statistics);

}  // namespace pickbed::perception
