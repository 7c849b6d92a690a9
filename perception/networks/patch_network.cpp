#include "perception/networks/patch_network.h"

#include <ATen/core/Tensor.h>

#include <stdexcept>

#include "scenes/base/error.h"

namespace pickbed::perception {

at::Tensor PatchNetwork::Poses(const at::Tensor&) {
  throw std::logic_error("this network regresses no poses");
}

std::span<const PatchNetworkRow> PatchNetworkTable() {
  static constexpr PatchNetworkRow rows[] = {
      {"convolutional", "three convolutions and two fully connected layers, 80 k weights",
       MakeConvolutionalNetwork},
      {"autoencoder", "reconstructs the patch through a narrow layer (kehl)", MakeAutoencoder, true,
       false, AutoencoderChannels},
      {"siamese_regression",
       "regresses the pose; feature distances equal pose distances (doumanoglou)",
       MakeSiameseRegression, false, true},
  };
  return rows;
}

const PatchNetworkRow& FindPatchNetwork(const std::string& name) {
  std::vector<std::string> known;
  for (const PatchNetworkRow& row : PatchNetworkTable()) {
    if (name == row.name) return row;
    known.push_back(row.name);
  }
  throw InputError(UnknownNameMessage("network", name, known));
}

}  // namespace pickbed::perception
