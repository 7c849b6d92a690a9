#include "perception/candidates/search_regions.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace pickbed::perception {
namespace {

constexpr double kTilesPerRadius = 2;  // tiles are this much smaller than the radius of a region
// A region covers the tiles within this share of its radius, so neighbouring regions overlap: an
// instance on the border of one region is well inside another.
constexpr double kCoveredShare = 0.75;
constexpr double kHighQuantile = 0.9;  // robust against flying pixels

double MedianDepth_m(const OrganizedCloud& cloud) {
  std::vector<float> depths_m;
  depths_m.reserve(cloud.foreground_pixels.size());
  for (const int pixel : cloud.foreground_pixels) depths_m.push_back(cloud.points_C[pixel].z());
  const auto median = depths_m.begin() + depths_m.size() / 2;
  std::nth_element(depths_m.begin(), median, depths_m.end());
  return *median;
}

double QuantileOf(std::vector<float>& values, double share) {
  const auto at = values.begin() + static_cast<long>(share * (values.size() - 1));
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

}  // namespace

SearchRegions::SearchRegions(const OrganizedCloud& cloud, const Eigen::Vector3d& up_C,
                             double area_m2)
    : cloud_(cloud), area_m2_(area_m2) {
  if (cloud.foreground_pixels.empty()) return;
  const double radius_px =
      std::sqrt(area_m2 / std::numbers::pi) * cloud.intrinsics.fx() / MedianDepth_m(cloud);
  const int side_px = std::max(1, static_cast<int>(radius_px / kTilesPerRadius));
  const int columns = (cloud.intrinsics.width() + side_px - 1) / side_px;
  const int rows = (cloud.intrinsics.height() + side_px - 1) / side_px;
  std::vector<std::vector<float>> heights_m(static_cast<size_t>(columns) * rows);
  const Eigen::Vector3f up = up_C.cast<float>();
  for (const int pixel : cloud.foreground_pixels) {
    const Eigen::Vector2d at_px = PixelOf(pixel);
    const int column = static_cast<int>(at_px.x()) / side_px;
    const int row = static_cast<int>(at_px.y()) / side_px;
    heights_m[static_cast<size_t>(row) * columns + column].push_back(up.dot(cloud.points_C[pixel]));
  }
  for (size_t i = 0; i < heights_m.size(); ++i) {
    if (heights_m[i].empty()) continue;
    const Eigen::Vector2d cell(static_cast<double>(i % columns), static_cast<double>(i / columns));
    const Eigen::Vector2d center_px = side_px * (cell.array() + 0.5) - 0.5;
    const int pixels = static_cast<int>(heights_m[i].size());
    tiles_.push_back({center_px, QuantileOf(heights_m[i], kHighQuantile), pixels});
  }
  // Nearly empty tiles show edges and flying pixels. They come last.
  const int min_pixels = side_px * side_px / 4;
  std::stable_sort(tiles_.begin(), tiles_.end(), [&](const Tile& a, const Tile& b) {
    const bool full_a = a.pixels >= min_pixels, full_b = b.pixels >= min_pixels;
    return full_a != full_b ? full_a : a.height_m > b.height_m;
  });
}

Eigen::Vector2d SearchRegions::PixelOf(int index) const {
  const int width = cloud_.intrinsics.width();
  return {static_cast<double>(index % width), static_cast<double>(index / width)};
}

std::vector<int> SearchRegions::Next() {
  const auto seed =
      std::find_if(tiles_.begin(), tiles_.end(), [](const Tile& tile) { return !tile.covered; });
  if (seed == tiles_.end()) return {};
  // Area that is seen at each whole distance from the seed, px. Each pixel counts with the area
  // that it shows.
  std::vector<int> distance_px;
  distance_px.reserve(cloud_.foreground_pixels.size());
  std::vector<double> area_m2;
  const double pixel_m2 = 1 / (cloud_.intrinsics.fx() * cloud_.intrinsics.fy());
  for (const int pixel : cloud_.foreground_pixels) {
    const double z_m = cloud_.points_C[pixel].z();
    const size_t distance = static_cast<size_t>((PixelOf(pixel) - seed->center_px).norm());
    if (distance >= area_m2.size()) area_m2.resize(distance + 1);
    area_m2[distance] += z_m * z_m * pixel_m2;
    distance_px.push_back(static_cast<int>(distance));
  }
  int radius_px = 0;
  double sum_m2 = 0;
  while (radius_px < static_cast<int>(area_m2.size()) && sum_m2 < area_m2_) {
    sum_m2 += area_m2[radius_px++];
  }
  for (Tile& tile : tiles_) {
    tile.covered |= (tile.center_px - seed->center_px).norm() <= kCoveredShare * radius_px;
  }
  seed->covered = true;
  std::vector<int> region;
  for (size_t i = 0; i < distance_px.size(); ++i) {
    if (distance_px[i] < radius_px) region.push_back(cloud_.foreground_pixels[i]);
  }
  return region;
}

}  // namespace pickbed::perception
