#include "perception/cloud/organized_cloud.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cassert>
#include <cmath>

#include "perception/cloud/normals.h"
#include "scenes/base/error.h"
#include "scenes/base/finite_counts.h"
#include "scenes/base/parallel.h"
#include "scenes/camera/depth_points.h"

namespace pickbed::perception {
namespace {

void CheckArguments(const RgbdFrame& frame, const CloudOptions& o) {
  const CameraIntrinsics& k = frame.intrinsics;
  CheckInput(!frame.depth_m.empty(),
             "the frame has no depth image; give it one, because poses are found in depth");
  CheckInput(frame.depth_m.width() == k.width() && frame.depth_m.height() == k.height() &&
                 k.width() > 0 && k.height() > 0,
             fmt::format("depth image is {}x{} but the intrinsics are for {}x{}: give the frame "
                         "the intrinsics of its depth image",
                         frame.depth_m.width(), frame.depth_m.height(), k.width(), k.height()));
  CheckInput(frame.color.empty() ||
                 (frame.color.width() == k.width() && frame.color.height() == k.height()),
             fmt::format("color image is {}x{} and depth image {}x{}: give the frame color that "
                         "is registered to depth",
                         frame.color.width(), frame.color.height(), k.width(), k.height()));
  CheckSettings("CloudOptions", o);
  CheckInput(o.normal_window_px % 2 == 1,
             fmt::format("normal_window_px is {}: use an odd number in 3..15", o.normal_window_px));
}

template <typename Work>
void ForRows(const CameraIntrinsics& k, int threads, Work work) {
  ForRanges(k.height(), threads, [&](int begin, int end) {
    for (int y = begin; y < end; ++y) work(y);
  });
}

// Components of the viewing rays with z = 1.
std::vector<float> RaysX(const CameraIntrinsics& k) {
  std::vector<float> rays(k.width());
  for (int x = 0; x < k.width(); ++x) rays[x] = static_cast<float>((x - k.cx()) / k.fx());
  return rays;
}
float RayY(const CameraIntrinsics& k, int y) { return static_cast<float>((y - k.cy()) / k.fy()); }

// Whether a value of a depth image is a distance.
bool IsReading(float z) { return z > 0 && std::isfinite(z); }

std::vector<Eigen::Vector3f> SparsePoints(const CameraIntrinsics& k, const Image<float>& depth_m,
                                          const Image<uint8_t>* region) {
  constexpr int kColumns = 80;  // gives some thousands of points, enough to fit planes
  const int stride = std::max(1, k.width() / kColumns);
  std::vector<Eigen::Vector3f> points;
  ForEachDepthPoint(
      k, depth_m,
      [&](int u, int v, const Eigen::Vector3d& p_C) {
        if (region == nullptr || (*region)(u, v) != 0) points.push_back(p_C.cast<float>());
      },
      stride, /*first=*/stride / 2);
  return points;
}

// Whether a point is above the floor and between the inner walls. Above the rim the limit is the
// outer side of the walls, because objects may lean over them.
bool InsideBin(const Bin& bin, const Eigen::Vector3f& p_B, float margin_m) {
  const Eigen::Vector3f size = bin.inner_size_m.cast<float>();
  const bool above_rim = p_B.z() > size.z() + margin_m;
  const float inset = above_rim ? -static_cast<float>(bin.wall_m) : margin_m;
  return p_B.z() > margin_m && std::abs(p_B.x()) < 0.5f * size.x() - inset &&
         std::abs(p_B.y()) < 0.5f * size.y() - inset;
}

// Sets the pixels with depth for which keep(p_A, margin_m) is true.
template <typename Keep>
Image<uint8_t> MarkForeground(const CameraIntrinsics& k, const Image<float>& depth_m,
                              const Eigen::Isometry3f& X_AC, double margin_at_1m, int threads,
                              Keep keep) {
  Image<uint8_t> mask(k.width(), k.height());
  const Eigen::Matrix3f R = X_AC.linear();
  const Eigen::Vector3f t = X_AC.translation();
  const float margin = static_cast<float>(margin_at_1m);
  const std::vector<float> rays_x = RaysX(k);
  ForRows(k, threads, [&](int y) {
    const Eigen::Vector3f row = R.col(1) * RayY(k, y) + R.col(2);
    for (int x = 0; x < k.width(); ++x) {
      const float z = depth_m(x, y);
      if (!IsReading(z)) continue;
      const Eigen::Vector3f p = z * (R.col(0) * rays_x[x] + row) + t;
      mask(x, y) = keep(p, margin * z * z);
    }
  });
  return mask;
}

// Inner sides of the walls, then the floor. Empty for bins that are not boxes.
std::vector<BackgroundPlane> PlanesOf(const KnownBackground& background) {
  const Bin& bin = background.bin;
  std::vector<BackgroundPlane> planes;
  if (bin.shape != nullptr) return planes;
  const auto add = [&](const Eigen::Vector3d& normal_B, double offset_m) {
    const Eigen::Vector3f normal_C = (background.X_CB.linear() * normal_B).cast<float>();
    const auto origin_C = background.X_CB.translation().cast<float>();
    planes.push_back({normal_C, static_cast<float>(offset_m) + normal_C.dot(origin_C)});
  };
  for (int axis = 0; axis < 2 && bin.inner_size_m.z() > 0; ++axis) {
    for (const double side : {-1.0, 1.0}) {
      add(side * Eigen::Vector3d::Unit(axis), -0.5 * bin.inner_size_m[axis]);
    }
  }
  add(Eigen::Vector3d::UnitZ(), 0);
  return planes;
}

// Fills cloud.foreground, cloud.planes and cloud.wall_height_m.
void MarkBackground(const std::optional<KnownBackground>& background, const CloudOptions& options,
                    const Image<uint8_t>* region, int threads, OrganizedCloud& cloud) {
  const CameraIntrinsics& k = cloud.intrinsics;
  const double margin = options.background_margin_m * cloud.error_scale;
  if (background) {
    const Bin& bin = background->bin;
    cloud.background = BackgroundKind::kKnown;
    cloud.planes = PlanesOf(*background);
    cloud.wall_height_m = static_cast<float>(bin.inner_size_m.z());
    cloud.foreground =
        MarkForeground(k, cloud.depth_m, background->X_CB.inverse().cast<float>(), margin, threads,
                       [&](const Eigen::Vector3f& p_B, float m) { return InsideBin(bin, p_B, m); });
    return;
  }
  if (options.min_plane_share < 1) {
    cloud.planes = FitBackground(SparsePoints(k, cloud.depth_m, region),
                                 {.margin_m = margin, .min_plane_share = options.min_plane_share});
  }
  cloud.background = cloud.planes.empty() ? BackgroundKind::kNone : BackgroundKind::kFitted;
  cloud.foreground = MarkForeground(
      k, cloud.depth_m, Eigen::Isometry3f::Identity(), margin, threads,
      [&](const Eigen::Vector3f& p_C, float m) {
        return std::all_of(cloud.planes.begin(), cloud.planes.end(),
                           [&](const auto& plane) { return plane.SignedDistance(p_C) > m; });
      });
}

// Fills cloud.points_C and cloud.foreground_pixels. Removes points and normals that are not finite:
// a depth of 1e38 m has such points.
void FillPoints(OrganizedCloud& cloud, int threads) {
  const CameraIntrinsics& k = cloud.intrinsics;
  cloud.points_C.resize(cloud.depth_m.size());
  const std::vector<float> rays_x = RaysX(k);
  std::atomic<int> lost_points = 0, lost_normals = 0;
  ForRows(k, threads, [&](int y) {
    const float ray_y = RayY(k, y);
    const size_t first = static_cast<size_t>(y) * k.width();
    for (int x = 0; x < k.width(); ++x) {
      const float z = cloud.depth_m(x, y);
      Eigen::Vector3f& point_C = cloud.points_C[first + x];
      Eigen::Vector3f& normal_C = cloud.normals_C[first + x];
      point_C.setZero();
      if (z > 0) point_C = {z * rays_x[x], z * ray_y, z};
      if (!normal_C.allFinite()) {
        normal_C.setZero();
        ++lost_normals;
      }
      if (point_C.allFinite() && std::isfinite(z)) continue;
      point_C.setZero();
      normal_C.setZero();
      cloud.depth_m(x, y) = 0;
      cloud.foreground(x, y) = 0;
      ++lost_points;
    }
  });
  CountNotFinite(FiniteBoundary::kPoints, lost_points);
  CountNotFinite(FiniteBoundary::kNormals, lost_normals);
  const uint8_t* foreground = cloud.foreground.data();
  for (size_t pixel = 0; pixel < cloud.foreground.size(); ++pixel) {
    if (foreground[pixel] != 0) cloud.foreground_pixels.push_back(static_cast<int>(pixel));
  }
}

int CountNotFiniteReadings(const Image<float>& depth_m) {
  return static_cast<int>(std::count_if(depth_m.data(), depth_m.data() + depth_m.size(),
                                        [](float z) { return !std::isfinite(z); }));
}

[[maybe_unused]] bool IsFinite(const OrganizedCloud& cloud) {
  const auto is_finite = [](const Eigen::Vector3f& v) { return v.allFinite(); };
  return std::ranges::all_of(cloud.points_C, is_finite) &&
         std::ranges::all_of(cloud.normals_C, is_finite) &&
         CountNotFiniteReadings(cloud.depth_m) == 0;
}

}  // namespace

Image<float> FillSinglePixelHoles(const Image<float>& depth_m, int threads) {
  constexpr int kMinNeighbors = 6;  // fewer: an edge or a larger hole
  Image<float> filled = depth_m;
  const auto fill = [&](int x, int y) {
    filled(x, y) = 0;  // values that are not finite or negative also become holes
    std::array<float, 8> values{};
    int n = 0;
    for (int v = std::max(0, y - 1); v <= std::min(depth_m.height() - 1, y + 1); ++v) {
      for (int u = std::max(0, x - 1); u <= std::min(depth_m.width() - 1, x + 1); ++u) {
        if (IsReading(depth_m(u, v))) values[n++] = depth_m(u, v);
      }
    }
    if (n < kMinNeighbors) return;
    // The lower median is a value that occurs, never the mean across a step.
    std::nth_element(values.begin(), values.begin() + (n - 1) / 2, values.begin() + n);
    filled(x, y) = values[(n - 1) / 2];
  };
  ForRanges(depth_m.height(), threads, [&](int begin, int end) {
    for (int y = begin; y < end; ++y) {
      for (int x = 0; x < depth_m.width(); ++x) {
        if (!IsReading(depth_m(x, y))) fill(x, y);
      }
    }
  });
  return filled;
}

void CloudOptions::Visit(SettingsVisitor& v) {
  v.Real("background_margin_m", background_margin_m, {0, 1},
         "distance at which a pixel is on floor or walls, m, at 1 m");
  v.Integer("normal_window_px", normal_window_px, {3, 15}, "side of the plane-fit window, px, odd");
  v.Real("fit_band_m", fit_band_m, {1e-6, 1},
         "half width of the depth band of the plane fit, m, at 1 m");
  v.Real("min_plane_share", min_plane_share, {0, 1},
         "minimum share of all points on the table or floor; 1 = no background is removed");
}

OrganizedCloud BuildCloud(const RgbdFrame& frame, const std::optional<KnownBackground>& background,
                          const CloudOptions& options, const Image<uint8_t>* region, int threads) {
  CheckArguments(frame, options);
  CheckInput(region == nullptr || (region->width() == frame.depth_m.width() &&
                                   region->height() == frame.depth_m.height()),
             "the region of interest has another size than the depth image; give one of its size");
  CountNotFinite(FiniteBoundary::kDepth, CountNotFiniteReadings(frame.depth_m));
  OrganizedCloud cloud;
  cloud.intrinsics = frame.intrinsics;
  cloud.color = frame.color;
  cloud.edges = FindColorEdges(frame.intrinsics, frame.color, threads);
  cloud.depth_m = FillSinglePixelHoles(frame.depth_m, threads);
  cloud.depth_statistics = MeasureDepth(cloud.depth_m);
  cloud.error_scale = ErrorScale(cloud.depth_statistics);
  MarkBackground(background, options, region, threads, cloud);
  if (region != nullptr) {
    for (size_t i = 0; i < region->size(); ++i) {
      cloud.foreground.data()[i] &= region->data()[i] != 0;
    }
  }
  cloud.normals_C.resize(cloud.depth_m.size());
  const PlaneFitOptions fit{.window_px = options.normal_window_px,
                            .band_m = options.fit_band_m * cloud.error_scale};
  FitPlanes(cloud.intrinsics, cloud.foreground, fit, cloud.depth_m, cloud.normals_C, threads);
  FillPoints(cloud, threads);
  assert(IsFinite(cloud));
  return cloud;
}

}  // namespace pickbed::perception
