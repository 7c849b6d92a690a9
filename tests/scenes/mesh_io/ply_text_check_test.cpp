#include "scenes/mesh_io/ply_text_check.h"

#include <gmock/gmock.h>

#include "scenes/mesh_io/mesh_io.h"
#include "tests/scenes/shapes.h"

namespace pickbed::tests {
namespace {

using testing::HasSubstr;

constexpr const char* kHeader =
    "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float "
    "z\nproperty uchar red\nproperty uchar green\nproperty uchar blue\nelement face 1\nproperty "
    "list uchar int vertex_indices\nend_header\n";

// A triangle with this second vertex and this face.
std::string Ply(const std::string& vertex = "0.1 0 0 255 0 0",
                const std::string& face = "3 0 1 2") {
  return kHeader + ("0 0 0 1 2 3\n" + vertex + "\n0 0.1 0 1 2 3\n" + face + "\n");
}

std::string Replaced(const std::string& from, const std::string& to) {
  std::string ply = Ply();
  return ply.replace(ply.find(from), from.size(), to);
}

struct PlyCase {
  const char* name;
  std::string bytes;
  std::string message;  // empty if the file is fine
};

TEST(PlyText, ValuesMustFitTheHeader) {
  const PlyCase cases[] = {
      {"fine", Ply(), ""},
      {"spaces, signs, exponents and empty lines", Ply(" +1e-1  0\t0 255 0 0 \r\n", "3 0 1 2\n\n"),
       ""},
      {"a color over 255", Ply("0.1 0 0 256 0 0"),
       "line 14 has 256 for red, but the type uchar has whole numbers from 0 to 255"},
      {"a negative color", Ply("0.1 0 0 0 -1 0"), "line 14 has -1 for green"},
      {"a broken color", Ply("0.1 0 0 0 0 0.5"), "line 14 has 0.5 for blue"},
      {"a color that is no number", Ply("0.1 0 0 0 0 nan"), "line 14 has nan for blue"},
      {"a color beyond all numbers", Ply("0.1 0 0 0 0 1e999"), "line 14 has 1e999 for blue"},
      {"a broken number", Ply("0.1.2 0 0 1 2 3"), "'0.1.2' for x, which is no number"},
      {"a word", Ply("0.1 y 0 1 2 3"), "'y' for y, which is no number"},
      {"too few values", Ply("0.1 0 0 1 2"), "line 14 has no value for blue"},
      {"too many values", Ply("0.1 0 0 1 2 3 4"), "line 14 has more values"},
      {"a short face", Ply("0.1 0 0 1 2 3", "3 0 1"), "line 16 has no value for vertex_indices"},
      {"a long face", Ply("0.1 0 0 1 2 3", "3 0 1 2 0"), "line 16 has more values"},
      {"a face of many corners", Ply("0.1 0 0 1 2 3", "300 0 1 2"), "line 16 has 300"},
      {"an index that is not whole", Ply("0.1 0 0 1 2 3", "3 0 1 1.5"), "line 16 has 1.5"},
      {"an unknown type", Replaced("property uchar red", "property uch red"),
       "line 7 has an unknown type: 'property uch red'"},
      {"a list counted by a float", Replaced("list uchar", "list float"), "line 11 has an unknown"},
      {"an unknown statement", Replaced("property uchar red", "propert uchar red"),
       "line 7 of its header is no statement of PLY: 'propert uchar red'"},
      {"an unknown version", Replaced("ascii 1.0", "ascii inf"), "the version 'inf' of PLY"},
      {"missing lines", Ply().substr(0, Ply().size() - 8), "it has 0 lines of them"},
      {"another format", "solid x\nfacet 1\n", ""},
  };
  for (const PlyCase& test : cases) {
    const TemporaryFolder folder;
    const std::string file = folder.Write("a.ply", test.bytes);
    if (test.message.empty()) {
      EXPECT_NO_THROW(CheckPlyText(file)) << test.name;
      continue;
    }
    const std::string message = InputErrorOf([&] { CheckPlyText(file); });
    EXPECT_THAT(message, HasSubstr(test.message)) << test.name;
    EXPECT_THAT(message, HasSubstr(file)) << test.name;
    EXPECT_EQ(InputErrorOf([&] { LoadMesh(file); }), message) << test.name;
  }
}

}  // namespace
}  // namespace pickbed::tests
