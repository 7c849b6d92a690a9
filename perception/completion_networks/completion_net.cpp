#include "perception/completion_networks/completion_net.h"

#include <torch/nn/functional/vision.h>

#include "scenes/base/error.h"

namespace pickbed::perception {

at::Tensor SampledCode(const at::Tensor& code, const at::Tensor& queries) {
  namespace F = torch::nn::functional;
  const int64_t n = queries.size(0), points = queries.size(1);
  const at::Tensor places = queries.slice(2, 0, 3).view({n, points, 1, 1, 3});
  return F::grid_sample(code, places,
                        F::GridSampleFuncOptions()
                            .mode(torch::kBilinear)
                            .padding_mode(torch::kBorder)
                            .align_corners(false))
      .view({n, code.size(1), points})
      .transpose(1, 2);
}

const std::vector<CompletionNetRow>& CompletionNetTable() {
  static const std::vector<CompletionNetRow> table{
      {"implicit", "3D U-Net with an implicit decoder", false, MakeImplicitNet},
      {"vae", "variational auto-encoder of volumes", true, MakeVolumeVae},
  };
  return table;
}

}  // namespace pickbed::perception
