#include "tests/fuzz/targets.h"

#include <fmt/format.h>

#include <algorithm>

#include "eval/bop/check_dataset.h"
#include "eval/bop/dataset_scores.h"
#include "eval/bop/results_csv.h"
#include "eval/frames/frame_files.h"
#include "eval/sweep/sweep_spec.h"
#include "grasp/completed/success_network.h"
#include "grasp/grippers/table.h"
#include "perception/completion/completion_file.h"
#include "perception/completion_networks/network_options.h"
#include "perception/networks/model_file.h"
#include "perception/networks/verifier_file.h"
#include "perception/training/shared_verifier.h"
#include "scenes/base/error.h"
#include "scenes/base/files.h"
#include "scenes/image/image_check.h"
#include "scenes/image/image_io.h"
#include "scenes/image/number_image.h"
#include "scenes/mesh_io/material_check.h"
#include "scenes/mesh_io/mesh_file_check.h"
#include "scenes/mesh_io/mesh_import.h"
#include "scenes/mesh_io/mesh_io.h"
#include "scenes/mesh_io/mesh_text_check.h"
#include "scenes/mesh_io/scene_export.h"
#include "scenes/objects/object_catalog.h"
#include "scenes/plugin/message.h"
#include "scenes/scenario/find_scenario.h"
#include "scenes/scenario/scenario_spec.h"
#include "sim/sensor/sensor_profile.h"
#include "tests/eval/bop_small_dataset.h"
#include "tests/fuzz/store_targets.h"
#include "tests/support/block_file.h"
#include "tests/support/temporary_folder.h"

