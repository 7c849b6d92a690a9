#include "perception/segments/object_segments.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <set>
#include <utility>

#include "perception/cloud/search_cloud.h"
#include "perception/segments/edge_contraction.h"
#include "scenes/base/error.h"

namespace pickbed::perception {
namespace {

using Eigen::Vector3f;

// Angle between the normals of two patches, rad; negative for a concave border.
double SignedAngle(const SurfacePatch& a, const SurfacePatch& b) {
  const Vector3f way = b.center_C - a.center_C;
  const double cosine = std::clamp<double>(a.normal_C.dot(b.normal_C), -1, 1);
  const bool is_convex = (b.normal_C - a.normal_C).dot(way) > 0;
  return is_convex ? std::acos(cosine) : -std::acos(cosine);
}

// Weight of a border per pixel: 1 = smooth, negative = it separates.
double SurfaceWeight(const SurfacePatch& a, const SurfacePatch& b, const SegmenterOptions& o) {
  if (a.normal_C.isZero() || b.normal_C.isZero()) return 0.5;
  const double angle = SignedAngle(a, b), over = std::abs(angle) - o.flat_rad;
  if (over <= 0) return 1;
  if (angle > 0) {
    constexpr double kSharp_rad = 1.2;
    const double share = std::min(1.0, over / (kSharp_rad - o.flat_rad));
    return 1 - (1 - o.convex_weight) * share;
  }
  if (o.concave_weight <= 0) return 1;
  return std::max(-o.concave_weight, 1 - 2 * over / (o.concave_rad - o.flat_rad));
}

std::vector<WeightedEdge> EdgesOf(const SurfacePatches& found, bool has_color,
                                  const SegmenterOptions& options) {
  std::vector<WeightedEdge> edges;
  for (const PatchBorder& border : found.borders) {
    const SurfacePatch &a = found.patches[border.a], &b = found.patches[border.b];
    double each = SurfaceWeight(a, b, options);
    if (has_color && options.color_weight > 0) {
      const double difference = (a.color - b.color).cwiseAbs().maxCoeff();
      each -= options.color_weight * std::min(1.0, difference / options.color_step);
    }
    edges.push_back(
        {border.a, border.b, border.smooth_px * each - border.step_px * options.step_weight});
  }
  return edges;
}

// Joins each group under `join_px`, the smallest first, with the neighbour that has the longest
// border without a step.
void JoinSmallGroups(const SurfacePatches& found, int join_px, std::vector<int>& groups) {
  const int count = groups.empty() ? 0 : *std::max_element(groups.begin(), groups.end()) + 1;
  std::vector<int> pixels(count, 0), parent(count);
  std::iota(parent.begin(), parent.end(), 0);
  for (size_t i = 0; i < groups.size(); ++i) pixels[groups[i]] += found.patches[i].pixels;
  std::vector<std::map<int, int>> smooth_px(count);  // by group, to each neighbour
  for (const PatchBorder& border : found.borders) {
    const int a = groups[border.a], b = groups[border.b];
    if (a == b || border.smooth_px == 0) continue;
    smooth_px[a][b] += border.smooth_px;
    smooth_px[b][a] += border.smooth_px;
  }
  std::set<std::pair<int, int>> small;  // pixels, group
  for (int group = 0; group < count; ++group) {
    if (pixels[group] < join_px) small.insert({pixels[group], group});
  }
  while (!small.empty()) {
    const int group = small.begin()->second;
    small.erase(small.begin());
    const auto longest = std::max_element(
        smooth_px[group].begin(), smooth_px[group].end(),
        [](const auto& left, const auto& right) { return left.second < right.second; });
    if (longest == smooth_px[group].end()) continue;
    const int target = longest->first;
    small.erase({pixels[target], target});
    pixels[target] += pixels[group];
    if (pixels[target] < join_px) small.insert({pixels[target], target});
    parent[group] = target;
    for (const auto& [other, length_px] : smooth_px[group]) {
      smooth_px[other].erase(group);
      if (other == target) continue;
      smooth_px[other][target] += length_px;
      smooth_px[target][other] += length_px;
    }
    smooth_px[group].clear();
  }
  for (int& group : groups) {
    while (parent[group] != group) group = parent[group];
  }
}

// Removes the groups that rise nowhere far from a plane of the background: noise of the plane.
// Marks their patches with -1.
void RemoveFlatGroups(const OrganizedCloud& cloud, const SurfacePatches& found, double min_height_m,
                      std::vector<int>& groups) {
  if (cloud.planes.empty() || min_height_m <= 0) return;
  const BackgroundPlane& floor = cloud.planes.back();
  std::vector<bool> rises(groups.size(), false);
  for (size_t i = 0; i < groups.size(); ++i) {
    const Vector3f& center_C = found.patches[i].center_C;
    const float limit_m = static_cast<float>(min_height_m) * center_C.z() * center_C.z();
    if (floor.SignedDistance(center_C) > limit_m) rises[groups[i]] = true;
  }
  for (int& group : groups) {
    if (!rises[group]) group = -1;
  }
}

ObjectSegments Numbered(const OrganizedCloud& cloud, const SurfacePatches& found,
                        const std::vector<int>& groups, int min_px) {
  ObjectSegments result;
  const int width = cloud.depth_m.width(), height = cloud.depth_m.height();
  result.labels = Image<uint16_t>(width, height);
  std::vector<int> pixels(groups.size(), 0), number(groups.size(), 0);
  for (size_t i = 0; i < groups.size(); ++i) {
    if (groups[i] >= 0) pixels[groups[i]] += found.patches[i].pixels;
  }
  constexpr size_t kMaxSegments = std::numeric_limits<uint16_t>::max();
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const int pixel = y * width + x, patch = found.of_pixel[pixel];
      if (patch < 0 || groups[patch] < 0 || pixels[groups[patch]] < min_px) continue;
      int& label = number[groups[patch]];
      if (label == 0) {
        if (result.segments.size() == kMaxSegments) continue;
        result.segments.push_back({0, {x, y, 1, 1}, Vector3f::Zero()});
        label = static_cast<int>(result.segments.size());
      }
      result.labels(x, y) = static_cast<uint16_t>(label);
      ObjectSegment& segment = result.segments[label - 1];
      ++segment.pixels;
      segment.center_C += cloud.points_C[pixel];
      ImageBox& box = segment.box;
      const int right = std::max(box.x + box.width, x + 1);
      box.x = std::min(box.x, x);
      box.width = right - box.x;
      box.height = y + 1 - box.y;
    }
  }
  for (ObjectSegment& segment : result.segments) {
    segment.center_C /= static_cast<float>(segment.pixels);
  }
  return result;
}

