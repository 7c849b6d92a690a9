#include "perception/networks/patch_network.h"

namespace pickbed {

std::span<const PatchNetworkRow> PatchNetworkTable() {
  static constexpr PatchNetworkRow rows[] = {
      {"convolutional", "three convolutions and two full layers, 80 k weights",
       MakeConvolutionalNetwork},
  };
  return rows;
}

}  // namespace pickbed
