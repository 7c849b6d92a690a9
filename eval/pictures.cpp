#include "eval/pictures.h"

#include <fmt/format.h>

#include "scenes/check.h"
#include "scenes/image_io.h"

namespace pickbed {

PickPictures::PickPictures(const std::filesystem::path& folder, int pick)
    : folder_(folder), pick_(pick) {
  if (folder_.empty()) return;
  std::error_code error;
  std::filesystem::create_directories(folder_, error);
  CheckInput(!error,
             fmt::format("cannot make the folder {}: {}", folder_.string(), error.message()));
}

std::filesystem::path PickPictures::PathOf(const char* what) const {
  return folder_ / fmt::format("pick_{:02}_{}.png", pick_, what);
}

void PickPictures::Write(const OverlayInput& input) const {
  if (folder_.empty()) return;
  WritePng(PathOf("color"), input.frame.color);
  WritePng(PathOf("depth"), ColorizeDepth(input.frame.depth_m));
  WritePng(PathOf("overlay"), DrawOverlay(input));
}

void PickPictures::WriteAfter(const Image<Rgb8>& color) const {
  if (!folder_.empty()) WritePng(PathOf("after"), color);
}

}  // namespace pickbed