namespace pickbed::tests {
namespace {

namespace fs = std::filesystem;
using Contents = std::vector<std::string>;

Contents FilesOf(const fs::path& folder, const std::string& extension) {
  Contents contents;
  for (const std::string& stem : StemsIn(folder, extension)) {
    contents.push_back(ReadFileBytes(folder / (stem + extension)));
  }
  return contents;
}

// A target whose code reads one file of this name.
template <typename Read>
FuzzTarget OneFile(const std::string& name, const std::string& file_name, Read read,
                   std::function<Contents()> seeds) {
  const auto run = [file_name, read](const fs::path& folder, const std::string& bytes) {
    const fs::path file = folder / file_name;
    WriteFileAtomically(file, bytes);
    read(file);
  };
  return {name, run, std::move(seeds)};
}

// ---- Meshes ----

constexpr const char* kObj =
    "mtllib a.mtl\nv 0 0 0\nv 0.1 0 0\nv 0 0.1 0\nv 0 0 0.1\nvt 0 0\nvt 1 0\nvt 0 1\nvn 0 0 1\n"
    "usemtl red\nf 1/1/1 3/2/1 2/3/1\nf 1/1 2/2 4/3\nf 1 4 3\nf 2 3 4\n";
constexpr const char* kMtl = "newmtl red\nKd 1 0 0\nmap_Kd a.png\n";
constexpr const char* kPlyText =
    "ply\nformat ascii 1.0\ncomment made by hand\nelement vertex 4\nproperty float x\nproperty "
    "float y\nproperty float z\nproperty uchar red\nproperty uchar green\nproperty uchar blue\n"
    "element face 4\nproperty list uchar int vertex_indices\nend_header\n0 0 0 1 2 3\n0.1 0 0 1 2 "
    "3\n0 0.1 0 1 2 3\n0 0 0.1 1 2 3\n3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n";
constexpr const char* kStlText =
    "solid x\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 0.1 0 0\nvertex 0 0.1 "
    "0\nendloop\nendfacet\nfacet normal 0 1 0\nouter loop\nvertex 0 0 0\nvertex 0.1 0 0\nvertex 0 "
    "0 0.1\nendloop\nendfacet\nendsolid x\n";
constexpr const char* kDae =
    "<?xml version=\"1.0\"?><COLLADA xmlns=\"http://www.collada.org/2005/11/COLLADASchema\" "
    "version=\"1.4.1\"><asset><unit meter=\"1\"/><up_axis>Z_UP</up_axis></asset>"
    "<library_geometries><geometry id=\"g\"><mesh><source id=\"p\"><float_array id=\"pa\" "
    "count=\"12\">0 0 0 0.1 0 0 0 0.1 0 0 0 0.1</float_array><technique_common><accessor "
    "source=\"#pa\" count=\"4\" stride=\"3\"><param name=\"X\" type=\"float\"/><param name=\"Y\" "
    "type=\"float\"/><param name=\"Z\" type=\"float\"/></accessor></technique_common></source>"
    "<vertices id=\"v\"><input semantic=\"POSITION\" source=\"#p\"/></vertices><triangles "
    "count=\"4\"><input semantic=\"VERTEX\" source=\"#v\" offset=\"0\"/><p>0 2 1 0 1 3 0 3 2 1 2 "
    "3</p></triangles></mesh></geometry></library_geometries><library_visual_scenes><visual_scene "
    "id=\"s\"><node><instance_geometry url=\"#g\"/></node></visual_scene></library_visual_scenes>"
    "<scene><instance_visual_scene url=\"#s\"/></scene></COLLADA>";

template <typename Value>
void Put(Value value, std::string& bytes) {
  bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
}

constexpr float kCorners[4][3] = {{0, 0, 0}, {0.1f, 0, 0}, {0, 0.1f, 0}, {0, 0, 0.1f}};
constexpr int32_t kFaces[4][3] = {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}};

std::string BinaryPly() {
  std::string ply =
      "ply\nformat binary_little_endian 1.0\nelement vertex 4\nproperty float x\nproperty float "
      "y\nproperty float z\nelement face 4\nproperty list uchar int vertex_indices\nend_header\n";
  for (const auto& corner : kCorners) {
    for (const float x : corner) Put(x, ply);
  }
  for (const auto& face : kFaces) {
    Put(uint8_t{3}, ply);
    for (const int32_t index : face) Put(index, ply);
  }
  return ply;
}

std::string BinaryStl() {
  std::string stl(80, ' ');
  Put(uint32_t{4}, stl);
  for (const auto& face : kFaces) {
    for (int i = 0; i < 3; ++i) Put(0.f, stl);
    for (const int32_t index : face) {
      for (const float x : kCorners[index]) Put(x, stl);
    }
    Put(uint16_t{0}, stl);
  }
  return stl;
}

// Loads a mesh. The importer runs in a child process. libFuzzer does not see the coverage of this
// process, and its crashes are refusals, so that our own code around the importer runs here, too.
// An importer that has not crashed in the child does not crash here.
void ReadMesh(const fs::path& file) {
  CheckMeshFile(file);
  CheckMeshText(file);
  LoadMesh(file);
  ImportMesh(file, 1);
}

FuzzTarget MeshTarget(const std::string& extension, Contents seeds) {
  return OneFile("mesh_" + extension, "a." + extension, ReadMesh, [seeds] { return seeds; });
}

FuzzTarget MaterialTarget() {
  const auto run = [](const fs::path& folder, const std::string& bytes) {
    WriteFileAtomically(folder / "a.obj", kObj);
    WriteFileAtomically(folder / "a.mtl", bytes);
    CheckMaterials(folder / "a.obj", {folder / "a.mtl"});
    ReadMesh(folder / "a.obj");
  };
  return {"material", run, [] { return Contents{kMtl}; }};
}

TriangleMesh Tetrahedron() {
  TriangleMesh mesh;
  for (const auto& c : kCorners) mesh.vertices.emplace_back(c[0], c[1], c[2]);
  for (const auto& f : kFaces) mesh.triangles.emplace_back(f[0], f[1], f[2]);
  return mesh;
}

FuzzTarget ObjectTarget() {
  const auto run = [](const fs::path& folder, const std::string& bytes) {
    const fs::path object = folder / "catalog" / "x";
    MakeFolder(object);
    SaveObj(object / "mesh.obj", Tetrahedron());
    WriteFileAtomically(object / "object.yaml", bytes);
    ObjectCatalog({folder / "catalog"}).Load("x");
  };
  constexpr const char* kObject =
      "mesh: mesh.obj\nunit: m\ndensity_kgpm3: 2700\nfriction: 0.5\nsymmetries:\n  discrete:\n    "
      "- "
      "{axis: [0, 0, 1], angle_deg: 180}\n  continuous: []\n";
  constexpr const char* kHeavy =
      "mesh: mesh.obj\nunit: m\nmass_kg: 0.2\ninertia_diagonal_kgm2: [0.0002, 0.0002, "
      "0.0002]\ncom_m: [0.02, 0.02, 0.02]\nfriction: 0.4\n";
  return {"object", run, [] { return Contents{kObject, kHeavy}; }};
}

// ---- BOP datasets ----

// A dataset with one file replaced.
class SmallDataset {
 public:
  SmallDataset() { MakeSmall(temporary_.path(), 1, 2); }
  std::string Read(const std::string& file) const {
    return ReadFileBytes(temporary_.path() / file);
  }
  void CopyTo(const fs::path& folder) const {
    fs::copy(temporary_.path(), folder, fs::copy_options::recursive);
  }

