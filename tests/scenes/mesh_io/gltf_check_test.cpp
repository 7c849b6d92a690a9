#include "scenes/mesh_io/gltf_check.h"

#include <gmock/gmock.h>

#include "scenes/mesh_io/mesh_text_check.h"
#include "scenes/mesh_io/scene_export.h"
#include "tests/scenes/shapes.h"

namespace pickbed::tests {
namespace {

using testing::AllOf;
using testing::HasSubstr;

constexpr const char* kGltf = R"({"asset":{"version":"2.0","generator":"x"},"scene":0,
"scenes":[{"nodes":[0,1]}],"extensionsUsed":["OTHER_thing"],
"nodes":[{"mesh":0,"matrix":[1,0,0,0,0,1,0,0,0,0,1,0,0,0,2,1],"extras":{"meshh":"a"}},
{"mesh":0,"translation":[1,2,3],"rotation":[0,0,0.70711,0.70711],"scale":[1,2,1]}],
"meshes":[{"primitives":[{"attributes":{"POSITION":0,"TEXCOORD_0":0,"_OWN":0},"indices":1,
"mode":4,"material":0}]}],
"materials":[{"doubleSided":true,"pbrMetallicRoughness":{"baseColorFactor":[1,0.5,0,1]},
"normalTexture":{"index":0,"scale":0.5}}],
"animations":[{"channels":[{"sampler":0,"target":{"node":0,"path":"rotation"}}],
"samplers":[{"input":0,"output":0,"interpolation":"LINEAR"}]}],
"buffers":[{"uri":"a.bin","byteLength":72}],
"bufferViews":[{"buffer":0,"byteOffset":0,"byteLength":48},
{"buffer":0,"byteOffset":48,"byteLength":24}],
"accessors":[{"bufferView":0,"componentType":5126,"count":4,"type":"VEC3",
"sparse":{"count":1,"indices":{"bufferView":1,"componentType":5123},"values":{"bufferView":0}}},
{"bufferView":1,"componentType":5123,"count":12,"type":"SCALAR"}]})";

std::string GltfWith(const std::string& from, const std::string& to) {
  std::string gltf = kGltf;
  EXPECT_NE(gltf.find(from), std::string::npos) << from;
  return gltf.replace(gltf.find(from), from.size(), to);
}

TEST(CheckGltf, AcceptsAllPartsOfTheFormat) {
  const TemporaryFolder folder;
  EXPECT_NO_THROW(CheckGltf(folder.Write("a.gltf", kGltf)));
  EXPECT_NO_THROW(CheckGltf(folder.Write("a.gltf", "\xef\xbb\xbf" + std::string(kGltf))));
  // Keys of programs, names of extensions and what is below them are not checked.
  for (const char* more : {"\"userData\":{\"index\":-1,\"mode\":\"edit\"}", "\"url\":\"x\"",
                           "\"lights\":[]", "\"height\":2"}) {
    EXPECT_NO_THROW(CheckGltf(
        folder.Write("a.gltf", GltfWith("\"scene\":0", std::string("\"scene\":0,") + more))))
        << more;
  }
  for (const char* name : {"BINORMAL", "TEXCOORD", "KHR_gaussian_splatting:SCALE"}) {
    EXPECT_NO_THROW(CheckGltf(folder.Write("a.gltf", GltfWith("TEXCOORD_0", name)))) << name;
  }
  // Keys of extensions are their own, and version 1 has other keys.
  EXPECT_NO_THROW(CheckGltf(folder.Write(
      "a.gltf", GltfWith("\"scene\":0", "\"scene\":0,\"extensions\":{\"X\":{\"meshs\":-1}}"))));
  EXPECT_NO_THROW(CheckGltf(
      folder.Write("a.gltf", R"({"asset":{"version":"1.0"},"nodes":{"a":{"mesh":"b"}}})")));
}

