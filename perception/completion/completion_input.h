#pragma once

// Input of the completion network: a cube around the segment with a grid of channels, an image of
// the same region, and facts about single points of the cube.
//
// The cube has the axes of the camera. Its side is kSidePerExtent times the largest extent of the
// seen points. It is centered on them across, and begins a little before the nearest of them:
//
//      C ---> z     +--------+
//                   | (###   |  seen surface "(": front of the object
//                   | (###   |
//                   +--------+
//
// What is behind background pixels changes nothing, because the object is not there.

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "perception/completion/segment_view.h"
#include "perception/completion_networks/network_options.h"

namespace pickbed::perception {

inline constexpr float kSidePerExtent = 1.35f;
// The image covers this many sides at the depth of the cube's center. With 1 it would lack points
// in the near half of the cube.
inline constexpr float kSidePerImage = 1.15f;

// A cube with the axes of the camera.
struct CompletionCube {
  Eigen::Vector3f origin_C = Eigen::Vector3f::Zero();  // corner with the smallest coordinates, m
  float side_m = 0;
};

enum class PixelClass : uint8_t {
  kNoData,       // no reading, or outside the image
  kSegment,      // shows the object
  kBackground,   // shows something behind the object
  kBesideOther,  // background next to a pixel of another class
  kOccluder      // shows something in front of the object
};

// A segment view prepared for completion. All depths are along camera z.
class CompletionInput {
 public:
  // Throws InputError as CheckSegmentView() does, and for a segment without extent.
  explicit CompletionInput(const SegmentView& view);

  const CompletionCube& cube() const { return cube_; }

  // Returns kInputChannels x kInputCells^3 values in 1/127, x fastest, for the centers of the
  // cells:
  //   0 projective signed distance to the seen surface over 3 cells, cut to -1 .. 1; positive
  //     before the surface and where the cell is empty; 0 = not known
  //   1 the cell contains the seen surface
  //   2 the cell is known to be empty
  //   3 no data: 1 = behind an occluder, 0.5 = no reading
  std::vector<int8_t> Channels() const;

  // Returns kImageChannels x kImagePixels^2 values, x fastest, for the rays through a square grid
  // at the depth of the cube's center. Rays that pass the cube may show nothing.
  //   0 depth of the object or the occluder: -1 at the near side of the cube, 1 at the far side,
  //     cut to -2 .. 2; 0 for other pixels
  //   1-3 the pixel shows the object, the background, an occluder
  //   4 depth of the floor as in 0, if it is known
  std::vector<float> ImageChannels() const;

  // Returns the position of a point in C in the image: -1 .. 1 within it, from left to right and
  // from top to bottom.
  Eigen::Vector2f ImagePlace(const Eigen::Vector3f& p_C) const;

  // Returns facts about a point in C:
  //   0-2 distance to the seen surface along z in units of 1/48, 1/12 and 1 of the side, cut to
  //       -1 .. 1; positive before it; 0 where the pixel does not show the object
  //   3-6 the pixel shows the object, the background, an occluder, nothing
  //   7-9 the floor is known, the point is below it, its height in units of 1/4 of the side
  std::array<float, kPointFacts> Facts(const Eigen::Vector3f& p_C) const;

  // Returns true if the object cannot be at a point in C: before the seen surface or an occluder,
  // in front of the background, below the floor. The margin for noise is one cell along z, and one
  // pixel across.
  bool IsKnownEmpty(const Eigen::Vector3f& p_C) const;

  // Returns the class and the depth (m, 0 = none) of the pixel that shows a point in C.
  PixelClass ClassAt(const Eigen::Vector3f& p_C, float& depth_m) const;

 private:
  void FindCube(const SegmentView& view, const Image<uint8_t>& occluders);
  void CopyWindow(const SegmentView& view, const Image<uint8_t>& occluders);

  CompletionCube cube_;
  float fx_ = 1, fy_ = 1, cx_ = 0, cy_ = 0;  // of the window
  Image<float> depth_m_;                     // of the window around the cube
  Image<PixelClass> classes_;
  std::optional<FloorPlane> floor_;
};

// Number of rotations and reflections of the cube about the z axis. Turn t: bit 0 reflects x, bit 1
// reflects y, then bit 2 swaps x and y. A turned view is a valid view too, of a turned object from
// a turned camera.
inline constexpr int kCubeTurns = 8;
// Writes the channels of a turned cube to `turned`, which has the same number of values.
void TurnChannels(std::span<const int8_t> channels, int turn, int8_t* turned);
// Same for the channels of an image.
void TurnImage(std::span<const float> channels, int turn, float* turned);
// Turns the positions of a query (kQueryValues) in the cube and in the image.
void TurnPlaces(int turn, float* query);

}  // namespace pickbed::perception
