// A damaged file of the cache is made again, which is said once, and never changes a result. Its
// content with a right check sum is what another version could have written: it must not crash.

#include <fmt/format.h>

#include <cmath>
#include <cstdlib>
#include <map>
#include <optional>
#include <set>

#include "grasp/candidates/candidates.h"
#include "grasp/grippers/table.h"
#include "perception/features/codebook.h"
#include "perception/segment_poses/volume_codebook.h"
#include "scenes/base/cache_file.h"
#include "scenes/base/error.h"
#include "scenes/geometry/mesh_bytes.h"
#include "scenes/mesh_io/mesh_io.h"
#include "scenes/plugin/plugin_messages.h"
#include "scenes/shape_families/mesh_cache.h"
#include "scenes/shape_families/solid_builder.h"
#include "sim/convex/convex_hull.h"
#include "sim/convex/convex_pieces.h"
#include "sim/drop/fill_counts.h"
#include "sim/drop/resting_poses.h"
#include "tests/eval/cube_scenario.h"
#include "tests/fuzz/format_targets.h"
#include "tests/fuzz/target_parts.h"
#include "tests/support/block_file.h"

namespace pickbed::tests {
namespace {

namespace fs = std::filesystem;

// The folder of the cache, and the distinct lines about damaged files, during its life.
class CacheAt {
 public:
  explicit CacheAt(const fs::path& home) {
    if (const char* former = std::getenv(kVariable)) former_ = former;
    setenv(kVariable, home.c_str(), 1);
    listener_ = SetCacheListener([this](const std::string& line) { lines.insert(line); });
  }
  ~CacheAt() {
    SetCacheListener(listener_);
    former_ ? setenv(kVariable, former_->c_str(), 1) : unsetenv(kVariable);
  }
  CacheAt(const CacheAt&) = delete;
  CacheAt& operator=(const CacheAt&) = delete;

  std::set<std::string> lines;

