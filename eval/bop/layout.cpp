#include "eval/bop/layout.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>

namespace pickbed::eval::bop {
namespace {

namespace fs = std::filesystem;

std::optional<fs::path> FirstOf(const fs::path& scene, std::initializer_list<const char*> folders,
                                std::initializer_list<const char*> endings, int image_id) {
  std::error_code error;
  for (const char* folder : folders) {
    for (const char* ending : endings) {
      const fs::path path = scene / folder / fmt::format("{:06}.{}", image_id, ending);
      if (fs::is_regular_file(path, error)) return path;
    }
  }
  return std::nullopt;
}

}  // namespace

std::string SceneFolderName(int scene_id) { return fmt::format("{:06}", scene_id); }
std::string ImageFileName(int image_id) { return fmt::format("{:06}.png", image_id); }
std::string MaskFileName(int image_id, int position) {
  return fmt::format("{:06}_{:06}.png", image_id, position);
}
std::string ModelName(int object_id) { return fmt::format("obj_{:06}", object_id); }
std::string ModelFileName(int object_id) { return ModelName(object_id) + ".ply"; }
std::string TargetsFileName(const std::string& split, int year) {
  return fmt::format("{}_targets_bop{}.json", split, year);
}

std::optional<int> ParseId(const std::string& name) {
  int id = 0;
  const auto [end, error] = std::from_chars(name.data(), name.data() + name.size(), id);
  const bool digits = !name.empty() && name[0] != '-' && end == name.data() + name.size();
  return digits && error == std::errc() ? std::optional(id) : std::nullopt;
}

std::vector<std::string> SplitsOf(const fs::path& root) {
  constexpr std::array<std::string_view, 3> kKinds{"train", "val", "test"};
  std::vector<std::string> splits;
  std::error_code error;
  for (const fs::directory_entry& entry : fs::directory_iterator(root, error)) {
    const std::string name = entry.path().filename().string();
    const std::string kind = name.substr(0, name.find('_'));
    const bool known = std::find(kKinds.begin(), kKinds.end(), kind) != kKinds.end();
    if (entry.is_directory(error) && known) splits.push_back(name);
  }
  std::sort(splits.begin(), splits.end());
  return splits;
}

std::vector<int> ScenesOf(const fs::path& root, const std::string& split) {
  std::vector<int> scenes;
  std::error_code error;
  for (const fs::directory_entry& entry : fs::directory_iterator(root / split, error)) {
    const std::optional<int> id = ParseId(entry.path().filename().string());
    if (id && entry.is_directory(error)) scenes.push_back(*id);
  }
  std::sort(scenes.begin(), scenes.end());
  return scenes;
}

fs::path EvalModelsFolder(const fs::path& root) {
  std::error_code error;
  const fs::path reduced = root / "models_eval";
  return fs::is_directory(reduced, error) ? reduced : root / "models";
}

std::optional<fs::path> ColorFile(const fs::path& scene, int image_id) {
  return FirstOf(scene, {"rgb", "gray"}, {"png", "jpg", "tif"}, image_id);
}

std::optional<fs::path> DepthFile(const fs::path& scene, int image_id) {
  return FirstOf(scene, {"depth"}, {"png", "tif"}, image_id);
}

}  // namespace pickbed::eval::bop
