#pragma once

// Estimated poses in one image of a user, as JSON and CSV files.

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "eval/layer.h"
#include "eval/metrics/result_columns.h"
#include "perception/pose_hypothesis.h"
#include "scenes/camera/camera.h"

namespace pickbed::eval {

inline constexpr char kPosesJsonFile[] = "poses.json";
inline constexpr char kPosesCsvFile[] = "poses.csv";
inline constexpr char kOverlayFile[] = "overlay.png";

// Facts about an image for its JSON file.
struct ImageFacts {
  std::string image;  // files, as given
  std::string depth;
  CameraIntrinsics intrinsics;
  double depth_scale_mm = 1;
  std::string estimator;              // name and mode
  std::string region;                 // of interest, as given; empty = the whole image
  std::vector<std::string> warnings;  // of CheckFrame() and of the estimator
  double min_score = 0;               // of a reported pose
  std::string model = {};             // of the estimator, as given
  std::string refiner = {};
  uint64_t seed = 0;
};

// Poses in the camera frame: highest score first, rotation matrix by rows and translation in m.
std::string ImagePosesJson(const ImageFacts& facts, std::span<const PoseHypothesis> poses,
                           const ObjectSet& objects);
ResultColumns ImagePosesKeys();

// The same poses, one line each.
std::string ImagePosesCsv(std::span<const PoseHypothesis> poses, const ObjectSet& objects);
ResultColumns ImagePosesColumns();

}  // namespace pickbed::eval
