#include "perception/crops/crop_augment.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace pickbed::perception {
namespace {

// Working copy of one crop and its mask.
struct Canvas {
  std::vector<int16_t> depth = std::vector<int16_t>(kCropArea, int16_t(kCropDepthUnit));
  std::vector<Rgb8> color = std::vector<Rgb8>(kCropArea);
  std::vector<uint8_t> mask = std::vector<uint8_t>(kCropArea);
};

int16_t Stored(double relative) {
  return static_cast<int16_t>(std::lround(kCropDepthUnit * std::clamp(relative, -1.0, 1.0)));
}

// Calls visit(from, to) for the pixels that remain inside the crop after a shift.
template <typename Visit>
void ForShifted(int dx, int dy, const Visit& visit) {
  for (int y = std::max(0, dy); y < std::min(kCropPixels, kCropPixels + dy); ++y) {
    for (int x = std::max(0, dx); x < std::min(kCropPixels, kCropPixels + dx); ++x) {
      visit((y - dy) * kCropPixels + x - dx, y * kCropPixels + x);
    }
  }
}

Canvas Shifted(const CropSet& pool, size_t i, const CropAugmentOptions& options, Rng& rng) {
  Canvas canvas;
  const int range = 2 * options.shift_px + 1;
  const int dx = rng.Index(range) - options.shift_px, dy = rng.Index(range) - options.shift_px;
  const double nearer = rng.Uniform(-options.shift_depth, options.shift_depth);
  const size_t first = i * kCropArea;
  ForShifted(dx, dy, [&](int from, int to) {
    canvas.color[to] = pool.color[first + from];
    canvas.mask[to] = pool.masks[first + from];
    const int16_t depth = pool.depth[first + from];
    canvas.depth[to] =
        canvas.mask[to] && depth < kCropDepthUnit ? Stored(depth / kCropDepthUnit - nearer) : depth;
  });
  return canvas;
}

// Sum of smoothly interpolated random grids, each twice as fine and half as strong as the one
// before (value noise); within [-1, 1].
std::array<float, kCropArea> FractalNoise(Rng& rng) {
  std::array<float, kCropArea> noise{};
  float strength = 0.5f;
  for (int cells = 2; cells <= 16; cells *= 2, strength *= 0.5f) {
    std::vector<float> grid((cells + 1) * (cells + 1));
    for (float& value : grid) value = static_cast<float>(rng.Uniform(-1, 1));
    for (int y = 0; y < kCropPixels; ++y) {
      const float v = static_cast<float>(y) * cells / kCropPixels;
      const int row = static_cast<int>(v);
      for (int x = 0; x < kCropPixels; ++x) {
        const float u = static_cast<float>(x) * cells / kCropPixels;
        const int column = static_cast<int>(u);
        const float* g = grid.data() + row * (cells + 1) + column;
        const float a = u - column, b = v - row;
        noise[y * kCropPixels + x] += strength * ((1 - b) * ((1 - a) * g[0] + a * g[1]) +
                                                  b * ((1 - a) * g[cells + 1] + a * g[cells + 2]));
      }
    }
  }
  return noise;
}

void PaintNoise(Canvas& canvas, Rng& rng) {
  const std::array<float, kCropArea> depth = FractalNoise(rng), red = FractalNoise(rng),
                                     green = FractalNoise(rng), blue = FractalNoise(rng);
  const double center = rng.Uniform(-0.5, 1);
  const auto byte = [](float value) {
    return static_cast<uint8_t>(std::clamp(std::lround(127.5 + 127.5 * value), 0l, 255l));
  };
  for (int p = 0; p < kCropArea; ++p) {
    if (canvas.mask[p]) continue;
    canvas.depth[p] = Stored(center + depth[p]);
    canvas.color[p] = {byte(red[p]), byte(green[p]), byte(blue[p])};
  }
}

int Hidden(const Canvas& canvas, const uint8_t* blocker, int dx, int dy) {
  int hidden = 0;
  ForShifted(dx, dy, [&](int from, int to) { hidden += blocker[from] & canvas.mask[to]; });
  return hidden;
}

// Slides crop j of `blockers` in from a random side until it hides more than `share` of the object.
// Paints it at the position one step before.
void Occlude(const CropSet& blockers, size_t j, double share, Canvas& canvas, Rng& rng) {
  const int visible = static_cast<int>(std::count(canvas.mask.begin(), canvas.mask.end(), 1));
  const Eigen::Vector3d side = rng.UnitVector();
  const double length = std::max(1e-6, side.head<2>().norm());
  const uint8_t* blocker = blockers.masks.data() + j * kCropArea;
  int dx = 0, dy = 0;
  for (int distance = kCropPixels; distance >= 0; --distance) {
    const int next_dx = static_cast<int>(std::lround(distance * side.x() / length));
    const int next_dy = static_cast<int>(std::lround(distance * side.y() / length));
    if (Hidden(canvas, blocker, next_dx, next_dy) > share * visible) break;
    dx = next_dx;
    dy = next_dy;
  }
  if (dx == 0 && dy == 0) return;
  const double nearer = rng.Uniform(0.2, 0.9);
  ForShifted(dx, dy, [&](int from, int to) {
    if (!blocker[from]) return;
    canvas.depth[to] = Stored(blockers.depth[j * kCropArea + from] / kCropDepthUnit - nearer);
    canvas.color[to] = blockers.color[j * kCropArea + from];
  });
}

}  // namespace

void CropAugmentOptions::Visit(SettingsVisitor& v) {
  v.Real("background_share", background_share, {0, 1}, "share of crops with a noise background");
  v.Real("occluded_share", occluded_share, {0, 1}, "share of crops with an occluder");
  v.Real("occluded_max", occluded_max, {0, 0.9},
         "maximum share of the object that an occluder hides");
  v.Integer("shift_px", shift_px, {0, 32}, "maximum shift of the crop center along x and y, px");
  v.Real("shift_depth", shift_depth, {0, 1},
         "maximum shift of the crop center in depth, over the crop's side");
}

void AppendAugmented(const CropSet& pool, size_t i, const CropSet& blockers,
                     const CropAugmentOptions& options, Rng& rng, CropSet& out) {
  Canvas canvas = Shifted(pool, i, options, rng);
  if (rng.Uniform() < options.background_share) PaintNoise(canvas, rng);
  if (rng.Uniform() < options.occluded_share) {
    const size_t blocker = rng.Index(static_cast<int>(blockers.size()));
    Occlude(blockers, blocker, rng.Uniform(0, options.occluded_max), canvas, rng);
  }
  out.depth.insert(out.depth.end(), canvas.depth.begin(), canvas.depth.end());
  out.color.insert(out.color.end(), canvas.color.begin(), canvas.color.end());
  out.spots.push_back(pool.spots[i]);
}

}  // namespace pickbed::perception
