#pragma once

// Settings of the regression of doumanoglou.cpp, its two losses, and its training.

#include <string>

#include "scenes/settings.h"

namespace at {
class Tensor;
}

namespace pickbed {

struct TrainingOptions;  // training.h

struct RegressionOptions {
  std::string rotation = "quaternion";  // quaternion (the paper's) | six_d (Zhou et al. 2019)
  double siamese_weight = 0.5;          // lambda; 0 = plain regression
  double offset_weight = 2;             // of the offset in L_regress, over the rotation's
  double part_weight = 0.2;             // of telling parts apart, where there are several
  void Visit(SettingsVisitor& v);
};

// The rotations of N rows as matrices: N x 3 x 3. values: N x 4 (quaternions w x y z of any length)
// or N x 6 (two columns, made orthonormal).
at::Tensor RotationMatrices(const at::Tensor& values);

// Distance of each row's rotation to the nearest of its symmetric ones, N values: half the angle
// between them where it is small. values: N x 4: least |q -+ q_s| with q of unit length; N x 6:
// least Frobenius norm |R - R_s| / sqrt(8). rotations: N x variants x 4.
at::Tensor RotationDistance(const at::Tensor& values, const at::Tensor& rotations);

// Mean over the pairs of | |f_i - f_j| - d(pose_i, pose_j) |, i an anchor and j a code of the same
// part; pose_distance in diameters. Pairs with same_part 0 don't count.
at::Tensor SiameseLoss(const at::Tensor& anchors, const at::Tensor& codes,
                       const at::Tensor& pose_distance, const at::Tensor& same_part);

// By default for `pickbed train doumanoglou`.
TrainingOptions DoumanoglouTraining();

}  // namespace pickbed
