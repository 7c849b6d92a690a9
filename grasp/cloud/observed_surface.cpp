#include "grasp/cloud/observed_surface.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <unordered_map>

#include "scenes/base/error.h"
#include "scenes/camera/filled_depth.h"

namespace pickbed::grasp {
namespace {

using Eigen::Vector3f;

// Disjoint sets of pixels.
class PixelSets {
 public:
  explicit PixelSets(size_t pixels) : parent_(pixels) {
    std::iota(parent_.begin(), parent_.end(), 0);
  }
  int RootOf(int pixel) {
    while (parent_[pixel] != pixel) pixel = parent_[pixel] = parent_[parent_[pixel]];
    return pixel;
  }
  void Join(int a, int b) {
    a = RootOf(a);
    b = RootOf(b);
    if (a != b) parent_[std::max(a, b)] = std::min(a, b);
  }

 private:
  std::vector<int> parent_;
};

// Returns the depth without readings that have too few neighbors at nearly the same place. Single
// readings of a steep face can be 20 mm off, and look like a thin face of their own.
Image<float> WithoutOutliers(const RgbdFrame& frame, const SurfaceOptions& options) {
  Image<float> kept = frame.depth_m;
  if (options.min_neighbors == 0) return kept;
  const auto place_C = [&](int u, int v) {
    return BackProject(frame.intrinsics, u, v, frame.depth_m(u, v));
  };
  const int width = kept.width(), height = kept.height();
  for (int v = 0; v < height; ++v) {
    for (int u = 0; u < width; ++u) {
      if (!IsReading(frame.depth_m(u, v))) continue;
      int near = 0;
      for (int y = std::max(0, v - 1); y <= std::min(height - 1, v + 1); ++y) {
        for (int x = std::max(0, u - 1); x <= std::min(width - 1, u + 1); ++x) {
          if ((x == u && y == v) || !IsReading(frame.depth_m(x, y))) continue;
          near += (place_C(x, y) - place_C(u, v)).norm() <= options.step_m;
        }
      }
      if (near < options.min_neighbors) kept(u, v) = 0;
    }
  }
  return kept;
}

class SurfaceBuilder {
 public:
  SurfaceBuilder(const RgbdFrame& frame, const Pose& X_WC, const std::optional<BinPlacement>& bin,
                 const SurfaceOptions& options)
      : options_(options),
        width_(frame.depth_m.width()),
        height_(frame.depth_m.height()),
        measured_m_(WithoutOutliers(frame, options)),
        depth_m_(FilledDepth(measured_m_)) {
    const Pose X_BC = bin ? bin->X_WB.inverse() * X_WC : X_WC;
    points_B_.resize(depth_m_.size(), Vector3f::Constant(kNone));
    is_inside_.resize(depth_m_.size());
    const Eigen::Matrix3f R_BC = X_BC.linear().cast<float>();
    const Vector3f origin = X_BC.translation().cast<float>();
    Eigen::Array2f half_m = Eigen::Array2f::Constant(std::numeric_limits<float>::infinity());
    if (bin) {
      half_m = (0.5 * bin->bin.inner_size_m.head<2>()).cast<float>().array() +
               static_cast<float>(options.margin_m);
    }
    const CameraIntrinsics& k = frame.intrinsics;
    for (int v = 0, i = 0; v < height_; ++v) {
      for (int u = 0; u < width_; ++u, ++i) {
        const float z = depth_m_.data()[i];
        if (!std::isfinite(z)) continue;
        const Vector3f p_C = BackProject(k, u, v, z).cast<float>();
        points_B_[i] = R_BC * p_C + origin;
        is_inside_[i] = (points_B_[i].head<2>().array().abs() <= half_m).all();
      }
    }
    MarkObjects(bin);
  }

  ObservedSurface Build() {
    FindSegments();
    AddPoints();
    return std::move(surface_);
  }

 private:
  static constexpr float kNone = std::numeric_limits<float>::quiet_NaN();

  bool IsMeasured(int i) const { return IsReading(measured_m_.data()[i]); }

