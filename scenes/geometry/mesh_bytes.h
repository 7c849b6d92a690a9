#pragma once

// A mesh as bytes, for caches and for messages between processes of this program.

#include <string>
#include <string_view>

#include "scenes/geometry/triangle_mesh.h"

namespace pickbed::scenes {

// Returns all members of the mesh. Equal meshes give equal bytes.
std::string MeshToBytes(const TriangleMesh& mesh);
// Throws InputError if the bytes are cut short, or if the mesh is inconsistent: a triangle with a
// vertex that does not exist, an attribute of another size than the vertices, or a vertex that is
// not finite.
TriangleMesh MeshFromBytes(std::string_view bytes);

}  // namespace pickbed::scenes
