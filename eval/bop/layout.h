#pragma once

// Names of the files of a BOP data set, scene by scene ("BOP-scenewise"), as the BOP toolkit's
// docs/bop_datasets_format.md states them.

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace pickbed::bop {

std::string SceneFolderName(int scene_id);                        // 000001
std::string ImageFileName(int image_id);                          // 000001.png
std::string MaskFileName(int image_id, int instance);             // 000001_000000.png
std::string ModelName(int object_id);                             // obj_000001
std::string ModelFileName(int object_id);                         // obj_000001.ply
std::string TargetsFileName(const std::string& split, int year);  // test_targets_bop19.json

// The number that a name of digits alone stands for; nothing for any other name.
std::optional<int> ParseId(const std::string& name);

// Folders of `root` that hold images: test, train_pbr, val_primesense... Sorted.
std::vector<std::string> SplitsOf(const std::filesystem::path& root);
// Scenes of a split, ascending.
std::vector<int> ScenesOf(const std::filesystem::path& root, const std::string& split);

// The folder of the models that errors are computed with: models_eval where there is one, else
// models.
std::filesystem::path EvalModelsFolder(const std::filesystem::path& root);

// Colour is in rgb or gray, as PNG, JPEG or TIFF; depth is a PNG or TIFF. Nothing where no such
// file exists.
std::optional<std::filesystem::path> ColorFile(const std::filesystem::path& scene, int image_id);
std::optional<std::filesystem::path> DepthFile(const std::filesystem::path& scene, int image_id);

}  // namespace pickbed::bop
