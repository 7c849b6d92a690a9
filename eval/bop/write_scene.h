#pragma once

// Writers for the files of a BOP data set. Input is in metres, the files are in BOP's millimetres.
// The same values give the same bytes. All functions throw InputError if a file cannot be written.

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "eval/bop/instance_masks.h"
#include "eval/bop/read_dataset.h"

namespace pickbed::eval {

inline constexpr double kDepthScale_mm = 0.1;  // mm per unit of the depth images written here

// Writes obj_XXXXXX.ply (ASCII, with normals, and colors or a texture) and models_info.json.
// Object ids are index + 1. In a mesh with flat faces, faces do not share corners, and each corner
// has the normal of its face.
void WriteModels(const std::filesystem::path& folder, const ObjectSet& objects);

// Writes camera.json, with the depth scale kDepthScale_mm.
void WriteDatasetCamera(const std::filesystem::path& file, const CameraIntrinsics& camera);

// An image with its ground truth.
struct LabelledImage {
  ImageTruth truth;  // its infos are ignored; `masks` has them
  Image<Rgb8> color;
  Image<uint16_t> depth;  // in units of kDepthScale_mm
  std::vector<InstanceMasks> masks;
};

// Writes a scene folder. Add() writes the image files, Finish() the JSON files.
class SceneWriter {
 public:
  // Creates the folder, which must not exist. `objects` is the number of objects of the data set.
  explicit SceneWriter(std::filesystem::path folder, int objects);
  void Add(const LabelledImage& image);
  void Finish();

 private:
  void AddCoco(const LabelledImage& image);

  std::filesystem::path folder_;
  int objects_;
  int annotations_ = 0;
  std::vector<std::pair<int, std::string>> cameras_, truths_, infos_;  // image id, JSON
  std::vector<std::string> coco_images_, coco_annotations_;
};

// Writes the targets files of a split from the scenes on disk. SPLIT_targets_bop19.json lists each
// object in an image with the number of its instances that are at least 10 % visible, if any.
// SPLIT_targets_bop24.json lists each image.
void WriteTargets(const std::filesystem::path& root, const std::string& split);

// Returns COCO's uncompressed run-length encoding: lengths of alternating runs of unset and set
// pixels, column by column. The first run is of unset pixels.
std::vector<int> RunLengths(const Image<uint8_t>& mask);

}  // namespace pickbed::eval
