#include "sim/sensor/image_geometry.h"

#include <algorithm>
#include <cmath>

#include "scenes/camera/mesh_raster_rows.h"

namespace pickbed::sim {
namespace {

// Loops over a row are separate functions, so that PICKBED_WIDTHS compiles them for several vector
// widths.

PICKBED_WIDTHS void Invert(const float* depth_m, int n, float* inverse) {
  for (int x = 0; x < n; ++x) {
    const float z = depth_m[x];
    const float inverse_z = 1.0f / std::max(z, 1e-6f);
    inverse[x] = z > 0 ? inverse_z : 0.0f;
  }
}

PICKBED_WIDTHS void Extrapolate(const float* nearer, const float* farther, int n, float* out) {
  for (int x = 0; x < n; ++x) out[x] = 2 * nearer[x] - farther[x];
}

// arccos for 0 <= c <= 1 with an error up to 7e-5 (Abramowitz and Stegun 4.4.45).
inline float ArcCosine(float c) {
  return std::sqrt(1.0f - c) *
         (1.5707288f + c * (-0.2121144f + c * (0.0742610f + c * -0.0187293f)));
}

PICKBED_WIDTHS void Slants(const float* above, const float* row, const float* below,
                           const float* ray_x, float ray_y, float fx, float fy, int n,
                           float* slant_rad) {
  for (int x = 0; x < n; ++x) {
    const float q = row[x];
    const float right = row[x + 1] - q, left = q - row[x - 1];
    const float down = below[x] - q, up = q - above[x];
    const float a = fx * (std::abs(right) < std::abs(left) ? right : left);
    const float b = fy * (std::abs(down) < std::abs(up) ? down : up);
    const float c = q - a * ray_x[x] - b * ray_y;
    const float normal2 = a * a + b * b + c * c;
    const float ray2 = 1.0f + ray_x[x] * ray_x[x] + ray_y * ray_y;
    const float cosine = q / std::sqrt(std::max(normal2 * ray2, 1e-20f));
    slant_rad[x] = ArcCosine(std::min(cosine, 1.0f));
  }
}

PICKBED_WIDTHS void Edges(const float* above, const float* row, const float* below, int n,
                          float step_m, uint8_t* is_edge) {
  for (int x = 0; x < n; ++x) {
    const float z = row[x];
    const float across = std::max(std::abs(above[x] - z), std::abs(below[x] - z));
    const float along = std::max(std::abs(row[x - 1] - z), std::abs(row[x + 1] - z));
    is_edge[x] = std::max(across, along) > step_m ? 1 : 0;
  }
}

// Column 0 is `width` columns left of the image. Columns farther out are clamped to the two ends.
PICKBED_WIDTHS void Columns(const float* depth_m, int width, float focal_times_baseline,
                            float* disparity, float* column) {
  const float magnitude = std::abs(focal_times_baseline);
  const float sign = focal_times_baseline < 0 ? 1.0f : -1.0f;
  for (int x = 0; x < width; ++x) {
    disparity[x] = magnitude / std::max(depth_m[x], 1e-6f);
    const float c = static_cast<float>(width + x) + sign * disparity[x];
    column[x] = std::min(std::max(c, 0.0f), static_cast<float>(3 * width));
  }
}

// Sets 1 where the gap between pixels x and x + 1 separates two surfaces. Its depth step is an
// edge, and the disparity does not continue on either side. (On a steep surface it continues with
// the same sign and at least half the rate.) Both inputs are read from x - 1 to x + 2.
PICKBED_WIDTHS void Gaps(const float* depth_m, const float* disparity, int n, float step_m,
                         float* is_gap) {
  for (int x = 0; x < n; ++x) {
    const float before = disparity[x] - disparity[x - 1];
    const float across = disparity[x + 1] - disparity[x];
    const float after = disparity[x + 2] - disparity[x + 1];
    const float like = std::max(before * across, after * across);
    const float step = std::abs(depth_m[x + 1] - depth_m[x]);
    is_gap[x] = step > step_m ? (2 * like < across * across ? 1.0f : 0.0f) : 0.0f;
  }
}

// Each column belongs to the half-open interval that contains it, so adjacent intervals share none.
// `column` is read one element to either side, and `is_gap` one to the left.
PICKBED_WIDTHS void Stretches(const float* depth_m, const float* column, const float* is_gap, int n,
                              int* first, int* last) {
  for (int x = 0; x < n; ++x) {
    const float z = depth_m[x], c = column[x];
    const float center_left = 0.5f * (column[x - 1] + c), center_right = 0.5f * (c + column[x + 1]);
    const float left = is_gap[x - 1] > 0 ? c - 0.5f : center_left;
    const float right = is_gap[x] > 0 ? c + 0.5f : center_right;
    const int a = static_cast<int>(std::max(std::min(left, right), 0.0f));
    const int b = static_cast<int>(std::max(left, right));
    first[x] = a + 1;
    last[x] = z > 0 ? b : a;
  }
}

// `nearest` has an element for each whole column up to 3 * width.
PICKBED_WIDTHS void Shadows(const float* depth_m, const float* disparity, const float* column,
                            const float* nearest, int width, uint8_t* __restrict is_shadow) {
  const auto end = static_cast<float>(3 * width);
  for (int x = 0; x < width; ++x) {
    const float c = column[x];
    const float before = nearest[static_cast<int>(c + 0.5f)] - disparity[x];
    const float inside = c > 0.0f ? (c < end ? before : 0.0f) : 0.0f;
    const float seen = depth_m[x] > 0.0f ? inside : 0.0f;
    is_shadow[x] = seen > 1.0f ? 1 : 0;
  }
}

}  // namespace

SlantRows::SlantRows(const Image<float>& depth_m, const CameraIntrinsics& intrinsics)
    : depth_m_(depth_m), intrinsics_(intrinsics), outside_(depth_m.width() + 2) {
  const int width = depth_m.width();
  for (std::vector<float>& row : inverse_) row.resize(width + 2);
  slant_rad_.resize(width);
  ray_x_.resize(width);
  for (int x = 0; x < width; ++x) {
    ray_x_[x] = static_cast<float>((x - intrinsics.cx()) / intrinsics.fx());
  }
  if (depth_m.height() > 0) LoadInverseDepth(0);
}

void SlantRows::LoadInverseDepth(int y) {
  std::vector<float>& row = inverse_[y % 3];
  const int width = depth_m_.width();
  Invert(depth_m_.row(y), width, row.data() + 1);
  if (width < 2) return;
  // The border is extrapolated linearly, so its difference equals the difference to the other side.
  row[0] = 2 * row[1] - row[2];
  row[width + 1] = 2 * row[width] - row[width - 1];
}

const float* SlantRows::Row(int y) {
  const int width = depth_m_.width(), height = depth_m_.height();
  if (y + 1 < height) LoadInverseDepth(y + 1);
  const float* row = inverse_[y % 3].data() + 1;
  const float* above = y > 0 ? inverse_[(y + 2) % 3].data() + 1 : nullptr;
  const float* below = y + 1 < height ? inverse_[(y + 1) % 3].data() + 1 : nullptr;
  if (!above || !below) {
    const float* inside = above ? above : (below ? below : row);
    Extrapolate(row, inside, width, outside_.data() + 1);
    (above ? below : above) = outside_.data() + 1;
    if (!below) below = row;  // an image of one row
  }
  const auto ray_y = static_cast<float>((y - intrinsics_.cy()) / intrinsics_.fy());
  Slants(above, row, below, ray_x_.data(), ray_y, static_cast<float>(intrinsics_.fx()),
         static_cast<float>(intrinsics_.fy()), width, slant_rad_.data());
  return slant_rad_.data();
}

void EdgeRow(const Image<float>& depth_m, int y, float step_m, uint8_t* is_edge) {
  const int width = depth_m.width();
  const float* row = depth_m.row(y);
  const float* above = y > 0 ? depth_m.row(y - 1) : row;
  const float* below = y + 1 < depth_m.height() ? depth_m.row(y + 1) : row;
  if (width > 2) Edges(above + 1, row + 1, below + 1, width - 2, step_m, is_edge + 1);
  for (const int x : {0, width - 1}) {
    const float z = row[x];
    const float left = row[std::max(x - 1, 0)], right = row[std::min(x + 1, width - 1)];
    is_edge[x] = std::abs(left - z) > step_m || std::abs(right - z) > step_m ||
                 std::abs(above[x] - z) > step_m || std::abs(below[x] - z) > step_m;
  }
}

ShadowRows::ShadowRows(int width, double fx, double baseline_m, float edge_step_m)
    : width_(width),
      focal_times_baseline_(static_cast<float>(fx * baseline_m)),
      edge_step_m_(edge_step_m),
      nearest_(3 * static_cast<size_t>(width) + 2),
      disparity_(width),
      column_(width),
      is_gap_(width, 1.0f),
      first_(width),
      last_(width) {}

void ShadowRows::Row(const float* depth_m, uint8_t* is_shadow) {
  std::fill(nearest_.begin(), nearest_.end(), 0.0f);
  Columns(depth_m, width_, focal_times_baseline_, disparity_.data(), column_.data());
  if (width_ > 3) {
    for (const int x : {0, width_ - 2}) {
      is_gap_[x] = std::abs(depth_m[x + 1] - depth_m[x]) > edge_step_m_ ? 1.0f : 0.0f;
    }
    Gaps(depth_m + 1, disparity_.data() + 1, width_ - 3, edge_step_m_, is_gap_.data() + 1);
    Stretches(depth_m + 1, column_.data() + 1, is_gap_.data() + 1, width_ - 2, first_.data() + 1,
              last_.data() + 1);
  }
  for (int x = 0; x<width_; x += width_> 3 ? width_ - 1 : 1) {
    first_[x] = static_cast<int>(std::max(column_[x] - 0.5f, 0.0f)) + 1;
    last_[x] = depth_m[x] > 0 ? static_cast<int>(column_[x] + 0.5f) : 0;
  }
  for (int x = 0; x < width_; ++x) {
    for (int k = first_[x]; k <= last_[x]; ++k) nearest_[k] = std::max(nearest_[k], disparity_[x]);
  }
  Shadows(depth_m, disparity_.data(), column_.data(), nearest_.data(), width_, is_shadow);
}

}  // namespace pickbed::sim
