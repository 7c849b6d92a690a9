#pragma once

// What there is to say about a mesh file before a part is made of it: what was guessed, what was
// put right, what is doubtful. What cannot be used is refused.

#include <filesystem>
#include <string>
#include <vector>

#include "scenes/triangle_mesh.h"

namespace pickbed {

struct UnitGuess {
  std::string unit;    // m, cm, mm, in
  std::string reason;  // one line
};

// The unit that makes a thing of this size, in the file's own numbers, a part that one can pick: m
// or mm where the part is then between 5 mm and 0.6 m, otherwise whichever comes nearest to 0.1 m.
UnitGuess GuessUnit(double diameter_in_file);

struct InspectedMesh {
  TriangleMesh mesh_O;  // m, faces outwards
  std::string unit;     // as given or guessed
  bool watertight = false;
  int shells = 0;                  // connected by shared edges
  std::vector<std::string> fixed;  // one line each
  std::vector<std::string> notes;  // doubtful, but used as it is
};

// `unit` empty = guess. With `center`, the origin is moved to the middle of the bounding box.
// Throws InputError, besides where LoadMesh and RequireUsableMesh do, for a part under 3 mm or over
// 5 m and for more than 2 million faces.
InspectedMesh InspectMeshFile(const std::filesystem::path& file, const std::string& unit,
                              bool center);

// Material and texture files that an OBJ or glTF names and that are not there, in order.
std::vector<std::string> MissingCompanions(const std::filesystem::path& file);

}  // namespace pickbed
