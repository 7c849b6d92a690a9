#include "scenes/mesh_io/material_check.h"

#include <gmock/gmock.h>

#include "scenes/mesh_io/mesh_io.h"
#include "tests/scenes/shapes.h"

namespace pickbed::tests {
namespace {

using testing::HasSubstr;

struct MaterialCase {
  const char* name;
  std::string bytes;
  std::string message;  // empty if the file is fine
};

// Each broken file is refused with the same line by the check and when its mesh is loaded.
TEST(MaterialFile, WordsAndNumbersAreChecked) {
  const std::string begin = "# made by hand\nnewmtl red\n";
  const MaterialCase cases[] = {
      {"fine", begin + "Kd 1 0 0\r\nKa 0.5 0.5 0.5\nd 0.5\nNs 96.1\nillum 2\n", ""},
      {"nothing", "", "is empty"},
      {"options of a map", begin + "map_Kd -s 1 1 1 -clamp on a.tga\n", ""},
      {"a statement of another program", begin + "interpolation 3\n", ""},
      {"a texture of another program", begin + "map_RMA a.png\n", ""},
      {"an emission over 1", begin + "Ke 20 20 20\n", ""},
      {"a broken number", begin + "Kd 1 0.0.1 0\n", "line 3 of its material file"},
      {"a word", begin + "Kd 1 x 0\n", "'x' is no number"},
      {"too few numbers", begin + "Kd\n", "has 0 numbers"},
      {"one number of a color", begin + "Kd 1", "has 1 number"},
      {"too many numbers", begin + "Kd 1 0 0 0\n", "has 4 numbers"},
      {"a color over 1", begin + "Kd 255 0 0\n", "has 255 for Kd, which is not within 0 and 1"},
      {"a negative color", begin + "Kd 1 -1 0\n", "has -1 for Kd"},
      {"a misspelled word", begin + "newmtx blue\n", "'newmtx'; did you mean newmtl?"},
      {"a misspelled short word", begin + "Kf 1 0 0\n", "the unknown word 'Kf'"},
      {"a key with a digit", begin + "p1Kd 1 0 0\n", "the unknown word 'p1Kd'"},
      {"a texture of an unknown word", begin + "matl d a.png\n", "the unknown word 'matl'"},
      {"no word", begin + "K\x01 1 0 0\n", "which is no word"},
      {"no name", begin + "map_Kd\n", "has nothing after map_Kd"},
      {"two textures", begin + "map_Kd a.png\nmap_Kd b.png\n", "has map_Kd for the second time"},
      {"sides of a cube", begin + "refl -type cube_top a.png\nrefl -type cube_left a.png\n", ""},
      {"two materials", begin + "Kd 1 0 0\nnewmtl blue\nKd 0 0 1\n", ""},
      {"control character", begin + "map_Kd a\x1a.png\n", "bytes that are no text"},
      {"cut in a word", begin + "map", "has no end"},
      {"no material", "Kd 1 0 0\n", "is before the first newmtl"},
  };
  for (const MaterialCase& test : cases) {
    const TemporaryFolder folder;
    const std::string mesh =
        folder.Write("a.obj", "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl red\nf 1 2 3\n");
    const std::string file = folder.Write("a.mtl", test.bytes);
    if (test.message.empty()) {
      EXPECT_NO_THROW(CheckMaterialFile(mesh, file)) << test.name;
      EXPECT_NO_THROW(LoadMesh(mesh)) << test.name;
      continue;
    }
    const std::string message = InputErrorOf([&] { CheckMaterialFile(mesh, file); });
    EXPECT_THAT(message, HasSubstr(test.message)) << test.name;
    EXPECT_THAT(message, HasSubstr(file)) << test.name;
    EXPECT_EQ(InputErrorOf([&] { LoadMesh(mesh); }), message) << test.name;
  }
}

}  // namespace
}  // namespace pickbed::tests
