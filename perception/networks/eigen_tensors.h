#pragma once

// Copies of tensors as Eigen matrices.

#include <torch/types.h>

#include <Eigen/Core>

#include "perception/layer.h"

namespace pickbed::perception {

inline Eigen::VectorXf ToVector(const at::Tensor& tensor) {
  const at::Tensor values = tensor.detach().contiguous();
  return Eigen::Map<const Eigen::VectorXf>(values.data_ptr<float>(), values.numel());
}

inline Eigen::MatrixXf ToMatrix(const at::Tensor& tensor) {
  const at::Tensor values = tensor.detach().contiguous();
  using RowMajor = Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  return Eigen::Map<const RowMajor>(values.data_ptr<float>(), values.size(0), values.size(1));
}

}  // namespace pickbed::perception
