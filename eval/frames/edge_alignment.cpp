#include "eval/frames/edge_alignment.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <vector>

#include "perception/cloud/color_edges.h"

namespace pickbed::eval {
namespace {

constexpr int kReach_px = 40;  // largest shift
constexpr int kStep_px = 4;
constexpr std::array<double, 7> kScales{1, 0.8, 0.87, 0.93, 1.08, 1.16, 1.25};

// Gradients above this are equally good edges. Else a few strong ones would decide.
constexpr float kFullGradient = 12;  // grey levels per px

// A direction as a vector at twice its angle, so that opposite directions are equal: a depth edge
// is not always darker on the same side.
using Axis = Eigen::Vector2f;

Axis AxisOf(float dx, float dy) {
  const float squared = dx * dx + dy * dy;
  if (squared <= 0) return Axis::Zero();
  return Axis(dx * dx - dy * dy, 2 * dx * dy) / squared;
}

// Replaces each pixel by the mean of 2 * reach + 1 pixels of its row. Pixels outside count as zero.
void AverageRows(int reach, Image<Axis>& image) {
  const float weight = 1.0f / static_cast<float>(2 * reach + 1);
  std::vector<Axis> line(image.width() + 2 * reach, Axis::Zero());
  for (int y = 0; y < image.height(); ++y) {
    Axis* row = image.row(y);
    std::copy_n(row, image.width(), line.begin() + reach);
    for (int x = 0; x < image.width(); ++x) {
      Axis sum = Axis::Zero();
      for (int i = 0; i <= 2 * reach; ++i) sum += line[x + i];
      row[x] = weight * sum;
    }
  }
}

// The same for columns.
void AverageColumns(int reach, Image<Axis>& image) {
  const float weight = 1.0f / static_cast<float>(2 * reach + 1);
  const Image<Axis> from = image;
  for (int y = 0; y < image.height(); ++y) {
    Axis* row = image.row(y);
    std::fill_n(row, image.width(), Axis::Zero());
    for (int v = std::max(0, y - reach); v <= std::min(image.height() - 1, y + reach); ++v) {
      const Axis* other = from.row(v);
      for (int x = 0; x < image.width(); ++x) row[x] += weight * other[x];
    }
  }
}

// Two box filters in each direction are close to a Gaussian.
Image<Axis> Blurred(Image<Axis> image, int reach) {
  for (int pass = 0; pass < 2; ++pass) {
    AverageRows(reach, image);
    AverageColumns(reach, image);
  }
  return image;
}

// Directions of the color gradients, times their strengths of 0..1.
Image<Axis> ColorAxes(const RgbdFrame& frame) {
  const perception::ColorEdges edges = perception::FindColorEdges(frame.intrinsics, frame.color);
  Image<Axis> axes(edges.du.width(), edges.du.height(), Axis::Zero());
  for (size_t i = 0; i < axes.size(); ++i) {
    const float du = edges.du.data()[i], dv = edges.dv.data()[i];
    const float strength = std::min(1.0f, std::sqrt(du * du + dv * dv) / kFullGradient);
    axes.data()[i] = strength * AxisOf(du, dv);
  }
  return axes;
}

struct DepthEdge {
  Eigen::Vector2d at_px;
  Axis axis;  // across the edge
};

// Pixels in front of a step to a farther surface. Holes are no steps, since their border is beside
// the edge.
std::vector<DepthEdge> DepthEdges(const Image<float>& depth_m) {
  constexpr float kMinStep_m = 0.015f, kMinShare = 0.02f;
  constexpr size_t kMaxEdges = 1500;
  constexpr int kAround_px = 4;  // steps this near to a pixel give its direction
  // Sum of the steps of a pixel, each as a unit vector to the farther side.
  Image<Eigen::Vector2f> steps(depth_m.width(), depth_m.height(), Eigen::Vector2f::Zero());
  Image<uint8_t> is_edge(depth_m.width(), depth_m.height(), 0);
  const auto add = [&](int x, int y, int u, int v) {
    const float a = depth_m(x, y), b = depth_m(u, v);
    if (!(a > 0) || !(b > 0)) return;
    const float near = std::min(a, b);
    if (std::abs(a - b) < std::max(kMinStep_m, kMinShare * near)) return;
    const Eigen::Vector2f outward(static_cast<float>(u - x), static_cast<float>(v - y));
    const bool first_is_near = a < b;
    steps(first_is_near ? x : u, first_is_near ? y : v) += first_is_near ? outward : -outward;
    is_edge(first_is_near ? x : u, first_is_near ? y : v) = 1;
  };
  for (int y = 0; y + 1 < depth_m.height(); ++y) {
    for (int x = 0; x + 1 < depth_m.width(); ++x) {
      add(x, y, x + 1, y);
      add(x, y, x, y + 1);
    }
  }
  std::vector<Eigen::Vector2i> pixels;
  for (int y = 0; y < is_edge.height(); ++y) {
    for (int x = 0; x < is_edge.width(); ++x) {
      if (is_edge(x, y)) pixels.emplace_back(x, y);
    }
  }
  const size_t stride = pixels.size() / kMaxEdges + 1;
  std::vector<DepthEdge> edges;
  for (size_t i = 0; i < pixels.size(); i += stride) {
    Eigen::Vector2f outward = Eigen::Vector2f::Zero();
    for (int dy = -kAround_px; dy <= kAround_px; ++dy) {
      for (int dx = -kAround_px; dx <= kAround_px; ++dx) {
        const int x = pixels[i].x() + dx, y = pixels[i].y() + dy;
        const auto weight =
            static_cast<float>(kAround_px + 1 - std::max(std::abs(dx), std::abs(dy)));
        if (steps.Contains(x, y)) outward += weight * steps(x, y);
      }
    }
    edges.push_back({pixels[i].cast<double>(), AxisOf(outward.x(), outward.y())});
  }
  return edges;
}

// A place of the depth image over the color image.
struct Place {
  double scale = 1;
  Eigen::Vector2d shift_px{0, 0};
  double fit = 0;  // see FitAt()
};

// Farthest distance between the positions of an image corner in two places.
double CornerDistance_px(const CameraIntrinsics& camera, const Place& a, const Place& b) {
  double largest = 0;
  for (const double u : {0.0, camera.width() - 1.0}) {
    for (const double v : {0.0, camera.height() - 1.0}) {
      const Eigen::Vector2d from_center(u - camera.cx(), v - camera.cy());
      largest =
          std::max(largest, ((a.scale - b.scale) * from_center + a.shift_px - b.shift_px).norm());
    }
  }
  return largest;
}

// Mean agreement of the directions. At a place of chance it is near 0, or somewhat above it if one
// direction is frequent in both images. It is below 0 if the edges are across the color edges.
// Edges that leave the image do not count.
double FitAt(const Image<Axis>& color, const std::vector<DepthEdge>& edges,
             const Eigen::Vector2d& center, const Place& place) {
  double sum = 0;
  int count = 0;
  for (const DepthEdge& edge : edges) {
    const Eigen::Vector2d at = center + place.scale * (edge.at_px - center) + place.shift_px;
    const int x = static_cast<int>(std::lround(at.x())), y = static_cast<int>(std::lround(at.y()));
    if (!color.Contains(x, y)) continue;
    sum += color(x, y).dot(edge.axis);
    ++count;
  }
  return 2 * count > static_cast<int>(edges.size()) ? sum / count : 0;
}

// Fits of a grid of shifts with each of the scales.
std::vector<Place> Search(const Image<Axis>& color, const std::vector<DepthEdge>& edges,
                          const Eigen::Vector2d& center, std::span<const double> scales) {
  std::vector<Place> places;
  for (const double scale : scales) {
    for (int dy = -kReach_px; dy <= kReach_px; dy += kStep_px) {
      for (int dx = -kReach_px; dx <= kReach_px; dx += kStep_px) {
        Place place{scale, Eigen::Vector2d(dx, dy)};
        place.fit = FitAt(color, edges, center, place);
        places.push_back(place);
      }
    }
  }
  return places;
}

double MeanFit(const std::vector<Place>& places) {
  double sum = 0;
  for (const Place& place : places) sum += place.fit;
  return sum / static_cast<double>(places.size());
}

// Limits of a clear best place.
struct PeakLimits {
  double min_deviations;  // standard deviations of all fits above their mean
  double max_other;       // fit of another place above this mean, relative to the best one
};

// Measured on four real frames of 640 x 480 px and six simulated ones:
//                                  deviations           other place
//   all scales, edges fit          5.8 and more         at most 0.71
//   all scales, edges do not fit   at most 3.6          0.90 and more
//   one scale, edges fit           4.1 and more         at most 0.45
//   one scale, edges do not fit    at most 3.6          0.51 and more
// One of the real frames has few edges, and its fits are as if they did not fit.
constexpr PeakLimits kAllScales{4.5, 0.8}, kOneScale{3.9, 0.48};

// Returns the best place if it is clear.
std::optional<Place> ClearPeak(const CameraIntrinsics& camera, const std::vector<Place>& places,
                               const PeakLimits& limits) {
  constexpr double kOther_px = 20;
  constexpr double kMinHeight = 0.03;  // rounding errors of images without edges are lower
  const double mean = MeanFit(places);
  const Place best = *std::ranges::max_element(places, {}, &Place::fit);
  const double height = best.fit - mean;
  if (!(height > kMinHeight)) return std::nullopt;
  double squares = 0, other = mean;
  for (const Place& place : places) {
    squares += (place.fit - mean) * (place.fit - mean);
    if (CornerDistance_px(camera, place, best) > kOther_px) other = std::max(other, place.fit);
  }
  const double deviation = std::sqrt(squares / static_cast<double>(places.size()));
  if (height < limits.min_deviations * deviation || other - mean > limits.max_other * height) {
    return std::nullopt;
  }
  return best;
}

// Best place within `reach_px` of a shift, without a scale.
Place BestNear(const Image<Axis>& color, const std::vector<DepthEdge>& edges,
               const Eigen::Vector2d& center, const Eigen::Vector2d& shift_px, int reach_px) {
  Place best{1, shift_px, -1};
  for (int dy = -reach_px; dy <= reach_px; ++dy) {
    for (int dx = -reach_px; dx <= reach_px; ++dx) {
      Place place{1, shift_px + Eigen::Vector2d(dx, dy)};
      place.fit = FitAt(color, edges, center, place);
      if (place.fit > best.fit) best = place;
    }
  }
  return best;
}

std::vector<DepthEdge> Flipped(std::vector<DepthEdge> edges, const Image<float>& depth_m,
                               DepthFlip flip) {
  const bool columns = flip == DepthFlip::kColumns || flip == DepthFlip::kBoth;
  const bool rows = flip == DepthFlip::kRows || flip == DepthFlip::kBoth;
  for (DepthEdge& edge : edges) {
    if (columns) edge.at_px.x() = depth_m.width() - 1 - edge.at_px.x();
    if (rows) edge.at_px.y() = depth_m.height() - 1 - edge.at_px.y();
    if (columns != rows) edge.axis.y() = -edge.axis.y();
  }
  return edges;
}

// Fit of a frame where it is, relative to a clear best place.
double FitHere(double here, double mean, double best) {
  return std::clamp((here - mean) / (best - mean), 0.0, 1.0);
}

// Returns the reflection of the depth image whose edges fit clearly, and clearly better than those
// of the depth image itself: a symmetric bin has edges that fit in both ways.
std::optional<EdgeAlignment> AlignReflected(const RgbdFrame& frame, const Image<Axis>& color,
                                            const std::vector<DepthEdge>& edges,
                                            const Eigen::Vector2d& center, double fit_as_given) {
  constexpr double kMinGain = 1.5;
  double best_fit = kMinGain * fit_as_given;
  std::optional<EdgeAlignment> found;
  for (const DepthFlip flip : {DepthFlip::kColumns, DepthFlip::kRows, DepthFlip::kBoth}) {
    const std::vector<DepthEdge> flipped = Flipped(edges, frame.depth_m, flip);
    const std::optional<Place> peak =
        ClearPeak(frame.intrinsics, Search(color, flipped, center, std::array{1.0}), kOneScale);
    if (!peak || peak->fit <= best_fit) continue;
    best_fit = peak->fit;
    found = EdgeAlignment{peak->shift_px, 1, flip, 0};
  }
  return found;
}

}  // namespace

double EdgeAlignment::CornerShift_px(const CameraIntrinsics& camera) const {
  return CornerDistance_px(camera, {scale, shift_px}, {});
}

std::optional<EdgeAlignment> AlignEdges(const RgbdFrame& frame) {
  constexpr size_t kMinEdges = 200;
  constexpr int kTolerance_px = 3;             // usual error of a registration
  constexpr int kCoarse_px = 3, kFine_px = 1;  // reach of the box filters
  if (frame.color.empty() || frame.color.width() != frame.depth_m.width() ||
      frame.color.height() != frame.depth_m.height()) {
    return std::nullopt;
  }
  const std::vector<DepthEdge> edges = DepthEdges(frame.depth_m);
  if (edges.size() < kMinEdges) return std::nullopt;
  const Image<Axis> color = ColorAxes(frame);
  const Image<Axis> coarse = Blurred(color, kCoarse_px);
  const Eigen::Vector2d center(frame.intrinsics.cx(), frame.intrinsics.cy());
  const std::vector<Place> places = Search(coarse, edges, center, kScales);
  const std::optional<Place> peak = ClearPeak(frame.intrinsics, places, kAllScales);
  if (!peak) {
    double fit_as_given = 0;
    for (const Place& place : places) {
      if (place.scale == 1) fit_as_given = std::max(fit_as_given, place.fit);
    }
    return AlignReflected(frame, coarse, edges, center, fit_as_given);
  }
  EdgeAlignment found{peak->shift_px, peak->scale};
  if (peak->scale != 1) {
    const double here = BestNear(coarse, edges, center, {0, 0}, kTolerance_px).fit;
    found.fit_here = FitHere(here, MeanFit(places), peak->fit);
    return found;
  }
  const Image<Axis> fine = Blurred(color, kFine_px);
  const Place best = BestNear(fine, edges, center, peak->shift_px, kStep_px);
  const double here = BestNear(fine, edges, center, {0, 0}, kTolerance_px).fit;
  const double mean = MeanFit(Search(fine, edges, center, std::array{1.0}));
  found.shift_px = best.shift_px;
  found.fit_here = FitHere(here, mean, best.fit);
  return found;
}

}  // namespace pickbed::eval
