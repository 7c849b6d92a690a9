#include "perception/completion_networks/completion_net.h"

#include <torch/nn/functional/vision.h>

#include "scenes/base/error.h"

namespace pickbed::perception {

CompletionCode CompletionCode::Rows(int64_t first, int64_t last) const {
  return {volume.slice(0, first, last), image.defined() ? image.slice(0, first, last) : image};
}

at::Tensor SampledCode(const at::Tensor& volume, const at::Tensor& places) {
  namespace F = torch::nn::functional;
  const int64_t n = places.size(0), points = places.size(1);
  return F::grid_sample(volume, places.reshape({n, points, 1, 1, 3}),
                        F::GridSampleFuncOptions()
                            .mode(torch::kBilinear)
                            .padding_mode(torch::kBorder)
                            .align_corners(false))
      .view({n, volume.size(1), points})
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