 private:
  static constexpr const char* kVariable = "XDG_CACHE_HOME";
  std::optional<std::string> former_;
  CacheListener listener_;
};

// Computes a value from the cache, or anew, and returns it as bytes.
using CachedValue = std::function<std::string()>;

// A sound file of the cache and its value.
struct SoundCache {
  fs::path file;  // in the folder of the cache
  std::string bytes, value;
};

SoundCache MakeSound(const std::string& extension, const CachedValue& value) {
  const TemporaryFolder home;
  const CacheAt cache(home.path());
  SoundCache sound;
  sound.value = value();
  for (const auto& entry : fs::recursive_directory_iterator(home.path())) {
    if (entry.path().extension() != extension) continue;
    RequireLaw(sound.file.empty(), "the value has one file");
    sound.file = fs::relative(entry.path(), home.path());
    sound.bytes = ReadFileBytes(entry.path());
  }
  return sound;
}

// A target of the file with this extension. It is made once, also for the processes that begin
// later.
FuzzTarget CacheTarget(const std::string& name, const std::string& extension, CachedValue value) {
  const auto sound = [name, extension, value]() -> const SoundCache& {
    static std::map<std::string, SoundCache> made;
    const auto found = made.find(name);
    if (found != made.end()) return found->second;
    return made.emplace(name, MakeSound(extension, value)).first->second;
  };
  const auto run = [sound, value](const fs::path& folder, const std::string& bytes) {
    const SoundCache& good = sound();
    CacheAt cache(folder);
    const fs::path file = folder / good.file;
    if (!fs::exists(file)) value();  // makes also the files beside it
    WriteFileAtomically(file, bytes);
    RequireLaw(value() == good.value, "a damaged cache changes no value");
    const std::set<std::string> said = cache.lines;
    RequireLaw(said.size() <= 1, "damage is said once");
    RequireLaw(value() == good.value && cache.lines == said, "a repaired cache is sound");
    WriteFileAtomically(file, WithRightHash(bytes));
    value();
    if (!said.empty()) throw InputError(*said.begin());
  };
  return {name, run, [sound] { return Contents{sound().bytes}; }, true, true, 20};
}

// ---- Values ----

std::string ImportedMeshValue() {
  static const TemporaryFolder folder;  // its path is part of the key
  static const fs::path mesh = folder.Write("a.obj",
                                            "v 0 0 0\nv 0.1 0 0\nv 0 0.1 0\nv 0 0 0.1\nf 1 3 2\nf "
                                            "1 2 4\nf 1 4 3\nf 2 3 4\n");
  return MeshToBytes(LoadMesh(mesh));
}

std::string ShapeValue() {
  static const SolidShape solid = CompiledSolid(Box({4, 3, 2}), 2);
  return MeshToBytes(CachedMeshOfSolid(solid));
}

// The value of a content that a function makes and another one reads.
template <typename Read, typename Write, typename Value>
std::string ContentValue(const char* name, Read read, Write write, const Value& made) {
  const auto make = [&] { return made; };
  return write(Cached(CacheDir() / name, read, make, write));
}

std::string CodesValue() {
  constexpr uint64_t kKey = 5;
  ObjectCodes codes;
  codes.length = 4;
  codes.descriptors = {1, 0, 0, 0, 0, 0.6f, 0.8f, 0};
  codes.X_PO.assign(2, Eigen::Matrix<float, 3, 4>::Identity());
  return ContentValue(
      "codes.bin", [](const std::string& content) { return CodesFromBytes(content, kKey); },
      [](const ObjectCodes& value) { return CodesToBytes(value, kKey); }, codes);
}

std::string VolumesValue() {
  constexpr uint64_t kKey = 5;
  VolumeBook book;
  book.side_m = 0.12;
  book.values.assign(kDescriptorValues, 0);
  book.values[3] = 1;
  book.X_FO = {Translation({0.01, 0.02, 0.03})};
  return ContentValue(
      "volumes.bin", [](const std::string& content) { return VolumeBookFromBytes(content, kKey); },
      [](const VolumeBook& value) { return VolumeBookToBytes(value, kKey); }, book);
}

std::string GraspsValue() {
  static const auto gripper = LoadGripper("jaw_8cm");
  const GraspCandidateOptions few{.antipodal = {.candidates = 4, .max_samples = 40, .max_pairs = 4},
                                  .robust = {.samples = 2}};
  std::string text;
  for (const GraspCandidate& candidate : CachedCandidates(*EasyCube()[0], *gripper, few)) {
    for (const double number : candidate.X_OG.matrix().reshaped())
      text += fmt::format("{} ", number);
    text += fmt::format("{} {} {} {}\n", candidate.width_m, candidate.depth_m, candidate.robust,
                        candidate.place_quality);
  }
  return text;
}

std::string PiecesValue() {
  auto cube = std::make_shared<ObjectModel>(*EasyCube()[0]);
  cube->convex_pieces_O.clear();
  const auto model = WithConvexPieces(cube);
  std::string text;
  for (const ConvexPiece& piece : model->convex_pieces_O) {
    RequireLaw(!MakeConvexHull(piece.vertices_O).vertices.empty(), "a piece has a volume");
    for (const Eigen::Vector3d& p : piece.vertices_O) {
      text += fmt::format("{} {} {}\n", p.x(), p.y(), p.z());
    }
  }
  return text;
}

std::string RestingValue() {
  auto cube = std::make_shared<ObjectModel>(*EasyCube()[0]);
  cube->resting_O.clear();
  const ObjectSet known = WithRestingDirections({cube});
  std::string text;
  for (const RestingDirection& resting : known[0]->resting_O) {
    RequireLaw(std::abs(resting.up_O.norm() - 1) < 1e-6, "a resting direction has unit length");
    text += fmt::format("{} {} {} {}\n", resting.up_O.x(), resting.up_O.y(), resting.up_O.z(),
                        resting.probability);
  }
  return text;
}

std::string FillValue() {
  Bin small;
  small.inner_size_m = {0.15, 0.12, 0.08};
  return fmt::format("{}", CountsForFill(small, EasyCube(), {1}, 0.6)[0]);
}

// The mesh that a plug-in gets.
std::string PluginMeshValue() {
  MessageWriter message;
  WriteSetup({EasyCube()}, CacheDir() / kPluginMeshesFolder, message);
  for (const auto& entry : fs::recursive_directory_iterator(CacheDir() / kPluginMeshesFolder)) {
    if (entry.path().extension() == ".obj") return ReadFileBytes(entry.path());
  }
  return "";
}

}  // namespace

std::vector<FuzzTarget> CacheTargets() {
  FuzzTarget shape = CacheTarget("cache_shape", ".mesh", ShapeValue);
  FuzzTarget resting = CacheTarget("cache_resting", ".txt", RestingValue);
  FuzzTarget fill = CacheTarget("cache_fill", ".txt", FillValue);
  shape.replays = resting.replays = fill.replays = 4;  // a second each
  return {
      shape,
      resting,
      fill,
      CacheTarget("cache_mesh", ".mesh", ImportedMeshValue),
      CacheTarget("cache_codes", ".bin", CodesValue),
      CacheTarget("cache_volumes", ".bin", VolumesValue),
      CacheTarget("cache_grasps", ".grasps", GraspsValue),
      CacheTarget("cache_pieces", ".pieces", PiecesValue),
      CacheTarget("cache_plugin_mesh", ".obj", PluginMeshValue),
      CacheTarget("cache_plugin_hash", ".hash", PluginMeshValue),
  };
}

}  // namespace pickbed::tests
