#pragma once

// Convex collision pieces of an object. They come with the object, or from a decomposition of its
// mesh by plane cuts, which is cached on disk by mesh hash.

#include <memory>
#include <vector>

#include "scenes/objects/object_model.h"
#include "sim/layer.h"

namespace pickbed::sim {

// Options of DecomposeConvex().
struct DecompositionOptions {
  int max_pieces = 16;
  int max_vertices = 32;        // maximum vertices of one hull
  double max_air_share = 0.02;  // allowed air in one hull, as a share of the object's volume
};

// Cuts the mesh (CutByPlanes) and takes the hull of each piece. A hull is thinned to `max_vertices`
// by adding, one by one, the vertex that is farthest outside the hull of those added before. Throws
// InputError if a vertex is not finite.
std::vector<ConvexPiece> DecomposeConvex(const TriangleMesh& mesh,
                                         const DecompositionOptions& options = {});

// Returns the model itself if it has pieces, else a copy with pieces from the cache or a new
// decomposition. Throws InputError if the mesh encloses no volume.
std::shared_ptr<const ObjectModel> WithConvexPieces(std::shared_ptr<const ObjectModel> model,
                                                    const DecompositionOptions& options = {});
// Same for each object of a set.
ObjectSet WithConvexPieces(const ObjectSet& objects, const DecompositionOptions& options = {});

}  // namespace pickbed::sim