 private:
  const TemporaryFolder temporary_;
};

const SmallDataset& Small() {
  static const SmallDataset dataset;
  return dataset;
}

FuzzTarget BopTarget(const std::string& name, const std::string& file) {
  const auto run = [file](const fs::path& folder, const std::string& bytes) {
    const fs::path root = folder / "set";
    fs::remove_all(root);
    Small().CopyTo(root);
    WriteFileAtomically(root / file, bytes);
    const std::vector<std::string> faults = CheckDataset(root).faults;
    EvaluateDataset(root, "test", {});
    if (!faults.empty()) throw InputError(faults.front());
  };
  FuzzTarget target{"bop_" + name, run, [file] { return Contents{Small().Read(file)}; }};
  target.reads_file = false;  // other files of the set can be at fault
  return target;
}

// ---- Models ----

Contents ModelAsset(const std::string& name) {
  return {ReadFileBytes(AssetsDir() / "models" / name)};
}

// One of each kind. The shipped model has 2.6 MB of weights, so that few mutations would hit the
// rest.
Contents SmallCompletionModels() {
  const TemporaryFolder temporary;
  const fs::path file = temporary.path() / "a.net";
  Contents contents;
  for (const std::string& kind : CompletionKinds()) {
    CompletionModelInfo info;
    info.network.kind = kind;
    info.network.width_16 = info.network.width_8 = info.network.width_4 = 4;
    info.network.bottleneck = info.network.image_width = 4;
    info.network.hidden = 16;
    SaveCompletionModel(file, info, CompletionNetwork(info.network));
    contents.push_back(ReadFileBytes(file));
  }
  return contents;
}

Contents SharedVerifiers() {
  const TemporaryFolder temporary;
  const fs::path file = temporary.path() / "a.net";
  SaveSharedVerifier(file, LoadModel(AssetsDir() / "models" / "shipped.net").verifiers[0].unknown,
                     "kinect_v1", "verifier.hidden 24");
  return {ReadFileBytes(file)};
}

template <typename Read>
FuzzTarget ModelTarget(const std::string& name, Contents (*seeds)(), Read read) {
  const auto run = [read](const fs::path& folder, const std::string& bytes) {
    const fs::path file = folder / "a.net";
    WriteFileAtomically(file, WithRightHash(bytes));
    read(file);
  };
  return {name, run, seeds};
}

FuzzTarget MessageTarget() {
  const auto run = [](const fs::path&, const std::string& bytes) {
    ReadMessageValue(std::as_bytes(std::span(bytes)));
  };
  const auto seeds = [] {
    MessageWriter writer;
    writer.BeginMap(4);
    writer.Text("score");
    writer.Real(0.5);
    writer.Text("items");
    writer.BeginList(3);
    writer.Nil();
    writer.Bool(true);
    writer.Integer(-70000);
    writer.Text("count");
    writer.Unsigned(uint64_t{1} << 40);
    writer.Text("pose");
    const std::vector<double> numbers(12, 1.5);
    writer.Numbers(numbers, std::vector<size_t>{3, 4});
    std::string bytes;
    for (const std::span<const std::byte> chunk : writer.Chunks()) {
      bytes.append(reinterpret_cast<const char*>(chunk.data()), chunk.size());
    }
    return Contents{bytes};
  };
  FuzzTarget target{"message", run, seeds};
  target.reads_file = false;
  return target;
}

// ---- Images ----

Contents PngSeeds() {
  return {EncodePng(Image<Rgb8>(9, 7), 3), EncodePng(Image<uint16_t>(9, 7), 3),
          EncodeJpeg(Image<Rgb8>(9, 7), 90)};
}

// Gives the chunks of a mutated PNG right check sums, so that the decoder is reached.
std::string WithRightCheckSums(std::string png) {
  constexpr size_t kHead = 8, kFrame = 12;
  const auto at = [&](size_t i) { return size_t{static_cast<unsigned char>(png[i])}; };
  for (size_t chunk = kHead; chunk + kFrame <= png.size();) {
    const size_t size = at(chunk) << 24 | at(chunk + 1) << 16 | at(chunk + 2) << 8 | at(chunk + 3);
    if (size > png.size() - chunk - kFrame) break;
    const size_t end = chunk + 8 + size;
    const uint32_t sum = PngCheckSum(std::string_view(png).substr(chunk + 4, 4 + size));
    for (int i = 0; i < 4; ++i) png[end + i] = static_cast<char>(sum >> (24 - 8 * i));
    chunk = end + 4;
  }
  return png;
}

FuzzTarget PngChunkTarget() {
  const auto run = [](const fs::path& folder, const std::string& bytes) {
    const fs::path file = folder / "a.png";
    WriteFileAtomically(file, WithRightCheckSums(bytes));
    ReadPng(file);
    if (!HasColorChannels(file)) ReadNumberImage(file);
  };
  const auto seeds = [] {
    Image<Rgb8> color(9, 7);
    Image<uint16_t> depth(9, 7);
    for (size_t i = 0; i < color.size(); ++i) {
      const auto number = static_cast<uint8_t>(31 * i);
      color.data()[i] = {number, static_cast<uint8_t>(number / 2), 7};
      depth.data()[i] = static_cast<uint16_t>(500 + 37 * i);
    }
    return Contents{EncodePng(Image<uint16_t>(9, 7), 3), EncodePng(depth, 3), EncodePng(color, 3)};
  };
  return {"png_chunks", run, seeds};
}

std::string NumpyDepth() {
  std::string header = "{'descr': '<f4', 'fortran_order': False, 'shape': (6, 8), }";
  header.resize(117, ' ');
  std::string npy = "\x93NUMPY";
  npy += std::string("\x01\x00\x76\x00", 4) + header + "\n";
  for (int i = 0; i < 48; ++i) Put(0.5f + 0.01f * static_cast<float>(i), npy);
  return npy;
}

std::string CloudPcd() {
  std::string pcd =
      "# .PCD v0.7\nVERSION 0.7\nFIELDS x y z rgb\nSIZE 4 4 4 4\nTYPE F F F U\nCOUNT 1 1 1 "
      "1\nWIDTH "
      "8\nHEIGHT 6\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS 48\nDATA binary\n";
  for (int i = 0; i < 48; ++i) {
    Put(0.01f * static_cast<float>(i % 8 - 4), pcd);
    Put(0.01f * static_cast<float>(i / 8 - 3), pcd);
    Put(0.5f, pcd);
    Put(uint32_t{0x808080}, pcd);
  }
  return pcd;
}

FuzzTarget DepthTarget() {
  const auto run = [](const fs::path& folder, const std::string& bytes) {
    WriteFileAtomically(folder / "depth.npy", bytes);
    FrameFiles files;
    files.image = folder / "depth.npy";
    files.intrinsics = "20,20,4,3";
    ReadFrameFiles(files);
  };
  FuzzTarget target{"depth_npy", run, [] { return Contents{NumpyDepth()}; }};
  target.reads_file = false;  // the intrinsics can be at fault, too
  return target;
}

FuzzTarget CloudTarget() {
  const auto run = [](const fs::path& folder, const std::string& bytes) {
    WriteFileAtomically(folder / "cloud.pcd", bytes);
    FrameFiles files;
    files.image = folder / "cloud.pcd";
    ReadFrameFiles(files);
  };
  return {"cloud_pcd", run, [] { return Contents{CloudPcd()}; }};
}

constexpr const char* kResults =
    "scene_id,im_id,obj_id,score,R,t,time\n1,1,1,0.9,1 0 0 0 1 0 0 0 1,10 20 500,0.1\n1,2,1,0.5,0 "
    "-1 0 1 0 0 0 0 1,-10.5 0 612.25,-1\n";

std::vector<FuzzTarget> MakeTargets() {
  const auto assets = [](const char* folder) {
    return [folder] { return FilesOf(AssetsDir() / folder, ".yaml"); };
  };
  const auto presets = [](bool sweeps) {
    return [sweeps] {
      Contents contents = FilesOf(PresetsDir(), ".yaml");
      std::erase_if(contents, [sweeps](const std::string& text) {
        return (text.find("\ngrid:") != std::string::npos) != sweeps;
      });
      return contents;
    };
  };
  return {
      OneFile(
          "scenario", "a.yaml", [](const fs::path& file) { LoadScenario(file); }, presets(false)),
      OneFile(
          "sweep", "a.yaml",
          [](const fs::path& file) {
            MakeSweep(LoadSweepSpec(file), file.parent_path() / "out", "");
          },
          [] {
            return Contents{
                "scenario: demo\ntrials: 3\nset: {camera.focal_px: 700}\ngrid:\n  sensor: [ideal, "
                "time_of_flight]\n  seed: 1..3\n  fill: {half: {objects.0.count: 4}, full: "
                "{objects.0.count: 9}}\nslurm: {shards: 4, partition: short, time: 2:00:00}\n"};
          }),
      OneFile(
          "gripper", "a.yaml", [](const fs::path& file) { LoadGripper(file.string()); },
          assets("grippers")),
      OneFile(
          "sensor", "a.yaml", [](const fs::path& file) { LoadSensorProfile(file.string()); },
          assets("sensors")),
      OneFile(
          "bin", "a.yaml", [](const fs::path& file) { LoadBin(file.string()); }, assets("bins")),
      ObjectTarget(),
      MeshTarget("obj", {kObj}),
      MeshTarget("ply", {kPlyText, BinaryPly()}),
      MeshTarget("stl", {kStlText, BinaryStl()}),
      MeshTarget("dae", {kDae}),
      MaterialTarget(),
      BopTarget("camera", "test/000001/scene_camera.json"),
      BopTarget("truth", "test/000001/scene_gt.json"),
      BopTarget("truth_info", "test/000001/scene_gt_info.json"),
      BopTarget("models_info", "models/models_info.json"),
      BopTarget("targets", "test_targets_bop19.json"),
      BopTarget("model", "models/obj_000001.ply"),
      BopTarget("depth", "test/000001/depth/000001.png"),
      OneFile(
          "results_csv", "a.csv", [](const fs::path& file) { ReadEstimates(file); },
          [] { return Contents{kResults}; }),
      OneFile(
          "png", "a.png", [](const fs::path& file) { ReadPng(file); }, PngSeeds),
      OneFile(
          "png16", "a.png", [](const fs::path& file) { ReadPng16(file); },
          [] { return Contents{EncodePng(Image<uint16_t>(9, 7), 3)}; }),
      PngChunkTarget(),
      DepthTarget(),
      CloudTarget(),
      StoreTarget(),
      StoreSqlTarget(),
      ModelTarget(
          "model", [] { return ModelAsset("shipped.net"); },
          [](const fs::path& file) { LoadModel(file); }),
      ModelTarget(
          "verifiers", [] { return ModelAsset("ppf.net"); },
          [](const fs::path& file) { LoadVerifiers(file, "ppf"); }),
      ModelTarget("shared_verifier", SharedVerifiers,
                  [](const fs::path& file) { LoadSharedVerifier(file); }),
      ModelTarget("completion_model", SmallCompletionModels,
                  [](const fs::path& file) { LoadCompletionModel(file); }),
      ModelTarget(
          "success_network", [] { return ModelAsset("grasps.net"); },
          [](const fs::path& file) { LoadSuccessNetwork(file); }),
      MessageTarget(),
  };
}

}  // namespace

std::span<const FuzzTarget> FuzzTargets() {
  static const std::vector<FuzzTarget> targets = MakeTargets();
  return targets;
}

const FuzzTarget& FindFuzzTarget(const std::string& name) {
  std::vector<std::string> names;
  for (const FuzzTarget& target : FuzzTargets()) {
    if (target.name == name) return target;
    names.push_back(target.name);
  }
  throw InputError(UnknownNameMessage("target", name, names));
}

}  // namespace pickbed::tests