  // Marks the measured pixels inside the bin that are not on its floor or walls.
  void MarkObjects(const std::optional<BinPlacement>& bin) {
    is_object_.resize(depth_m_.size());
    const float band_m = static_cast<float>(options_.bin_band_m);
    Eigen::Array2f room_m = Eigen::Array2f::Constant(std::numeric_limits<float>::infinity());
    if (bin && bin->bin.inner_size_m.z() > 0) {
      room_m = (0.5 * bin->bin.inner_size_m.head<2>()).cast<float>().array() - band_m;
    }
    const float floor_m = bin ? band_m : -std::numeric_limits<float>::infinity();
    for (size_t i = 0; i < points_B_.size(); ++i) {
      const Vector3f& p = points_B_[i];
      is_object_[i] = IsMeasured(static_cast<int>(i)) && is_inside_[i] && p.z() > floor_m &&
                      (p.head<2>().array().abs() < room_m).all();
    }
  }

  void FindSegments() {
    PixelSets sets(points_B_.size());
    const float step_m = static_cast<float>(options_.step_m);
    const auto join = [&](int a, int b) {
      if (!is_object_[a] || !is_object_[b]) return;
      if ((points_B_[a] - points_B_[b]).norm() <= step_m) sets.Join(a, b);
    };
    for (int v = 0; v < height_; ++v) {
      for (int u = 0; u < width_; ++u) {
        const int i = v * width_ + u;
        if (u + 1 < width_) join(i, i + 1);
        if (v + 1 < height_) join(i, i + width_);
      }
    }
    JoinFragments(sets);
    NumberSegments(sets);
  }

  // Joins small fragments with a neighbor beyond a larger step. On a face along the viewing ray,
  // the step between two rows of pixels is large, so that each row is a fragment.
  void JoinFragments(PixelSets& sets) const {
    std::vector<int> pixels(points_B_.size(), 0);
    for (size_t i = 0; i < pixels.size(); ++i) {
      if (is_object_[i]) ++pixels[sets.RootOf(static_cast<int>(i))];
    }
    const float step_m = static_cast<float>(options_.fragment_step_m);
    const auto join = [&](int a, int b) {
      if (!is_object_[a] || !is_object_[b]) return;
      const int root_a = sets.RootOf(a), root_b = sets.RootOf(b);
      if (root_a == root_b) return;
      const int smaller = std::min(pixels[root_a], pixels[root_b]);
      if (smaller >= options_.fragment_px) return;
      if ((points_B_[a] - points_B_[b]).norm() > step_m) return;
      const int sum = pixels[root_a] + pixels[root_b];
      sets.Join(a, b);
      pixels[sets.RootOf(a)] = sum;
    };
    for (int v = 0; v < height_; ++v) {
      for (int u = 0; u < width_; ++u) {
        const int i = v * width_ + u;
        if (u + 1 < width_) join(i, i + 1);
        if (v + 1 < height_) join(i, i + width_);
      }
    }
  }

  void NumberSegments(PixelSets& sets) {
    std::vector<int> pixels(points_B_.size(), 0);
    for (size_t i = 0; i < pixels.size(); ++i) {
      if (is_object_[i]) ++pixels[sets.RootOf(static_cast<int>(i))];
    }
    std::vector<int> number(points_B_.size(), kBackground);
    segment_of_.assign(points_B_.size(), kBackground);
    for (size_t i = 0; i < pixels.size(); ++i) {
      if (!is_object_[i]) continue;
      const int root = sets.RootOf(static_cast<int>(i));
      if (pixels[root] < options_.min_segment_px) continue;
      if (number[root] == kBackground) {
        number[root] = static_cast<int>(surface_.segments.size());
        surface_.segments.push_back({Eigen::Vector3d::Zero(), points_B_[i].z(), 0});
      }
      segment_of_[i] = number[root];
      SurfaceSegment& segment = surface_.segments[number[root]];
      segment.center_B += points_B_[i].cast<double>();
      segment.top_m = std::max<double>(segment.top_m, points_B_[i].z());
      ++segment.pixels;
    }
    for (SurfaceSegment& segment : surface_.segments) segment.center_B /= segment.pixels;
  }

