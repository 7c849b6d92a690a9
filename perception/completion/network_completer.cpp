#include "perception/completion/network_completer.h"

#include <utility>

#include "scenes/base/error.h"

namespace pickbed::perception {
namespace {

// The cells of a view that are not known to be empty.
struct Query {
  Query(const SegmentView& view, int cells)
      : input(view), volume(EmptyVolume(input.cube(), cells)) {
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
  }
  CompletedVolume Filled(const std::vector<float>& probabilities) {
    for (size_t i = 0; i < indices.size(); ++i) volume.occupancy[indices[i]] = probabilities[i];
    return std::move(volume);
  }

  CompletionInput input;
  CompletedVolume volume;
  std::vector<Eigen::Vector3f> points_C;
  std::vector<size_t> indices;
};

}  // namespace

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
  Query query(view, cells);
  return query.Filled(network.Probabilities(query.input, query.points_C, turns));
}

std::vector<CompletedVolume> CompleteAllWithNetwork(const CompletionNetwork& network,
                                                    std::span<const SegmentView> views, int cells,
                                                    int turns) {
  std::vector<CompletedVolume> volumes(views.size());
  std::vector<Query> queries;
  std::vector<size_t> owners;
  for (size_t i = 0; i < views.size(); ++i) {
    try {
      queries.emplace_back(views[i], cells);
      owners.push_back(i);
    } catch (const InputError&) {
      continue;  // its volume stays empty
    }
  }
  std::vector<NetworkQuery> asked;
  for (const Query& query : queries) asked.push_back({&query.input, query.points_C});
  const std::vector<std::vector<float>> probabilities = network.Probabilities(asked, turns);
  for (size_t i = 0; i < queries.size(); ++i) {
    volumes[owners[i]] = queries[i].Filled(probabilities[i]);
  }
  return volumes;
}

}  // namespace pickbed::perception