// Returns the segments of a binned frame at the resolution of the frame. A pixel without a reading
// has no label.
ObjectSegments Unbinned(const ObjectSegments& binned, int factor, const Image<float>& depth_m) {
  ObjectSegments result = binned;
  result.labels = Image<uint16_t>(depth_m.width(), depth_m.height());
  for (ObjectSegment& segment : result.segments) {
    segment.pixels = 0;
    ImageBox& box = segment.box;
    box = {box.x * factor, box.y * factor, box.width * factor, box.height * factor};
  }
  for (int y = 0; y < depth_m.height(); ++y) {
    for (int x = 0; x < depth_m.width(); ++x) {
      const int u = x / factor, v = y / factor;
      if (!(depth_m(x, y) > 0) || !binned.labels.Contains(u, v)) continue;
      const uint16_t label = binned.labels(u, v);
      result.labels(x, y) = label;
      if (label > 0) ++result.segments[label - 1].pixels;
    }
  }
  return result;
}

SegmenterOptions Convexity() { return {}; }

SegmenterOptions ConvexityAndColor() {
  SegmenterOptions options;
  options.color_weight = 1;
  return options;
}

SegmenterOptions DepthSteps() {
  SegmenterOptions options;
  options.concave_weight = 0;
  options.convex_weight = 1;
  return options;
}

constexpr std::array<SegmenterRow, 3> kSegmenters{{
    {"convexity", "objects end at steps in depth and at concave borders", Convexity},
    {"convexity_color", "like convexity, and objects end at edges of color", ConvexityAndColor},
    {"depth_steps", "objects end at steps in depth only", DepthSteps},
}};

}  // namespace

void SegmenterOptions::Visit(SettingsVisitor& v) {
  const Range weight{0, 100};
  v.Group(
      "patches", [this](SettingsVisitor& g) { patches.Visit(g); }, "patches of surface");
  v.Real("flat_rad", flat_rad, {0, 1.5},
         "angle between two patches up to which their border is smooth, rad");
  v.Real("concave_rad", concave_rad, {0.01, 3.2},
         "angle of a concave border that weighs as much as a smooth border, rad");
  v.Real("convex_weight", convex_weight, weight,
         "weight of a sharp convex border, relative to a smooth border");
  v.Real("concave_weight", concave_weight, weight,
         "limit of the weight of a concave border; 0 = convexity is ignored");
  v.Real("step_weight", step_weight, weight, "weight of a step in depth");
  v.Real("color_weight", color_weight, weight, "weight of an edge of color; 0 = it is ignored");
  v.Real("color_step", color_step, {0.001, 1},
         "difference of two colors that counts as a full edge, share of the range");
  v.Integer("max_width_px", max_width_px, {16, 100000},
            "width from which an image is binned before segmentation, px");
  v.Integer("join_px", join_px, {0, 1e6},
            "size under which a segment is joined with a neighbour, px");
  v.Integer("min_px", min_px, {1, 1e6}, "size under which a segment is left out, px");
  v.Real("min_height_m", min_height_m, {0, 0.1},
         "height over the floor that some of a segment must reach, m, at 1 m");
}

std::span<const SegmenterRow> SegmenterTable() { return kSegmenters; }

const SegmenterRow& SegmenterNamed(const std::string& name) {
  std::vector<std::string> names;
  for (const SegmenterRow& row : kSegmenters) {
    if (name == row.name) return row;
    names.push_back(row.name);
  }
  throw InputError(UnknownNameMessage("segmentation", name, names));
}

ObjectSegments SegmentCloud(const OrganizedCloud& cloud, const SegmenterOptions& options) {
  CheckSettings("SegmenterOptions", options);
  CheckInput(options.concave_rad > options.flat_rad,
             "concave_rad must be larger than flat_rad: increase concave_rad");
  const SurfacePatches found = FindPatches(cloud, options.patches);
  std::vector<int> groups = ContractEdges(static_cast<int>(found.patches.size()),
                                          EdgesOf(found, !cloud.color.empty(), options));
  JoinSmallGroups(found, options.join_px, groups);
  RemoveFlatGroups(cloud, found, options.min_height_m, groups);
  return Numbered(cloud, found, groups, options.min_px);
}

ObjectSegments SegmentFrame(const RgbdFrame& frame,
                            const std::optional<KnownBackground>& background,
                            const SegmenterOptions& options) {
  const int width = frame.depth_m.width();
  const int factor = (width + options.max_width_px - 1) / std::max(1, options.max_width_px);
  const OrganizedCloud cloud = SearchCloud(frame, background, std::max(1, factor));
  const ObjectSegments segments = SegmentCloud(cloud, options);
  if (cloud.depth_m.width() == width) return segments;
  return Unbinned(segments, factor, frame.depth_m);
}

}  // namespace pickbed::perception
