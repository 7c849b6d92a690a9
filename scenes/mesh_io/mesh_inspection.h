#pragma once

// Checks a mesh file before an object is made from it. It reports guesses, repairs and doubtful
// properties. Meshes that cannot be used are rejected.

#include <filesystem>
#include <string>
#include <vector>

#include "scenes/geometry/triangle_mesh.h"

namespace pickbed::scenes {

struct UnitGuess {
  std::string unit;    // m, cm, mm, in
  std::string reason;  // one line
};

// Guesses the unit of a mesh from its diameter in the file's own numbers, so that a gripper can
// pick the object. The result is m, else mm, if the object is then between 5 mm and 0.6 m.
// Otherwise it is the unit that brings the diameter nearest to 0.1 m.
UnitGuess GuessUnit(double diameter_in_file);

// A loaded mesh and the findings about its file.
struct InspectedMesh {
  TriangleMesh mesh_O;  // m, faces outwards
  std::string unit;     // as given or guessed
  bool watertight = false;
  int shells = 0;                  // groups of faces that are connected by shared edges
  std::vector<std::string> fixed;  // repairs, one line each
  std::vector<std::string> notes;  // guesses and doubtful properties, one line each
};

// Loads and checks a mesh file. An empty `unit` is guessed. `center` moves the origin to the center
// of the bounding box. Throws what LoadMesh() and RequireUsableMesh() throw. Also throws InputError
// for an object under 3 mm or over 5 m, and for an origin that is over 100 box diagonals away
// unless `center` is set.
InspectedMesh InspectMeshFile(const std::filesystem::path& file, const std::string& unit,
                              bool center);

// Returns the material and texture files that an OBJ or glTF file names but that do not exist.
std::vector<std::string> MissingCompanions(const std::filesystem::path& file);

}  // namespace pickbed::scenes
