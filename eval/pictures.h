#pragma once

// The pictures of one pick: pick_00_color.png, _depth.png, _overlay.png and _after.png.

#include <filesystem>

#include "eval/report/draw.h"

namespace pickbed {

class PickPictures {
 public:
  // Writes nothing when `folder` is empty. Throws InputError when it cannot be made.
  PickPictures(const std::filesystem::path& folder, int pick);

  bool wanted() const { return !folder_.empty(); }
  void Write(const OverlayInput& input) const;      // colour, depth and overlay
  void WriteAfter(const Image<Rgb8>& color) const;  // the bin when the pick is over

 private:
  std::filesystem::path PathOf(const char* what) const;

  std::filesystem::path folder_;
  int pick_;
};

}  // namespace pickbed
