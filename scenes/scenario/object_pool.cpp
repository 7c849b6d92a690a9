#include "scenes/scenario/object_pool.h"

#include <fmt/format.h>
#include <fnmatch.h>

#include <algorithm>
#include <array>
#include <map>
#include <set>

#include "scenes/base/error.h"
#include "scenes/base/random.h"
#include "scenes/shape_families/sampled_names.h"

namespace pickbed::scenes {
namespace {

namespace fs = std::filesystem;

bool HasPattern(const std::string& path) { return path.find_first_of("*?") != std::string::npos; }

bool IsMeshFile(const fs::path& file) {
  constexpr std::array<const char*, 6> kExtensions{".obj", ".stl", ".ply", ".dae", ".gltf", ".glb"};
  std::string extension = file.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return std::find(kExtensions.begin(), kExtensions.end(), extension) != kExtensions.end();
}

// Returns the meshes that match a pattern, relative to the scenario's folder like the pattern.
std::vector<fs::path> MatchingMeshes(const fs::path& folder, const std::string& pattern) {
  const fs::path path(pattern), parent = path.parent_path();
  CheckInput(!HasPattern(parent.string()),
             fmt::format("'{}': only the file name may have * or ?, not a folder", pattern));
  CheckInput(fs::is_directory(folder / parent),
             fmt::format("'{}': there is no folder {}", pattern, (folder / parent).string()));
  std::vector<fs::path> files;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder / parent)) {
    const fs::path name = entry.path().filename();
    const bool matches = fnmatch(path.filename().c_str(), name.c_str(), 0) == 0;
    if (matches && IsMeshFile(name)) files.push_back(parent / name);
  }
  CheckInput(!files.empty(),
             fmt::format("'{}': no mesh file has such a name; check the pattern", pattern));
  std::sort(files.begin(), files.end());
  return files;
}

std::vector<ObjectSpec> ObjectsOf(const ObjectSpec& entry, const fs::path& folder) {
  std::vector<ObjectSpec> objects;
  if (HasPattern(entry.mesh)) {
    for (const fs::path& file : MatchingMeshes(folder, entry.mesh)) {
      ObjectSpec& object = objects.emplace_back(entry);
      object.name = fmt::format("{}/{}", entry.name, file.stem().string());
      object.mesh = file.string();
    }
    return objects;
  }
  for (const std::string& name : SampledNamesIn(entry.name)) {
    ObjectSpec& object = objects.emplace_back(entry);
    object.name = name;
  }
  return objects;
}

}  // namespace

void ExpandObjects(ScenarioSpec& spec) {
  std::vector<ObjectSpec> objects;
  KeyPlaces places;
  std::set<std::string> names;
  for (size_t i = 0; i < spec.objects.size(); ++i) {
    const std::string prefix = fmt::format("objects.{}.", i);
    const std::string key = prefix + (HasPattern(spec.objects[i].mesh) ? "mesh" : "name");
    WithSettingsKey(spec, key, [&] {
      for (const ObjectSpec& object : ObjectsOf(spec.objects[i], spec.folder)) {
        CheckInput(
            names.insert(object.name).second,
            fmt::format("gives the object '{}' twice; use another name or a narrower pattern",
                        object.name));
        // Errors about an object name the place of its entry.
        for (auto place = spec.places.lower_bound(prefix);
             place != spec.places.end() && place->first.starts_with(prefix); ++place) {
          const std::string field = place->first.substr(prefix.size());
          places[fmt::format("objects.{}.{}", objects.size(), field)] = place->second;
        }
        objects.push_back(object);
      }
    });
  }
  for (const auto& [key, place] : spec.places) {
    if (!key.starts_with("objects.")) places[key] = place;
  }
  spec.objects = std::move(objects);
  spec.places = std::move(places);
}

std::vector<int> CountsInBin(const std::vector<ObjectSpec>& objects, int draw, uint64_t seed,
                             BinIndex bin_index) {
  std::vector<int> counts;
  std::vector<size_t> instances;  // the object of each wanted instance
  for (size_t i = 0; i < objects.size(); ++i) {
    const bool is_drawn = draw > 0 && !objects[i].distractor;
    counts.push_back(is_drawn ? 0 : objects[i].count);
    if (is_drawn) instances.insert(instances.end(), objects[i].count, i);
  }
  CheckInput(draw <= static_cast<int>(instances.size()),
             fmt::format("draw = {}: the objects have only {} instances; lower it", draw,
                         instances.size()));
  Rng rng = Rng::Derive(seed, bin_index, "objects");
  for (int k = 0; k < draw; ++k) {
    const int left = static_cast<int>(instances.size()) - k;
    std::swap(instances[k], instances[k + rng.Index(left)]);
    ++counts[instances[k]];
  }
  return counts;
}

}  // namespace pickbed::scenes
