#include "eval/bop/models.h"

#include <fmt/format.h>

#include <memory>
#include <utility>

#include "eval/bop/dataset_card.h"
#include "eval/bop/layout.h"
#include "scenes/base/error.h"

namespace pickbed::eval::bop {

DatasetParts LoadParts(const std::filesystem::path& root, const std::set<int>& wanted,
                       const std::map<int, ModelInfo>& models) {
  const std::filesystem::path folder = root / "models";
  const std::map<int, CardPart> known_parts = PartsOfCard(root);
  DatasetParts parts;
  for (const int id : wanted) {
    const auto info = models.find(id);
    CheckInput(info != models.end(), fmt::format("{}: has no object {}, which is a target",
                                                 (folder / "models_info.json").string(), id));
    const auto known = known_parts.find(id);
    const std::string name = known != known_parts.end() ? known->second.name : ModelName(id);
    auto model = std::make_shared<ObjectModel>(*LoadModel(folder, id, info->second, name));
    if (known != known_parts.end()) model->mesh_hash = known->second.mesh_hash;
    parts.objects.push_back(std::move(model));
    parts.ids.push_back(id);
  }
  return parts;
}

DatasetParts LoadParts(const std::filesystem::path& root) {
  const std::map<int, ModelInfo> models = ReadModelsInfo(root / "models", ThrowFault);
  CheckInput(!models.empty(),
             (root / "models" / "models_info.json").string() + ": names no object to learn");
  std::set<int> all;
  for (const auto& [id, info] : models) all.insert(id);
  return LoadParts(root, all, models);
}

}  // namespace pickbed::eval::bop
