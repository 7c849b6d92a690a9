#pragma once

// Target images of a split, and the objects to be found in them.

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "eval/bop/read_dataset.h"

namespace pickbed::eval {

struct ImageTargets {
  bool localised = false;     // BOP19 has targets here
  bool detected = false;      // BOP24 lists this image
  std::map<int, int> counts;  // BOP19: obj_id -> number of instances to be found
};

// An image that the targets files list.
struct ListedImage {
  int scene_id = 0, image_id = 0;
  auto operator<=>(const ListedImage&) const = default;
};

struct SplitTargets {
  std::map<int, std::map<int, ImageTargets>> scenes;  // scene -> image
  // All images in the order of the detection targets: scenes by their first target, then the images
  // of each scene. Estimates with equal scores are ranked in this order, as in the BOP toolkit.
  std::vector<ListedImage> order;
  std::vector<std::string> notes;  // what replaces targets files that are absent
};

// Reads the targets from SPLIT_targets_bop19.json and _bop24.json. Without the first file, every
// instance that is at least 10 % visible is a target, as BOP chose its targets. So are they in an
// image that it lists without obj_id. Without the second file, the first view of the sensor in
// each target of SPLIT_targets_multiview_bop25.json is a target or, without this file, every image.
// `sensor`: see ReadSceneTruth(). Throws InputError if the split has no scene, or for a broken
// file.
SplitTargets TargetsOf(const std::filesystem::path& root, const std::string& split,
                       const std::string& sensor = "");

}  // namespace pickbed::eval
