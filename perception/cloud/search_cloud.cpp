#include "perception/cloud/search_cloud.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "scenes/base/parallel.h"

namespace pickbed::perception {
namespace {

// Mean of the readings near their median, so that a block on an edge does not get a depth between
// the two surfaces.
float DepthOf(std::vector<float>& readings, size_t block) {
  constexpr float kBandAt1m = 0.004f;
  if (2 * readings.size() < block) return 0;
  const auto median_at = readings.begin() + (readings.size() - 1) / 2;
  std::nth_element(readings.begin(), median_at, readings.end());
  const float median = *median_at;
  float sum = 0;
  int count = 0;
  for (const float z : readings) {
    if (std::abs(z - median) > kBandAt1m * median * median) continue;
    sum += z;
    ++count;
  }
  return sum / static_cast<float>(count);
}

Image<uint8_t> BinnedRegion(const Image<uint8_t>& region, int factor) {
  Image<uint8_t> binned(region.width() / factor, region.height() / factor);
  for (int y = 0; y < binned.height(); ++y) {
    for (int x = 0; x < binned.width(); ++x) {
      binned(x, y) = region(x * factor + factor / 2, y * factor + factor / 2);
    }
  }
  return binned;
}

}  // namespace

int BinningFor(const CameraIntrinsics& intrinsics, double distance_m, double smallest_diameter_m) {
  const double diameter_px =
      smallest_diameter_m * std::min(intrinsics.fx(), intrinsics.fy()) / distance_m;
  const double factor = diameter_px / kSearchDiameter_px;
  if (!(factor > 1)) return 1;  // also if it is not a number
  return static_cast<int>(
      std::min<double>(factor, std::min(intrinsics.width(), intrinsics.height())));
}

double SmallestDiameter_m(const ObjectSet& objects) {
  double smallest_m = std::numeric_limits<double>::infinity();
  for (const auto& object : objects) smallest_m = std::min(smallest_m, object->diameter_m);
  return smallest_m;
}

RgbdFrame BinnedFrame(const RgbdFrame& frame, int factor, int threads) {
  const CameraIntrinsics& k = frame.intrinsics;
  const int width = k.width() / factor, height = k.height() / factor;
  // Pixel centers are integers, so the center of the first block is (factor - 1) / 2.
  const double offset = 0.5 * (factor - 1);
  RgbdFrame binned;
  binned.intrinsics = {width,
                       height,
                       k.fx() / factor,
                       k.fy() / factor,
                       (k.cx() - offset) / factor,
                       (k.cy() - offset) / factor};
  binned.depth_m = Image<float>(width, height);
  const bool has_color = !frame.color.empty();
  if (has_color) binned.color = Image<Rgb8>(width, height);
  const int block = factor * factor;
  const auto bin_row = [&](int y, std::vector<float>& readings) {
    for (int x = 0; x < width; ++x) {
      readings.clear();
      int64_t r = 0, g = 0, b = 0;
      for (int i = 0; i < block; ++i) {
        const int u = x * factor + i % factor, v = y * factor + i / factor;
        const float z = frame.depth_m(u, v);
        if (z > 0 && std::isfinite(z)) readings.push_back(z);
        if (!has_color) continue;
        const Rgb8& color = frame.color(u, v);
        r += color.r;
        g += color.g;
        b += color.b;
      }
      binned.depth_m(x, y) = DepthOf(readings, block);
      if (has_color) {
        const auto mean = [&](int64_t sum) {
          return static_cast<uint8_t>((sum + block / 2) / block);
        };
        binned.color(x, y) = {mean(r), mean(g), mean(b)};
      }
    }
  };
  ForRanges(height, threads, [&](int begin, int end) {
    std::vector<float> readings;
    readings.reserve(block);
    for (int y = begin; y < end; ++y) bin_row(y, readings);
  });
  return binned;
}

OrganizedCloud SearchCloud(const RgbdFrame& frame, const std::optional<KnownBackground>& background,
                           int factor, const Image<uint8_t>* region, bool fits_background,
                           int threads) {
  CloudOptions options;
  if (!fits_background) options.min_plane_share = 1;
  const CameraIntrinsics& k = frame.intrinsics;
  // BuildCloud() refuses images of other sizes than the intrinsics.
  const bool valid = frame.depth_m.width() == k.width() && frame.depth_m.height() == k.height() &&
                     (frame.color.empty() ||
                      (frame.color.width() == k.width() && frame.color.height() == k.height()));
  if (factor == 1 || !valid) {
    return BuildCloud(frame, background, options, region, threads);
  }
  std::optional<Image<uint8_t>> binned_region;
  if (region != nullptr) binned_region = BinnedRegion(*region, factor);
  RgbdFrame binned = BinnedFrame(frame, factor, threads);
  Image<Rgb8> color = std::exchange(binned.color, {});  // edges are found in the whole image
  OrganizedCloud cloud =
      BuildCloud(binned, background, options, binned_region ? &*binned_region : nullptr, threads);
  cloud.color = std::move(color);
  cloud.edges = FindColorEdges(k, frame.color, threads);
  return cloud;
}

}  // namespace pickbed::perception
