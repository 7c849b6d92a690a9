#include "sim/mesh_levels.h"

namespace pickbed {

std::vector<MeshLevel> MakeMeshLevels(const TriangleMesh& mesh) { return {{mesh, 0.0}}; }

}  // namespace pickbed
