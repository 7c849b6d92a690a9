#pragma once

// File and folder names of a BOP data set in the "BOP-scenewise" layout, as defined in the BOP
// toolkit's docs/bop_datasets_format.md.

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "eval/layer.h"

namespace pickbed::eval::bop {

std::string SceneFolderName(int scene_id);                        // 000001
std::string ImageFileName(int image_id);                          // 000001.png
std::string MaskFileName(int image_id, int position);             // 000001_000000.png
std::string ModelName(int object_id);                             // obj_000001
std::string ModelFileName(int object_id);                         // obj_000001.ply
std::string TargetsFileName(const std::string& split, int year);  // test_targets_bop19.json

// Converts a name that consists only of digits to its number; nullopt for any other name.
std::optional<int> ParseId(const std::string& name);

// Returns the split folders of `root`, sorted: train*, val* and test*, for example train_pbr.
std::vector<std::string> SplitsOf(const std::filesystem::path& root);
// Returns the scene ids of a split, ascending.
std::vector<int> ScenesOf(const std::filesystem::path& root, const std::string& split);

// Returns the folder of the models for error computation: models_eval if it exists, else models.
std::filesystem::path EvalModelsFolder(const std::filesystem::path& root);

// Find the image files of a scene folder. Colour is in rgb or gray, as PNG, JPEG or TIFF. Depth is
// a PNG or TIFF. They return nullopt if no such file exists.
std::optional<std::filesystem::path> ColorFile(const std::filesystem::path& scene, int image_id);
std::optional<std::filesystem::path> DepthFile(const std::filesystem::path& scene, int image_id);

}  // namespace pickbed::eval::bop