  // Keeps the highest point of each voxel; a measured one before one of the shadow.
  void Add(const Vector3f& p_B, int segment) {
    const Eigen::Vector3i cell =
        (p_B.array() / static_cast<float>(options_.voxel_m)).floor().cast<int>();
    constexpr int64_t kRange = 1 << 20;
    const int64_t key =
        ((cell.x() + kRange / 2) * kRange + cell.y() + kRange / 2) * kRange + cell.z() + kRange / 2;
    const auto [place, is_new] = voxels_.try_emplace(key, surface_.points.size());
    if (is_new) {
      surface_.points.push_back({p_B, segment});
      return;
    }
    SurfacePoint& old = surface_.points[place->second];
    const bool was_shadow = old.segment == kShadow, is_shadow = segment == kShadow;
    if (was_shadow == is_shadow ? p_B.z() > old.p_B.z() : was_shadow) old = {p_B, segment};
  }

  void AddPoints() {
    voxels_.reserve(depth_m_.size());
    for (int v = 0; v < height_; ++v) {
      for (int u = 0; u < width_; ++u) {
        const int i = v * width_ + u;
        if (!std::isfinite(points_B_[i].x()) || !is_inside_[i]) continue;
        Add(points_B_[i], IsMeasured(i) ? segment_of_[i] : kShadow);
        if (u + 1 < width_) AddBorder(i, i + 1);
        if (v + 1 < height_) AddBorder(i, i + width_);
      }
    }
  }

  // Adds points between two neighboring pixels that are further apart than a voxel.
  void AddBorder(int a, int b) {
    if (!std::isfinite(points_B_[b].x()) || !is_inside_[b]) return;
    const Vector3f way = points_B_[b] - points_B_[a];
    const float voxel_m = static_cast<float>(options_.voxel_m);
    const int pieces = static_cast<int>(way.norm() / voxel_m);
    // Within a segment, the surface between two pixels counts as measured.
    const bool same = segment_of_[a] == segment_of_[b] && segment_of_[a] != kBackground;
    for (int k = 1; k <= pieces; ++k) {
      const float share = static_cast<float>(k) / static_cast<float>(pieces + 1);
      Add(points_B_[a] + share * way, same ? segment_of_[a] : kShadow);
    }
  }

  const SurfaceOptions& options_;
  const int width_, height_;
  const Image<float> measured_m_;
  const Image<float> depth_m_;      // filled
  std::vector<Vector3f> points_B_;  // by pixel; NaN = none
  std::vector<uint8_t> is_inside_, is_object_;
  std::vector<int> segment_of_;
  std::unordered_map<int64_t, size_t> voxels_;
  ObservedSurface surface_;
};

}  // namespace

void SurfaceOptions::Visit(SettingsVisitor& v) {
  const Range length{0.0005, 0.1};
  v.Real("voxel_m", voxel_m, length, "edge of the cubes with at most one point, m");
  v.Real("step_m", step_m, length, "step between neighboring pixels that separates segments, m");
  v.Real("bin_band_m", bin_band_m, {0, 0.1},
         "points closer than this to floor and walls belong to the bin, m");
  v.Integer("fragment_px", fragment_px, {0, 100000},
            "size under which a segment is joined with a neighbor, px");
  v.Real("fragment_step_m", fragment_step_m, length,
         "largest step over which a small segment is joined, m");
  v.Integer("min_segment_px", min_segment_px, {1, 100000}, "minimum size of a segment, px");
  v.Real("margin_m", margin_m, {0, 10}, "width of the seen border around the bin, m");
  v.Integer("min_neighbors", min_neighbors, {0, 8},
            "readings with fewer neighbors within step_m are left out as outliers");
}

ObservedSurface ObserveSurface(const RgbdFrame& frame, const Pose& X_WC,
                               const std::optional<BinPlacement>& bin,
                               const SurfaceOptions& options) {
  CheckSettings("SurfaceOptions", options);
  CheckInput(!frame.depth_m.empty(), "the image has no depth, which a planner without poses needs");
  return SurfaceBuilder(frame, X_WC, bin, options).Build();
}

}  // namespace pickbed::grasp
