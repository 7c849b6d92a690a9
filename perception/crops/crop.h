#pragma once

// Whole-object crops, the input of Wohlhart and Lepetit (CVPR 2015) and of HOG.
//
// A crop is a square with a fixed metric side around the center of the object, parallel to the
// image plane. It is resampled to 64 x 64 pixels by nearest neighbour. Depth is relative to the
// depth of the center, divided by the side, clipped to [-1, 1] and stored as round(32767 v). Pixels
// without a reading are +1 (far).

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <vector>

#include "perception/layer.h"
#include "scenes/camera/rgbd_frame.h"

namespace pickbed::perception {

inline constexpr int kCropPixels = 64;  // side, px
inline constexpr int kCropArea = kCropPixels * kCropPixels;
inline constexpr double kCropDepthUnit = 32767;  // stored value of a relative depth of one side

// Position and size of a crop.
struct CropSpot {
  Eigen::Vector3d center_C = Eigen::Vector3d::UnitZ();  // center of the object, m
  double side_m = 0;
};

// Crops stored one after the other, row by row.
struct CropSet {
  std::vector<int16_t> depth;   // count x 64 x 64
  std::vector<Rgb8> color;      // same size; black if the frame has no color
  std::vector<uint8_t> masks;   // same size, 1 = the object; empty if the mask is unknown
  std::vector<CropSpot> spots;  // one per crop
  size_t size() const { return spots.size(); }
  std::span<const int16_t> depth_of(size_t i) const {
    return {depth.data() + i * kCropArea, static_cast<size_t>(kCropArea)};
  }
  std::span<const Rgb8> color_of(size_t i) const {
    return {color.data() + i * kCropArea, static_cast<size_t>(kCropArea)};
  }
};

// Cuts one crop from the frame and appends it. Pixels with a nonzero id in `ids` form the mask;
// null = no mask. Throws InputError if the center is behind the camera or the side is not positive.
void AppendCrop(const RgbdFrame& frame, const CropSpot& spot, const Image<uint16_t>* ids,
                CropSet& crops);

// Appends crop i of `from`, with its mask if there is one.
void AppendRow(const CropSet& from, size_t i, CropSet& to);

}  // namespace pickbed::perception
