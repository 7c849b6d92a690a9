#include "scenes/mesh_io/ply_check.h"

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
      {"a name with other bytes", Replaced("uchar red", "uchar \xff\xfered"),
       "line 7 has no name of a property"},
      {"a name that begins with a sign", Replaced("uchar red", "uchar |red"),
       "line 7 has no name of a property"},
      {"a property without a name", Replaced("uchar red", "uchar"),
       "line 7 has no name of a property: 'property uchar'"},
      {"a property twice", Replaced("uchar red", "uchar blue"),
       "line 9 names the property 'blue' again"},
      {"a line end within a name", Replaced("uchar green", "uchar \rred"),
       "line 8 names the property 'red' again"},
      {"a missing color", Replaced("uchar green", "uchar gre@n"),
       "its elements 'vertex' have a property 'blue' but none 'green'"},
      {"a missing coordinate", Replaced("float x", "float a"), "have a property 'z' but none 'x'"},
      {"a list counted by a float", Replaced("list uchar", "list float"), "line 11 has an unknown"},
      {"an unknown statement", Replaced("property uchar red", "propert uchar red"),
       "line 7 of its header is no statement of PLY: 'propert uchar red'"},
      {"an unknown version", Replaced("ascii 1.0", "ascii inf"), "the version 'inf' of PLY"},
      {"missing lines", Ply().substr(0, Ply().size() - 8), "it has 0 lines of them"},
      {"lines after the end", Ply() + "\n3 0 1 2\n",
       "line 18 is after its last element: '3 0 1 2'"},
      {"an unknown format", Replaced("ascii", "asci"), "the unknown format 'asci'"},
      {"another format", "solid x\nfacet 1\n", ""},
  };
  for (const PlyCase& test : cases) {
    const TemporaryFolder folder;
    const std::string file = folder.Write("a.ply", test.bytes);
    if (test.message.empty()) {
      EXPECT_NO_THROW(CheckPly(file)) << test.name;
      continue;
    }
    const std::string message = InputErrorOf([&] { CheckPly(file); });
    EXPECT_THAT(message, HasSubstr(test.message)) << test.name;
    EXPECT_THAT(message, HasSubstr(file)) << test.name;
    EXPECT_EQ(InputErrorOf([&] { LoadMesh(file); }), message) << test.name;
  }
}

// One vertex of a double, and two faces with a list of 16 bits, a number and another list.
std::string TwoFaces(bool is_big_endian) {
  const auto number = [&](size_t bytes, int value) {
    std::string text(bytes, '\0');
    text[is_big_endian ? bytes - 1 : 0] = static_cast<char>(value);
    return text;
  };
  const std::string form = is_big_endian ? "binary_big_endian" : "binary_little_endian";
  const std::string face =
      number(2, 3) + std::string(12, '\1') + number(1, 7) + number(4, 2) + std::string(16, '\1');
  return "ply\nformat " + form +
         " 1.0\nelement vertex 1\nproperty double quality\nelement face 2\nproperty list ushort "
         "int "
         "vertex_indices\nproperty char flag\nproperty list int float64 weight\nend_header\n" +
         std::string(8, '\0') + face + face;
}

TEST(PlyBinary, HasExactlyTheElementsOfItsHeader) {
  const TemporaryFolder folder;
  for (const bool is_big_endian : {false, true}) {
    const std::string ply = TwoFaces(is_big_endian);
    EXPECT_NO_THROW(CheckPly(folder.Write("a.ply", ply)));
    const size_t head = ply.find("end_header\n") + 11;
    for (size_t size = head; size < ply.size(); ++size) {
      const std::string file = folder.Write("cut.ply", ply.substr(0, size));
      EXPECT_THAT(InputErrorOf([&] { CheckPly(file); }), HasSubstr("it ends within its elements"))
          << size;
    }
    const std::string file = folder.Write("long.ply", ply + "\n");
    EXPECT_THAT(InputErrorOf([&] { CheckPly(file); }), HasSubstr("1 bytes after its last element"));
    std::string negative = ply;  // the size of the last list
    const size_t size_at = ply.size() - 20;
    for (size_t i = 0; i < 4; ++i) negative[size_at + i] = '\xff';
    EXPECT_THAT(InputErrorOf([&] { CheckPly(folder.Write("negative.ply", negative)); }),
                HasSubstr("has a negative size"));
  }
}

}  // namespace
}  // namespace pickbed::tests
