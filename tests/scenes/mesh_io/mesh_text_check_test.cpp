#include "scenes/mesh_io/mesh_text_check.h"

#include <gmock/gmock.h>

#include "scenes/mesh_io/mesh_io.h"
#include "scenes/mesh_io/number_words.h"
#include "tests/scenes/shapes.h"

namespace pickbed::tests {
namespace {

using testing::HasSubstr;

TEST(NumberIn, IsTheWholeWord) {
  EXPECT_EQ(NumberIn("1.5"), 1.5);
  EXPECT_EQ(NumberIn("+2"), 2);
  EXPECT_EQ(NumberIn("-1e-3"), -1e-3);
  EXPECT_EQ(NumberIn("1e999"), std::numeric_limits<double>::infinity());
  for (const char* word :
       {"", "+", "1.5.2", "0x10", "1e", "one", "1true", ">0", "--1", "-12345678901234567890"}) {
    EXPECT_FALSE(NumberIn(word)) << word;
  }
}

struct TextCase {
  const char* name;
  std::string bytes;
  std::string message;  // empty if the file is fine
};

// Each broken file is refused with the same line by the check and when it is loaded.
void ExpectChecked(const std::vector<TextCase>& cases, const char* file_name) {
  for (const TextCase& test : cases) {
    const TemporaryFolder folder;
    const std::string file = folder.Write(file_name, test.bytes);
    if (test.message.empty()) {
      EXPECT_NO_THROW(CheckMeshText(file)) << test.name;
      EXPECT_NO_THROW(LoadMesh(file)) << test.name;
      continue;
    }
    const std::string message = InputErrorOf([&] { CheckMeshText(file); });
    EXPECT_EQ(InputErrorOf([&] { LoadMesh(file); }), message) << test.name;
    EXPECT_THAT(message, HasSubstr(test.message)) << test.name;
    EXPECT_THAT(message, HasSubstr(file)) << test.name;
  }
}

// A tetrahedron with this line before its faces.
std::string Obj(const std::string& line) {
  return "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n" + line + "\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";
}

TEST(ObjText, NumbersAndCornersAreChecked) {
  ExpectChecked(
      {{"fine", Obj("# text: v x"), ""},
       {"colors, weights, spaces", Obj("  v\t1 1 1 0.5 +0.5 1e-1 # red \r\nvt 0 1 2"), ""},
       {"statements of other programs", Obj("o a b\ng\ns off\nusemtl red-1 x\nxyz ?\nl 1 2"), ""},
       {"a continued line", Obj("v 1 1 \\\n1"), ""},
       {"a word in a number", Obj("v 0 0.1 0true"), "line 5 '0true' is no number"},
       {"a sign before a number", Obj("v >0 0 0"), "line 5 '>0' is no number"},
       {"a broken normal", Obj("vn 0 0 0x10"), "line 5 '0x10' is no number"},
       {"a broken texture coordinate", Obj("vt 0 1.5.2"), "line 5 '1.5.2' is no number"},
       {"too few numbers", Obj("v 0 1"), "line 5 has 2 numbers after 'v'"},
       {"vertices with weight and color", Obj("v 0 1 0 1 0.5 0.5 0.5\nv 0 1 0 1"), ""},
       {"too many numbers", Obj("v 0 1 0 1 0.5 0.5 0.5 1"), "line 5 has 8 numbers after 'v'"},
       {"a normal of four numbers", Obj("vn 0 0 4 3"), "line 5 has 4 numbers after 'vn'"},
       {"lines and points", Obj("l 1 2 3\np 1"), ""},
       {"a line without corners", Obj("l"), "line 5 has 0 corners after 'l'"},
       {"a point that is no corner", Obj("p x"), "line 5 'x' is no corner"},
       {"a broken corner", Obj("f 1 2 3x"), "line 5 '3x' is no corner of a face"},
       {"a corner with four numbers", Obj("f 1 2 3/1/1/1"), "'3/1/1/1' is no corner"},
       {"a keyword with other bytes", Obj("mt\xa3lib a.mtl"), "which is no word"},
       {"a rest of a line", Obj("4 3"), "line 5 begins with '4', which is no word"},
       {"two lines that are joined", Obj("use1 3/2"), "begins with 'use1', which is no word"},
       {"corners with normals", Obj("vn 0 0 1\nf 1//1 2//1 3//-1"), ""},
       {"a normal that does not exist", Obj("vn 0 0 1\nf 1//1 2//2 3//1"),
        "line 6 has a face with normal 2, but the file has 1"},
       {"texture coordinates that do not exist", Obj("f 1/1 2/1 3/1"),
        "line 5 has a face with texture coordinate 1, but the file has 0"},
       {"a cut corner", Obj("f 1/1/1 2/1/1 3"), "has corners of two forms, '1/1/1' and '3'"},
       {"a corner without a normal", Obj("f 1//1 2/1/1 3//1"), "forms, '1//1' and '2/1/1'"}},
      "a.obj");
}

std::string Stl(const std::string& second) {
  return "solid a b\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 "
         "0\nendloop\nendfacet\n" +
         second + "endsolid a b\n";
}

TEST(StlText, EveryWordIsChecked) {
  const std::string facet =
      "facet normal 0 1 0 outer loop vertex 0 0 0 vertex 1 0 0 vertex 0 0 1 endloop endfacet\n";
  const auto with = [&](const std::string& from, const std::string& to) {
    std::string changed = facet;
    return Stl(changed.replace(changed.find(from), from.size(), to));
  };
  ExpectChecked(
      {{"fine", Stl(facet), ""},
       {"capitals", with("endfacet", "ENDFACET"), ""},
       {"a normal of a facet without area", with("0 1 0", "nan -nan nan"), ""},
       {"two solids", Stl("endsolid\nsolid\n" + facet), ""},
       {"a broken word", with("endloop", "e.dloop"), "facet 1 has 'e.dloop' in place of endloop"},
       {"a broken facet", with("facet", "f4cet"), "facet 1 has 'f4cet' in place of facet"},
       {"a broken number", with("0 0 1", "0 0 1x"), "'1x' in place of number"},
       {"two vertices", with("vertex 1 0 0 ", ""), "'endloop' in place of vertex"},
       {"two numbers", with("1 0 0", "1 0"), "'vertex' in place of number"}},
      "a.stl");
}

}  // namespace
}  // namespace pickbed::tests
