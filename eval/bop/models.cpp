#include "eval/bop/models.h"

#include <fmt/format.h>

#include <memory>
#include <utility>

#include "eval/bop/dataset_card.h"
#include "eval/bop/layout.h"
#include "scenes/base/error.h"

namespace pickbed::eval {

DatasetObjects LoadDatasetObjects(const std::filesystem::path& root, const std::set<int>& wanted,
                                  const std::map<int, DatasetModelInfo>& models) {
  const std::filesystem::path folder = root / "models";
  const std::map<int, CardObject> known_objects = ObjectsOfCard(root);
  DatasetObjects dataset;
  for (const int id : wanted) {
    const auto info = models.find(id);
    CheckInput(info != models.end(), fmt::format("{}: has no object {}, which is a target",
                                                 (folder / kModelsInfoFile).string(), id));
    const auto known = known_objects.find(id);
    const std::string name = known != known_objects.end() ? known->second.name : ModelName(id);
    auto model = std::make_shared<ObjectModel>(*LoadDatasetModel(folder, id, info->second, name));
    if (known != known_objects.end()) model->mesh_hash = known->second.mesh_hash;
    dataset.objects.push_back(std::move(model));
    dataset.ids.push_back(id);
  }
  return dataset;
}

DatasetObjects LoadDatasetObjects(const std::filesystem::path& root) {
  const std::map<int, DatasetModelInfo> models = ReadModelsInfo(root / "models", ThrowFault);
  CheckInput(!models.empty(),
             (root / "models" / kModelsInfoFile).string() + ": names no object to learn");
  std::set<int> all;
  for (const auto& [id, info] : models) all.insert(id);
  return LoadDatasetObjects(root, all, models);
}

}  // namespace pickbed::eval
