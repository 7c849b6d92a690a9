#pragma once

// The region of interest of an image: poses are only searched and reported in it.

#include <Eigen/Core>
#include <string>

#include "scenes/base/settings.h"

namespace pickbed::scenes {

// One of: nothing, a box, a mask image, or the automatic working volume.
struct RegionSpec {
  std::string frame = "world";                      // of the box: world | camera
  Eigen::Vector3d min_m = Eigen::Vector3d::Zero();  // corners of the box; equal = no box
  Eigen::Vector3d max_m = Eigen::Vector3d::Zero();
  std::string mask;        // image file, pixels over 0 are in the region; empty = no mask
  bool automatic = false;  // depth range in which the largest object has a useful size

  bool empty() const { return mask.empty() && !automatic && !has_box(); }
  bool has_box() const { return min_m != max_m; }
  void Visit(SettingsVisitor& v);
  // Throws InputError that begins with `key` if more than one kind is given, or an empty box.
  void Validate(const std::string& key) const;
};

// Parses "auto", "world:X,Y,Z,X,Y,Z" or "camera:X,Y,Z,X,Y,Z" (two corners, m) or the name of a mask
// image. Throws InputError with the text and the allowed forms.
RegionSpec ParseRegion(const std::string& text);

}  // namespace pickbed::scenes
