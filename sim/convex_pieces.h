#pragma once

// Convex pieces of a part for physics: those that came with the part, or a decomposition of its
// mesh by best-first plane cuts, cached on disk by mesh hash.

#include <memory>
#include <vector>

#include "scenes/object_model.h"

namespace pickbed {

struct DecompositionOptions {
  int max_pieces = 16;
  int max_vertices = 32;        // of a hull
  double max_air_share = 0.02;  // a hull that holds more of the part's volume as air is cut further
};

// Hulls of the mesh clipped to boxes, thinned to `max_vertices` by taking, one by one, the vertex
// that stands out furthest from the hull of those taken before.
std::vector<ConvexPiece> DecomposeConvex(const TriangleMesh& mesh,
                                         const DecompositionOptions& options = {});

// The model itself when it has pieces, else a copy with them, from the cache or made now.
std::shared_ptr<const ObjectModel> WithConvexPieces(std::shared_ptr<const ObjectModel> model,
                                                    const DecompositionOptions& options = {});
ObjectSet WithConvexPieces(const ObjectSet& objects, const DecompositionOptions& options = {});

}  // namespace pickbed
