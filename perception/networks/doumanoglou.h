#pragma once

// Settings and losses of the pose regression network of doumanoglou.cpp.

#include <string>

#include "perception/layer.h"
#include "scenes/base/settings.h"

namespace at {
class Tensor;
}

namespace pickbed::perception {

struct RegressionOptions {
  std::string rotation = "quaternion";  // quaternion (as in the paper) | six_d (Zhou et al. 2019)
  double siamese_weight = 0.5;          // lambda; 0 = only regression
  double offset_weight = 2;             // weight of the offset in L_regress, over the rotation's
  double object_weight = 0.2;  // weight of the object classification, if there are several objects
  void Visit(SettingsVisitor& v);
};

// Converts N rows to N x 3 x 3 rotation matrices. `values` is N x 4, quaternions w x y z of any
// norm, or N x 6, two columns that are orthonormalised.
at::Tensor RotationMatrices(const at::Tensor& values);

// Returns N distances from each row's rotation to the nearest of its symmetric rotations. For small
// angles it is half the angle. For `values` of N x 4 it is the minimum of |q -+ q_s| with unit q.
// For N x 6 it is the minimum Frobenius norm |R - R_s| / sqrt(8). `rotations` is N x variants x 4.
at::Tensor QuaternionDistance(const at::Tensor& values, const at::Tensor& rotations);

// Returns the mean of | |f_i - f_j| - d(pose_i, pose_j) | over all pairs of an anchor i and a code
// j of the same object. pose_distance is d in diameters. Pairs with same_object 0 are ignored.
at::Tensor SiameseLoss(const at::Tensor& anchors, const at::Tensor& codes,
                       const at::Tensor& pose_distance, const at::Tensor& same_object);

}  // namespace pickbed::perception
