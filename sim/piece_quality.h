#pragma once

// How well convex pieces stand for a mesh, and pieces that are good enough.

#include <vector>

#include "sim/convex_pieces.h"

namespace pickbed {

struct PieceQuality {
  int pieces = 0;
  int vertices = 0;
  double bulge_m = 0;       // largest distance of a piece's surface outside the mesh to the mesh
  double missed_m = 0;      // largest distance of the mesh's surface outside all pieces to them
  double volume_error = 0;  // sum of the pieces' volumes over the mesh's, less 1
};

// By samples of both surfaces, the same for the same input. Outside is told by crossings of a ray,
// so the figures of an open mesh are estimates.
PieceQuality MeasurePieces(const TriangleMesh& mesh, const std::vector<ConvexPiece>& pieces);

struct FittedPieces {
  std::vector<ConvexPiece> pieces;
  PieceQuality quality;
};

// Decomposes ever more finely, up to 64 pieces, until no piece bulges by more than
// `bulge_diameters` of the mesh's diameter; where none gets there, the one that bulges least.
FittedPieces FitConvexPieces(const TriangleMesh& mesh, double bulge_diameters = 0.02);

}  // namespace pickbed
