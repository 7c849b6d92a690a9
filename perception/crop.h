#pragma once

// Whole-object crops: what Wohlhart and Lepetit (CVPR 2015) and HOG see of a part.
//
// A crop is a square of fixed metric side around the part's centre, parallel to the image, seen at
// 64 x 64 pixels: nearest neighbours of the frame. Depth is stored relative to the centre's over
// the side, clipped to [-1, 1], as round(32767 v); where there is no reading it is +1 (far).

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <vector>

#include "scenes/rgbd_frame.h"

namespace pickbed {

inline constexpr int kCropPixels = 64;  // side, px
inline constexpr int kCropArea = kCropPixels * kCropPixels;
inline constexpr double kCropDepthUnit = 32767;  // stored depth of a whole side

// Where a crop is cut.
struct CropSpot {
  Eigen::Vector3d center_C = Eigen::Vector3d::UnitZ();  // of the part, m
  double side_m = 0;
};

struct CropSet {
  std::vector<int16_t> depth;   // count x 64 x 64
  std::vector<Rgb8> color;      // the same, black where the frame has no colour
  std::vector<uint8_t> masks;   // the same, 1 = the part itself; empty where nobody knows
  std::vector<CropSpot> spots;  // of each
  size_t size() const { return spots.size(); }
  std::span<const int16_t> depth_of(size_t i) const {
    return {depth.data() + i * kCropArea, static_cast<size_t>(kCropArea)};
  }
  std::span<const Rgb8> color_of(size_t i) const {
    return {color.data() + i * kCropArea, static_cast<size_t>(kCropArea)};
  }
};

// `ids`: where the instance is, which gets a mask; null = no mask. Throws InputError for a centre
// behind the camera or a side that is not positive.
void AppendCrop(const RgbdFrame& frame, const CropSpot& spot, const Image<uint16_t>* ids,
                CropSet& crops);

// Appends row i of `from`; masks only where it has some.
void AppendRow(const CropSet& from, size_t i, CropSet& to);

}  // namespace pickbed
