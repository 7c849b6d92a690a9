#include "perception/segments/segment_cover.h"

#include <array>

#include "scenes/base/error.h"
#include "scenes/camera/filled_depth.h"

namespace pickbed::perception {
namespace {

struct Step {
  int x, y;
};
constexpr std::array<Step, 8> kDirections{
    {{1, 0}, {-1, 0}, {0, 1}, {0, -1}, {1, 1}, {-1, 1}, {1, -1}, {-1, -1}}};

// Returns the first reading outside of the segment of (x, y) in one direction; 0 = there is none,
// or the segment goes on behind a gap.
float DepthBeyond_m(const Image<float>& depth_m, const Image<uint16_t>& labels, int x, int y,
                    Step step, int search_px) {
  const uint16_t label = labels(x, y);
  for (int k = 1; k <= search_px; ++k) {
    const int u = x + k * step.x, v = y + k * step.y;
    if (u < 0 || v < 0 || u >= labels.width() || v >= labels.height()) return 0;
    if (labels(u, v) == label) return 0;
    if (IsReading(depth_m(u, v))) return depth_m(u, v);
  }
  return 0;
}

}  // namespace

void CoverOptions::Visit(SettingsVisitor& v) {
  v.Real("step_m", step_m, {0, 1}, "step towards the camera from which a neighbour covers, m");
  v.Integer("search_px", search_px, {1, 100},
            "distance in which a reading beyond the contour is searched, px");
}

std::vector<double> CoveredShares(const Image<float>& depth_m, const ObjectSegments& segments,
                                  const CoverOptions& options) {
  CheckSettings("CoverOptions", options);
  const Image<uint16_t>& labels = segments.labels;
  struct Pairs {
    int all = 0, covered = 0;
  };
  std::vector<Pairs> pairs(segments.segments.size());
  for (int y = 0; y < labels.height(); ++y) {
    for (int x = 0; x < labels.width(); ++x) {
      const uint16_t label = labels(x, y);
      if (label == 0 || !IsReading(depth_m(x, y))) continue;
      for (const Step step : kDirections) {
        const float beyond_m = DepthBeyond_m(depth_m, labels, x, y, step, options.search_px);
        if (beyond_m <= 0) continue;
        ++pairs[label - 1].all;
        if (depth_m(x, y) - beyond_m > options.step_m) ++pairs[label - 1].covered;
      }
    }
  }
  std::vector<double> shares;
  for (const Pairs& counted : pairs) {
    shares.push_back(counted.all > 0 ? static_cast<double>(counted.covered) / counted.all : 0);
  }
  return shares;
}

}  // namespace pickbed::perception
