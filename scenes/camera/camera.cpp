#include "scenes/camera/camera.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <vector>

#include "scenes/base/error.h"

namespace pickbed::scenes {

// The whole view is in one pixel. The constructor permits less, because windows are scaled.
constexpr double kMinFocal_px = 1e-3;

std::string CameraIntrinsics::FaultsOf(int width, int height, double fx, double fy, double cx,
                                       double cy) {
  std::vector<std::string> faults;
  const auto require = [&](bool ok, const char* name, auto value, const std::string& allowed) {
    if (!ok) faults.push_back(fmt::format("{} = {}: must be {}", name, value, allowed));
  };
  const std::string size = fmt::format("from 1 to {} px", kMaxSize_px);
  const std::string focal = fmt::format("from {:g} to {:g} px", kMinFocal_px, kMaxLength_px);
  const std::string position = fmt::format("from {:g} to {:g} px", -kMaxLength_px, kMaxLength_px);
  require(IsSize(width), "width", width, size);
  require(IsSize(height), "height", height, size);
  require(IsFocal(fx) && fx >= kMinFocal_px, "fx", fx, focal);
  require(IsFocal(fy) && fy >= kMinFocal_px, "fy", fy, focal);
  require(IsPosition(cx), "cx", cx, position);
  require(IsPosition(cy), "cy", cy, position);
  return fmt::format("{}", fmt::join(faults, "; "));
}

void CameraIntrinsics::ThrowFaults() const {
  throw InputError("camera intrinsics: " + FaultsOf(width_, height_, fx_, fy_, cx_, cy_));
}

}  // namespace pickbed::scenes
