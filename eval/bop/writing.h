#pragma once

// The files of a BOP data set. Metres come in, BOP's millimetres go out. The same values give the
// same bytes. All throw InputError when a file cannot be written.

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "eval/bop/dataset.h"
#include "eval/bop/instance_masks.h"

namespace pickbed::bop {

inline constexpr double kDepthScale_mm = 0.1;  // of one unit of the depth images written here

// models/: obj_XXXXXX.ply (ASCII, with normals, colours or a texture) and models_info.json. Object
// ids are index + 1. A mesh with flat faces has each face's corners to itself, with its normal.
void WriteModels(const std::filesystem::path& folder, const ObjectSet& objects);

void WriteDatasetCamera(const std::filesystem::path& file, const CameraIntrinsics& camera);

// An image with its truth.
struct LabelledImage {
  ImageTruth truth;  // infos are taken from the masks
  Image<Rgb8> color;
  Image<uint16_t> depth;  // in units of kDepthScale_mm
  std::vector<InstanceMasks> masks;
};

// A scene folder, file by file. The JSON files are written by Finish().
class SceneWriter {
 public:
  // Makes the folder, which must not exist.
  explicit SceneWriter(std::filesystem::path folder, int objects);
  void Add(const LabelledImage& image);
  void Finish();

 private:
  void AddCoco(const LabelledImage& image);

  std::filesystem::path folder_;
  int objects_;
  int annotations_ = 0;
  std::vector<std::pair<int, std::string>> cameras_, truths_, infos_;  // by image, as JSON
  std::vector<std::string> coco_images_, coco_annotations_;
};

// test_targets_bop19.json: each object of which an instance is at least 10 % visible, with the
// number of those; _bop24.json: each image. From the scenes on disk.
void WriteTargets(const std::filesystem::path& root, const std::string& split);

// Lengths of runs of unset and set pixels in turn, column by column, the first of unset ones:
// COCO's uncompressed run-length encoding.
std::vector<int> RunLengths(const Image<uint8_t>& mask);

}  // namespace pickbed::bop
