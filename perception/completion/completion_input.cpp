#include "perception/completion/completion_input.h"

#include <algorithm>
#include <cmath>

#include "scenes/base/error.h"

namespace pickbed::perception {
namespace {

// Share of the points at each end that does not count for the extent: flying pixels.
constexpr double kOutlierShare = 0.004;
// The cube begins this share of its side before the nearest point.
constexpr float kFrontMargin = 0.06f;
// An occluder within this share of the extent may hide more of the object.
constexpr float kOccluderReach = 0.35f;
constexpr float kCutCells = 3;
constexpr float kFactScales[] = {48, 12, 1};
constexpr float kFloorScale = 4;

// Lowest and highest value without the outliers. Changes the order of the values.
std::pair<float, float> RobustRange(std::vector<float>& values) {
  const size_t skipped = static_cast<size_t>(kOutlierShare * static_cast<double>(values.size()));
  const auto low = values.begin() + static_cast<std::ptrdiff_t>(skipped);
  const auto high = values.end() - 1 - static_cast<std::ptrdiff_t>(skipped);
  std::nth_element(values.begin(), low, values.end());
  const float lowest = *low;
  std::nth_element(values.begin(), high, values.end());
  return {lowest, *high};
}

// Depths in the image are cut to this, in half sides from the cube's center.
constexpr float kCutDepth = 2;

int8_t Quantized(float value) {
  return static_cast<int8_t>(std::lround(127 * std::clamp(value, -1.0f, 1.0f)));
}

// Turns slices of size x size values.
template <typename Value>
void TurnSlices(std::span<const Value> values, int size, int turn, Value* next) {
  const bool flip_x = (turn & 1) != 0, flip_y = (turn & 2) != 0, swaps = (turn & 4) != 0;
  const size_t area = static_cast<size_t>(size) * size;
  for (size_t first = 0; first < values.size(); first += area) {
    const Value* const from = values.data() + first;
    for (int y = 0; y < size; ++y) {
      for (int x = 0; x < size; ++x) {
        int column = swaps ? y : x, row = swaps ? x : y;
        if (flip_x) column = size - 1 - column;
        if (flip_y) row = size - 1 - row;
        *next++ = from[row * size + column];
      }
    }
  }
}

}  // namespace

CompletionInput::CompletionInput(const SegmentView& view) {
  CheckSegmentView(view);
  const Image<uint8_t> occluders = view.occluders.empty() ? MarkOccluders(view) : view.occluders;
  floor_ = view.floor;
  FindCube(view, occluders);
  CopyWindow(view, occluders);
}

void CompletionInput::FindCube(const SegmentView& view, const Image<uint8_t>& occluders) {
  const CameraIntrinsics& k = view.intrinsics;
  std::vector<float> values[3];
  std::vector<Eigen::Vector2f> rays;  // of the occluders
  for (int y = 0; y < k.height(); ++y) {
    for (int x = 0; x < k.width(); ++x) {
      const float z = view.depth_m(x, y);
      if (!view.segment(x, y)) {
        if (occluders(x, y)) rays.push_back(BackProject(k, x, y, 1).head<2>().cast<float>());
        continue;
      }
      if (!HasReading(z)) continue;
      const Eigen::Vector3f p_C = BackProject(k, x, y, z).cast<float>();
      for (int axis = 0; axis < 3; ++axis) values[axis].push_back(p_C[axis]);
    }
  }
  Eigen::Vector3f low, high;
  for (int axis = 0; axis < 3; ++axis) {
    std::tie(low[axis], high[axis]) = RobustRange(values[axis]);
  }
  const float extent_m = (high - low).maxCoeff();
  CheckInput(extent_m > 0 && std::isfinite(extent_m),
             "the segment has no extent; its depth readings are not usable");
  const Eigen::Vector2f reach = Eigen::Vector2f::Constant(kOccluderReach * extent_m);
  const Eigen::Vector2f near_low = low.head<2>() - reach, near_high = high.head<2>() + reach;
  const float center_z_m = 0.5f * (low.z() + high.z());
  Eigen::Vector2f wide_low = low.head<2>(), wide_high = high.head<2>();
  for (const Eigen::Vector2f& ray : rays) {
    const Eigen::Vector2f at = ray * center_z_m;
    if ((at.array() < near_low.array()).any() || (at.array() > near_high.array()).any()) continue;
    wide_low = wide_low.cwiseMin(at);
    wide_high = wide_high.cwiseMax(at);
  }
  cube_.side_m = kSidePerExtent * std::max((wide_high - wide_low).maxCoeff(), high.z() - low.z());
  const Eigen::Vector2f center = 0.5f * (wide_low + wide_high);
  cube_.origin_C << center - Eigen::Vector2f::Constant(0.5f * cube_.side_m),
      low.z() - kFrontMargin * cube_.side_m;
  // Every point of the cube is in front of the camera, so that it has a pixel.
  cube_.origin_C.z() = std::max(cube_.origin_C.z(), 0.02f * low.z());
}

void CompletionInput::CopyWindow(const SegmentView& view, const Image<uint8_t>& occluders) {
  const CameraIntrinsics& k = view.intrinsics;
  // The window covers the projection of the cube's corners.
  Eigen::Array2d low(1e9, 1e9), high(-1e9, -1e9);
  for (int corner = 0; corner < 8; ++corner) {
    const Eigen::Vector3f offset(corner & 1, corner >> 1 & 1, corner >> 2);
    const Eigen::Vector3d p_C = (cube_.origin_C + cube_.side_m * offset).cast<double>();
    const Eigen::Array2d pixel = Project(k, p_C).array();
    low = low.min(pixel);
    high = high.max(pixel);
  }
  const auto inside = [](double value, int size) {
    return static_cast<int>(std::clamp(std::lround(value), 0l, static_cast<long>(size)));
  };
  const int left = inside(low.x() - 1, k.width()), right = inside(high.x() + 2, k.width());
  const int top = inside(low.y() - 1, k.height()), bottom = inside(high.y() + 2, k.height());
  fx_ = static_cast<float>(k.fx());
  fy_ = static_cast<float>(k.fy());
  cx_ = static_cast<float>(k.cx() - left);
  cy_ = static_cast<float>(k.cy() - top);
  depth_m_ = Image<float>(right - left, bottom - top, 0);
  classes_ = Image<PixelClass>(right - left, bottom - top, PixelClass::kNoData);
  for (int y = 0; y < depth_m_.height(); ++y) {
    for (int x = 0; x < depth_m_.width(); ++x) {
      const float z = view.depth_m(left + x, top + y);
      if (!HasReading(z)) continue;
      depth_m_(x, y) = z;
      classes_(x, y) = view.segment(left + x, top + y) ? PixelClass::kSegment
                       : occluders(left + x, top + y)  ? PixelClass::kOccluder
                                                       : PixelClass::kBackground;
    }
  }
  Image<PixelClass> checked = classes_;
  for (int y = 0; y < classes_.height(); ++y) {
    for (int x = 0; x < classes_.width(); ++x) {
      if (classes_(x, y) != PixelClass::kBackground) continue;
      for (int i = 0; i < 9; ++i) {
        const int column = x + i % 3 - 1, row = y + i / 3 - 1;
        if (classes_.Contains(column, row) && classes_(column, row) != PixelClass::kBackground) {
          checked(x, y) = PixelClass::kBesideOther;
        }
      }
    }
  }
  classes_ = std::move(checked);
}

PixelClass CompletionInput::ClassAt(const Eigen::Vector3f& p_C, float& depth_m) const {
  const float scale = 1 / p_C.z();
  const int x = static_cast<int>(std::floor(fx_ * p_C.x() * scale + cx_ + 0.5f));
  const int y = static_cast<int>(std::floor(fy_ * p_C.y() * scale + cy_ + 0.5f));
  depth_m = 0;
  if (!classes_.Contains(x, y)) return PixelClass::kNoData;
  depth_m = depth_m_(x, y);
  return classes_(x, y);
}

std::vector<int8_t> CompletionInput::Channels() const {
  constexpr size_t kVolume = kInputCells * kInputCells * kInputCells;
  std::vector<int8_t> channels(kInputChannels * kVolume, 0);
  const float cell_m = cube_.side_m / kInputCells;
  size_t cell = 0;
  for (int z = 0; z < kInputCells; ++z) {
    for (int y = 0; y < kInputCells; ++y) {
      for (int x = 0; x < kInputCells; ++x, ++cell) {
        const Eigen::Vector3f p_C =
            cube_.origin_C + cell_m * (Eigen::Vector3f(x, y, z) + Eigen::Vector3f::Constant(0.5f));
        float depth_m = 0;
        const PixelClass pixel = ClassAt(p_C, depth_m);
        const float before = (depth_m - p_C.z()) / cell_m;  // cells
        bool empty = floor_ && floor_->Height_m(p_C) < 0;
        float distance = 0, no_data = 0;
        switch (pixel) {
          case PixelClass::kSegment:
            distance = before / kCutCells;
            channels[kVolume + cell] = Quantized(std::abs(before) <= 0.5f ? 1 : 0);
            empty |= before > 0.5f;
            break;
          case PixelClass::kBackground:
          case PixelClass::kBesideOther:
            distance = 1;
            empty = true;
            break;
          case PixelClass::kOccluder:
            empty |= before > 0;
            distance = before > 0 ? 1 : 0;
            no_data = before > 0 ? 0 : 1;
            break;
          case PixelClass::kNoData:
            no_data = 0.5f;
            break;
        }
        channels[cell] = Quantized(distance);
        channels[2 * kVolume + cell] = Quantized(empty ? 1 : 0);
        channels[3 * kVolume + cell] = Quantized(no_data);
      }
    }
  }
  return channels;
}

std::vector<float> CompletionInput::ImageChannels() const {
  std::vector<float> channels(kImageChannels * kImageArea, 0);
  const Eigen::Vector3f center_C = cube_.origin_C + Eigen::Vector3f::Constant(0.5f * cube_.side_m);
  const auto relative = [&](float z_m) {
    return std::clamp((z_m - center_C.z()) / (0.5f * cube_.side_m), -kCutDepth, kCutDepth);
  };
  const float step_m = kSidePerImage * cube_.side_m / kImagePixels;
  for (int y = 0, pixel = 0; y < kImagePixels; ++y) {
    for (int x = 0; x < kImagePixels; ++x, ++pixel) {
      const float half_grid = 0.5f * (kImagePixels - 1);
      const Eigen::Vector3f p_C =
          center_C + step_m * Eigen::Vector3f(static_cast<float>(x) - half_grid,
                                              static_cast<float>(y) - half_grid, 0);
      const auto set = [&](int channel, float value) {
        channels[channel * kImageArea + pixel] = value;
      };
      float depth_m = 0;
      const PixelClass shown = ClassAt(p_C, depth_m);
      const bool on_segment = shown == PixelClass::kSegment;
      const bool is_occluder = shown == PixelClass::kOccluder;
      if (on_segment || is_occluder) set(0, relative(depth_m));
      set(1, on_segment);
      set(2, shown == PixelClass::kBackground || shown == PixelClass::kBesideOther);
      set(3, is_occluder);
      if (!floor_) continue;
      const float slope = floor_->normal_C.dot(p_C) / p_C.z();
      if (slope < 0) set(4, relative(floor_->offset_m / slope));
    }
  }
  return channels;
}

Eigen::Vector2f CompletionInput::ImagePlace(const Eigen::Vector3f& p_C) const {
  const Eigen::Vector3f center_C = cube_.origin_C + Eigen::Vector3f::Constant(0.5f * cube_.side_m);
  const Eigen::Vector2f at_center = p_C.head<2>() * (center_C.z() / p_C.z());
  return (at_center - center_C.head<2>()) / (0.5f * kSidePerImage * cube_.side_m);
}

std::array<float, kPointFacts> CompletionInput::Facts(const Eigen::Vector3f& p_C) const {
  std::array<float, kPointFacts> facts{};
  float depth_m = 0;
  const PixelClass pixel = ClassAt(p_C, depth_m);
  if (pixel == PixelClass::kSegment) {
    const float before = (depth_m - p_C.z()) / cube_.side_m;
    for (int i = 0; i < 3; ++i) facts[i] = std::clamp(kFactScales[i] * before, -1.0f, 1.0f);
  }
  facts[3] = pixel == PixelClass::kSegment;
  facts[4] = pixel == PixelClass::kBackground || pixel == PixelClass::kBesideOther;
  facts[5] = pixel == PixelClass::kOccluder;
  facts[6] = pixel == PixelClass::kNoData;
  if (floor_) {
    const float height = floor_->Height_m(p_C) / cube_.side_m;
    facts[7] = 1;
    facts[8] = height < 0;
    facts[9] = std::clamp(kFloorScale * height, -1.0f, 1.0f);
  }
  return facts;
}

bool CompletionInput::IsKnownEmpty(const Eigen::Vector3f& p_C) const {
  const float margin_m = cube_.side_m / kInputCells;
  if (floor_ && floor_->Height_m(p_C) < -margin_m) return true;
  float depth_m = 0;
  switch (ClassAt(p_C, depth_m)) {
    case PixelClass::kBackground:
      return true;
    case PixelClass::kSegment:
    case PixelClass::kOccluder:
      return p_C.z() < depth_m - margin_m;
    default:
      return false;
  }
}

void TurnChannels(std::span<const int8_t> channels, int turn, int8_t* turned) {
  TurnSlices(channels, kInputCells, turn, turned);
}

void TurnImage(std::span<const float> channels, int turn, float* turned) {
  TurnSlices(channels, kImagePixels, turn, turned);
}

void TurnPlaces(int turn, float* query) {
  for (float* place : {query, query + kImagePlace}) {
    if (turn & 1) place[0] = -place[0];
    if (turn & 2) place[1] = -place[1];
    if (turn & 4) std::swap(place[0], place[1]);
  }
}

}  // namespace pickbed::perception
