#pragma once

// Completion of a segment by the network.

#include <span>
#include <vector>

#include "perception/completion/completed_volume.h"
#include "perception/completion/completion_network.h"

namespace pickbed::perception {

// Returns a volume of the cube with cells^3 zeros.
CompletedVolume EmptyVolume(const CompletionCube& cube, int cells);

// Returns the probabilities at the centers of the cells. Cells that are known to be empty are 0 and
// are not computed. The result is the mean over `turns` turned copies of the view. Throws
// InputError as CompletionInput does.
CompletedVolume CompleteWithNetwork(const CompletionNetwork& network, const SegmentView& view,
                                    int cells, int turns = 1);

// Does the same for several views, which pass the network together. The volume of a view that
// CompletionInput refuses is empty.
std::vector<CompletedVolume> CompleteAllWithNetwork(const CompletionNetwork& network,
                                                    std::span<const SegmentView> views, int cells,
                                                    int turns = 1);

}  // namespace pickbed::perception
