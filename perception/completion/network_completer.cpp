#include "perception/completion/network_completer.h"

namespace pickbed::perception {

CompletedVolume EmptyVolume(const CompletionCube& cube, int cells) {
  CompletedVolume volume;
  volume.origin_C = cube.origin_C;
  volume.cell_m = cube.side_m / static_cast<float>(cells);
  volume.size = cells;
  volume.occupancy.assign(static_cast<size_t>(cells) * cells * cells, 0);
  return volume;
}

CompletedVolume CompleteWithNetwork(const CompletionNetwork& network, const SegmentView& view,
                                    int cells, int turns) {
  const CompletionInput input(view);
  CompletedVolume volume = EmptyVolume(input.cube(), cells);
  std::vector<Eigen::Vector3f> points_C;
  std::vector<size_t> indices;
  for (int z = 0; z < cells; ++z) {
    for (int y = 0; y < cells; ++y) {
      for (int x = 0; x < cells; ++x) {
        const Eigen::Vector3f p_C = volume.Center_C(x, y, z);
        if (input.IsKnownEmpty(p_C)) continue;
        points_C.push_back(p_C);
        indices.push_back(volume.Index(x, y, z));
      }
    }
  }
  const std::vector<float> probabilities = network.Probabilities(input, points_C, turns);
  for (size_t i = 0; i < indices.size(); ++i) volume.occupancy[indices[i]] = probabilities[i];
  return volume;
}

}  // namespace pickbed::perception