TEST(CheckGltf, DamagedTextsAreRefusedWithTheirPlace) {
  struct {
    const char *from, *to, *message;
  } const cases[] = {
      {"\"matrix\"", "\"matri\xc6\"", "its text is no JSON from byte"},
      {"\"scene\":0", "\"scene\":", "its text is no JSON from byte"},
      {"\"byteLength\":72", "\"byteLength\":1e999", "has a number that is too large"},
      {"\"mesh\":0", "\"mesh\":0,\"mesh\":1", "an object has the key 'mesh' twice"},
      {"{\"version\":\"2.0\"", "{\"version\":\"7\"", "asset has '7' for version"},
      {"{\"version\":\"2.0\"", "{\"version\":\"1xy\"", "asset has '1xy' for version"},
      {"\"normalTexture\"", "\"emissiveFactor\":[1,1],\"normalTexture\"", "not 3 numbers"},
      {"\"asset\"", "\"assets\"", "asset has 'null' for version"},
      {"\"matrix\"", "\"matriy\"", "'nodes/0/matriy' is an unknown key; did you mean matrix?"},
      {"\"doubleSided\"", "\"doubleSmded\"", "did you mean doubleSided?"},
      {"\"mode\":4", "\"mode\":1e-300", "meshes/0/primitives/0/mode is 1e-300, which is no whole"},
      {"\"mode\":4", "\"mode\":{}", "meshes/0/primitives/0/mode is {}, which is no whole"},
      {"\"nodes\":[0,1]", "\"nodes\":0", "scenes/0/nodes is 0, which is no list"},
      {"\"mode\":4", "\"mode\":7", "meshes/0/primitives/0/mode is 7, which is no mode"},
      {"\"count\":12", "\"count\":-12", "accessors/1/count is -12, which is no whole number"},
      {"\"indices\":1", "\"indices\":\"1\"", "indices is \"1\", which is no whole number"},
      {"\"nodes\":[0,1]", "\"nodes\":[0,0.5]", "scenes/0/nodes is 0.5, which is no whole number"},
      {"[1,2,3]", "[1,2]", "nodes/1/translation is [1,2], not 3 numbers"},
      {"[1,2,3]", "[1,2,null]", "nodes/1/translation is [1,2,null], not 3 numbers"},
      {"0.70711]", "7.0711]", "nodes/1/rotation is [0,0,0.70711,7.0711], whose length is not 1"},
      {"[1,0.5,0,1]", "[1e19,0.5,0,1]", "has 1e+19, which is not within 0 and 1"},
      {"\"POSITION\"", "\"POSITJON\"", "attributes has the unknown name 'POSITJON'"},
      {"\"TEXCOORD_0\"", "\"TEXCOORD_x\"", "attributes has the unknown name 'TEXCOORD_x'"},
  };
  const TemporaryFolder folder;
  for (const auto& test : cases) {
    const std::string file = folder.Write("a.gltf", GltfWith(test.from, test.to));
    EXPECT_THAT(InputErrorOf([&] { CheckMeshText(file); }),
                AllOf(HasSubstr(file), HasSubstr(test.message)))
        << test.to;
  }
}

TEST(CheckGltf, DeepTextsAreRefused) {
  const TemporaryFolder folder;
  const std::string file = folder.Write("a.gltf", std::string(100000, '['));
  EXPECT_THAT(InputErrorOf([&] { CheckGltf(file); }), HasSubstr("is nested too deep"));
}

TEST(CheckGltf, TheHeaderOfAGlbMustFitItsBytes) {
  const TemporaryFolder folder;
  const TriangleMesh mesh = BoxShape({1, 1, 1});
  const std::string glb = GlbBytes(std::vector{GlbPart{"box", &mesh}}, {});
  EXPECT_NO_THROW(CheckGltf(folder.Write("a.glb", glb)));
  EXPECT_THAT(InputErrorOf([&] { CheckGltf(folder.Write("a.glb", glb + "x")); }),
              HasSubstr("its header names"));
  EXPECT_THAT(InputErrorOf([&] { CheckGltf(folder.Write("a.glb", glb.substr(0, 15))); }),
              HasSubstr("its header is cut short"));
  std::string long_text = glb;
  long_text[15] = 1;  // highest byte of the length of the text
  EXPECT_THAT(InputErrorOf([&] { CheckGltf(folder.Write("a.glb", long_text)); }),
              HasSubstr("which it has no room for"));
}

}  // namespace
}  // namespace pickbed::tests
