#pragma once

// Regions of the foreground, the highest first. A cell that needs a few poses on top of a pile
// searches one region after the other and stops when it has enough.

#include <Eigen/Core>
#include <vector>

#include "perception/cloud/organized_cloud.h"

namespace pickbed::perception {

// Divides the foreground of a cloud into overlapping regions of equal visible area.
class SearchRegions {
 public:
  // - cloud: must outlive this object
  // - up_C: unit vector that points up, in the camera frame
  // - area_m2: area of a region as seen by the camera, m^2, positive
  SearchRegions(const OrganizedCloud& cloud, const Eigen::Vector3d& up_C, double area_m2);

  // Returns the foreground pixels of the next region, in the order of cloud.foreground_pixels:
  // those nearest to the highest part of the foreground that no earlier region covers. Returns an
  // empty list when the regions cover all of the foreground.
  std::vector<int> Next();

 private:
  // A square of pixels.
  struct Tile {
    Eigen::Vector2d center_px;
    double height_m = 0;  // a high quantile of the heights of its pixels, along up_C
    int pixels = 0;       // number of foreground pixels
    bool covered = false;
  };

  Eigen::Vector2d PixelOf(int index) const;

  const OrganizedCloud& cloud_;
  double area_m2_;
  std::vector<Tile> tiles_;  // the highest first
};

}  // namespace pickbed::perception
