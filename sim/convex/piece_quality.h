#pragma once

// Quality measures of convex pieces against their mesh, and a decomposition that reaches a given
// quality.

#include <vector>

#include "sim/convex/convex_pieces.h"

namespace pickbed::sim {

// Geometric errors of convex pieces relative to their mesh.
struct PieceQuality {
  int pieces = 0;
  int vertices = 0;
  double bulge_m = 0;       // largest distance to the mesh of a piece's surface point outside it
  double missed_m = 0;      // largest distance to the pieces of a mesh surface point outside all
  double volume_error = 0;  // sum of the piece volumes over the mesh volume, minus 1
};

// Measures by samples of both surfaces, which are the same for the same input. Ray crossings decide
// what is outside the mesh, so the results for an open mesh are estimates. A piece without a volume
// covers nothing; missed_m is infinite if no piece has one. Throws InputError if the mesh encloses
// no positive volume.
PieceQuality MeasurePieces(const TriangleMesh& mesh, const std::vector<ConvexPiece>& pieces);

struct FittedPieces {
  std::vector<ConvexPiece> pieces;
  PieceQuality quality;
};

// Decomposes in finer steps, up to 64 pieces, until the bulge is at most `bulge_diameters` times
// the mesh's diameter. Returns the result with the smallest bulge if no step reaches it.
FittedPieces FitConvexPieces(const TriangleMesh& mesh, double bulge_diameters = 0.02);

}  // namespace pickbed::sim
