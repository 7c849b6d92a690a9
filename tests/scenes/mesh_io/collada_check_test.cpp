#include "scenes/mesh_io/collada_check.h"

#include <gmock/gmock.h>

#include "scenes/mesh_io/mesh_io.h"
#include "tests/scenes/shapes.h"

namespace pickbed::tests {
namespace {

using testing::HasSubstr;

constexpr const char* kDae = R"(<?xml version="1.0"?>
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
<asset><unit meter="1"/><up_axis>Z_UP</up_axis></asset>
<library_effects><effect id="e"><profile_COMMON><technique sid="t"><lambert>
<diffuse><color>1 0 0 1</color></diffuse></lambert></technique></profile_COMMON></effect></library_effects>
<library_geometries><geometry id="g"><mesh>
<source id="p"><float_array id="pa" count="12">0 0 0 1 0 0 0 1 0 0 0 1</float_array>
<technique_common><accessor source="#pa" count="4" stride="3"><param name="X" type="float"/>
<param name="Y" type="float"/><param name="Z" type="float"/></accessor></technique_common></source>
<vertices id="v"><input semantic="POSITION" source="#p"/></vertices>
<triangles count="2"><input semantic="VERTEX" source="#v" offset="0"/><p>0 2 1 0 1 3</p></triangles>
<polylist count="2"><input semantic="VERTEX" source="#v" offset="0"/><vcount>3 3</vcount><p>0 3 2 1 2 3</p></polylist>
</mesh></geometry></library_geometries>
<library_visual_scenes><visual_scene id="s"><node><translate>0 0 1</translate>
<matrix>1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1</matrix><instance_geometry url="#g"/></node></visual_scene></library_visual_scenes>
<scene><instance_visual_scene url="#s"/></scene></COLLADA>
)";

std::string DaeWith(const std::string& from, const std::string& to) {
  std::string dae = kDae;
  EXPECT_NE(dae.find(from), std::string::npos) << from;
  return dae.replace(dae.find(from), from.size(), to);
}

// Each broken file is refused with the same line by the check and when it is loaded.
TEST(Collada, CountsAndNumbersAreChecked) {
  struct {
    const char* name;
    std::string bytes, message;
  } const cases[] = {
      {"fine", kDae, ""},
      {"an array with too few values", DaeWith("0 0 1</float", "0 0</float"),
       "line 7: <float_array> has 11 values, but names 12"},
      {"a broken number in an array", DaeWith("0 0 1</float", "0 0 1.0.1</float"),
       "<float_array> has '1.0.1', which is no number"},
      {"a count that is none", DaeWith("count=\"12\"", "count=\"1x\""), "'1x' for count"},
      {"an accessor beyond its array", DaeWith("count=\"4\"", "count=\"5\""),
       "<accessor> takes 15 values, but its array has 12"},
      {"a parameter with a broken name", DaeWith("<param name=\"X\"", "<para- name=\"X\""),
       "<accessor> has 2 parameters, but a stride of 3"},
      {"a parameter with a broken type", DaeWith("\"X\" type=\"float", "\"X\" type=\"f-oat"),
       "<param> has the type"},
      {"text that is not UTF-8", DaeWith("\"X\" type=\"float", "\"X\" type=\"f\xefoat"),
       "is not UTF-8"},
      {"another namespace", DaeWith("www.collada.org", "www.comlada.org"),
       "<COLLADA> has the namespace 'http://www.comlada.org"},
      {"a negative version of XML", DaeWith("version=\"1.0\"", "version=\"-1.0\""),
       "line 1 has the XML version '-1.0', which is none"},
      {"an input without its offset", DaeWith("offset=\"0\"/><p>0 2", "offsut=\"0\"/><p>0 2"),
       "<input> has '' for offset, which is no whole number"},
      {"a version that is none", DaeWith("version=\"1.4.1\"", "version=\"-inf\""),
       "<COLLADA> has the version '-inf', which is none"},
      {"too few triangles", DaeWith("triangles count=\"2\"", "triangles count=\"1\""),
       "<triangles> has 6 indices, but needs 3"},
      {"too many triangles", DaeWith("triangles count=\"2\"", "triangles count=\"3\""),
       "<triangles> has 6 indices, but needs 9"},
      {"too few sizes of faces", DaeWith("<vcount>3 3", "<vcount>3"),
       "<vcount> has 1 numbers, but there are 2 faces"},
      {"other sizes of faces", DaeWith("<vcount>3 3", "<vcount>3 4"),
       "<polylist> has 6 indices, but needs 7"},
      {"a negative index", DaeWith("<p>0 2", "<p>-1 2"), "<p> has '-1', which is no index"},
      {"an index with a broken digit", DaeWith("<p>0 2", "<p>x 2"),
       "<p> has 'x', which is no index"},
      {"a color with a word", DaeWith("1 0 0 1</color", "1 x 0 1</color"), "<color> has 'x'"},
      {"a color of two numbers", DaeWith("1 0 0 1</color", "1 0</color"), "<color> has 2 numbers"},
      {"a short matrix", DaeWith("0 0 0 1</matrix", "0 0 0</matrix"), "<matrix> has 15 numbers"},
      {"a geometry that is missing", DaeWith("url=\"#g\"", "url=\"#h\""),
       "the geometry '#h', which the file does not have"},
      {"a unit that is none", DaeWith("meter=\"1\"", "meter=\"-1\""), "'-1' for meter"},
      {"an element that is not closed", DaeWith("</library_effects>", ""),
       "Start-end tags mismatch"},
      {"another format", "<html></html>", "is no begin of a COLLADA file"},
  };
  for (const auto& test : cases) {
    const TemporaryFolder folder;
    const std::string file = folder.Write("a.dae", test.bytes);
    if (test.message.empty()) {
      EXPECT_NO_THROW(CheckCollada(file)) << test.name;
      EXPECT_EQ(LoadMesh(file).triangles.size(), 4u) << test.name;
      continue;
    }
    const std::string message = InputErrorOf([&] { CheckCollada(file); });
    EXPECT_THAT(message, HasSubstr(test.message)) << test.name;
    EXPECT_THAT(message, HasSubstr(file)) << test.name;
    EXPECT_EQ(InputErrorOf([&] { LoadMesh(file); }), message) << test.name;
  }
}

}  // namespace
}  // namespace pickbed::tests
