#include "scenes/camera/mesh_raster_rows.h"

#include <algorithm>
#include <cstdint>
#include <utility>

namespace pickbed::scenes {
namespace {

constexpr int kChunk = 8;   // px of a row that are tested at once
constexpr int kSmall = 64;  // px; up to this width and height, all products fit into 32 bits

// clang ignores the alignment of a type that `using` names.
typedef float Floats __attribute__((vector_size(4 * kChunk), aligned(4), may_alias));
typedef int Ints __attribute__((vector_size(4 * kChunk), aligned(4), may_alias));
constexpr Ints kLanes = {0, 1, 2, 3, 4, 5, 6, 7};
static_assert(kChunk <= kRasterPadding);

// A face in the box. Rows count downwards, so corners in clockwise order give a positive area.
struct Outline {
  std::array<int, 3> x, y;  // 1/256 px
  int left, right, top,
      bottom;  // columns and rows of pixel centers that it may cover, end excluded
};

PICKBED_INLINE int FirstCenterFrom(int v, int end) {
  return std::clamp((v + kSubpixels - 1) >> 8, 0, end);
}

// Pointers to a row of the target: inverse depth and index of the nearest face.
struct Pixels {
  float* inverse_depth;
  int* face_at;
};

// 1 / z of a face along a row, in 1/m. `nearest` and `farthest` are the limits over the face.
struct RowDepth {
  float at_origin, by_column, origin, nearest, farthest;
};

PICKBED_INLINE void FillChunk(const RowDepth& row, int x, const Ints& inside, int index,
                              const Pixels& pixels) {
  Floats& before = *reinterpret_cast<Floats*>(pixels.inverse_depth + x);
  Ints& face_at = *reinterpret_cast<Ints*>(pixels.face_at + x);
  const Floats columns = __builtin_convertvector(kLanes + x, Floats);
  Floats inverse = row.at_origin + row.by_column * (columns - row.origin);
  inverse = inverse < row.farthest ? Floats{} + row.farthest : inverse;
  inverse = inverse > row.nearest ? Floats{} + row.nearest : inverse;
  const Ints drawn = inside & (inverse > before);
  before = drawn ? inverse : before;
  face_at = drawn ? Ints{} + index : face_at;
}

// Edge function (Pineda, "A Parallel Algorithm for Polygon Rasterization", SIGGRAPH 1988) in
// integers; it is not negative inside the face.
struct EdgeFunction {
  int at_first, by_column, by_row;

  PICKBED_INLINE EdgeFunction(const Outline& o, int a, int b) {
    const int dx = o.x[b] - o.x[a], dy = o.y[b] - o.y[a];
    by_column = -kSubpixels * dy;
    by_row = kSubpixels * dx;
    at_first = dx * (kSubpixels * o.top - o.y[a]) - dy * (kSubpixels * o.left - o.x[a]);
    if (dy > 0 || (dy == 0 && dx < 0)) --at_first;  // a right or bottom edge is outside
  }
};

// Column at which an edge of any length crosses a row. Products of integers are exact in doubles.
struct EdgeLine {
  double at_row_0 = 0, by_row = 0, scale = 0;

  EdgeLine() = default;
  PICKBED_INLINE EdgeLine(double ax, double ay, double bx, double by) {
    const double dx = bx - ax, dy = by - ay;
    at_row_0 = dy * ax - dx * ay;
    by_row = kSubpixels * dx;
    scale = 1 / (kSubpixels * dy);
  }
  double Column(double row) const { return (at_row_0 + by_row * row) * scale; }
};

PICKBED_INLINE int CeilWithin(double v, double low, double high) {
  constexpr double kTie = 1.0 / (1u << 31);  // above rounding errors, below any nonzero distance
  const double clamped = std::min(std::max(v - kTie, low), high);
  const int whole = static_cast<int>(clamped);
  return whole + (whole < clamped);
}

// Columns of each row that a face covers, from its edges on the left and the right side.
struct LinePair {
  std::array<EdgeLine, 2> left, right;

  PICKBED_INLINE explicit LinePair(const Outline& o) {
    int lefts = 0, rights = 0;
    for (int a = 0; a < 3; ++a) {
      const int b = (a + 1) % 3;
      if (o.y[b] == o.y[a]) continue;
      const EdgeLine line(o.x[a], o.y[a], o.x[b], o.y[b]);
      if (o.y[b] > o.y[a]) {
        right[rights++] = line;
      } else {
        left[lefts++] = line;
      }
    }
    if (lefts == 1) left[1] = left[0];
    if (rights == 1) right[1] = right[0];
  }
  PICKBED_INLINE std::array<int, 2> Columns(const Outline& o, int y) const {
    return {CeilWithin(std::max(left[0].Column(y), left[1].Column(y)), o.left, o.right),
            CeilWithin(std::min(right[0].Column(y), right[1].Column(y)), o.left, o.right)};
  }
};

PICKBED_INLINE Pixels RowOf(const RasterTarget& target, int y) {
  const size_t begin = static_cast<size_t>(target.pitch) * y;
  return {target.inverse_depth + begin, target.face_at + begin};
}

PICKBED_INLINE void Touch(const Outline& o, std::array<int, 2>* touched) {
  for (int y = o.top; y < o.bottom; ++y) {
    touched[y] = {std::min(touched[y][0], o.left), std::max(touched[y][1], o.right)};
  }
}

PICKBED_INLINE void FillSmall(const Outline& o, RowDepth depth, float by_row, int index,
                              const RasterTarget& target) {
  const EdgeFunction e0(o, 0, 1), e1(o, 1, 2), e2(o, 2, 0);
  Ints row0 = e0.at_first + e0.by_column * kLanes;
  Ints row1 = e1.at_first + e1.by_column * kLanes;
  Ints row2 = e2.at_first + e2.by_column * kLanes;
  for (int y = o.top; y < o.bottom; ++y) {
    const Pixels pixels = RowOf(target, y);
    for (int x = o.left; x < o.right; x += kChunk) {
      const int step = x - o.left;
      const Ints inside = (row0 + step * e0.by_column) | (row1 + step * e1.by_column) |
                          (row2 + step * e2.by_column) | (o.right - 1 - x - kLanes);
      FillChunk(depth, x, inside >= 0, index, pixels);
    }
    row0 += e0.by_row;
    row1 += e1.by_row;
    row2 += e2.by_row;
    depth.at_origin += by_row;
  }
}

PICKBED_INLINE void FillLarge(const Outline& o, RowDepth depth, float by_row, int index,
                              const RasterTarget& target) {
  const LinePair lines(o);
  const float at_top = depth.at_origin;
  for (int y = o.top; y < o.bottom; ++y) {
    const auto [low, high] = lines.Columns(o, y);
    depth.at_origin = at_top + by_row * static_cast<float>(y - o.top);
    for (int x = low; x < high; x += kChunk) {
      FillChunk(depth, x, kLanes < high - x, index, RowOf(target, y));
    }
  }
}

// Computes the face's attributes as planes over the box. A flat face has the same normal
// everywhere.
PICKBED_INLINE void FillPlanes(const ScreenVertices& v, const std::array<int, 3>& t,
                               const float* face_normal, RasterFace& face) {
  const float ux = v.x[t[1]] - v.x[t[0]], uy = v.y[t[1]] - v.y[t[0]];
  const float wx = v.x[t[2]] - v.x[t[0]], wy = v.y[t[2]] - v.y[t[0]];
  const float scale = 1 / (ux * wy - uy * wx);
  const Four a = *reinterpret_cast<const Four*>(v.attributes + kAttributes * t[0]);
  const Four du = *reinterpret_cast<const Four*>(v.attributes + kAttributes * t[1]) - a;
  const Four dw = *reinterpret_cast<const Four*>(v.attributes + kAttributes * t[2]) - a;
  Four by_column = du * (wy * scale) - dw * (uy * scale);
  Four by_row = dw * (ux * scale) - du * (wx * scale);
  Four at_origin = a - by_column * v.x[t[0]] - by_row * v.y[t[0]];
  if (face_normal) {
    const Four one_normal = *reinterpret_cast<const Four*>(face_normal);  // 1, normal
    at_origin = at_origin[0] * one_normal;
    by_column = by_column[0] * one_normal;
    by_row = by_row[0] * one_normal;
  }
  *reinterpret_cast<Four*>(face.at_origin.data()) = at_origin;
  *reinterpret_cast<Four*>(face.by_column.data()) = by_column;
  *reinterpret_cast<Four*>(face.by_row.data()) = by_row;
}

// Computes the outline of a face. Returns false if the face is not visible.
PICKBED_INLINE bool OutlineOf(const ScreenVertices& v, const std::array<int, 3>& t, bool cull_back,
                              const RasterTarget& target, Outline& o) {
  o.x = {v.snapped_x[t[0]], v.snapped_x[t[1]], v.snapped_x[t[2]]};
  o.y = {v.snapped_y[t[0]], v.snapped_y[t[1]], v.snapped_y[t[2]]};
  const int64_t area =
      int64_t{o.x[1] - o.x[0]} * (o.y[2] - o.y[0]) - int64_t{o.y[1] - o.y[0]} * (o.x[2] - o.x[0]);
  if (area == 0 || (area > 0 && cull_back)) return false;
  if (area < 0) {
    std::swap(o.x[1], o.x[2]);
    std::swap(o.y[1], o.y[2]);
  }
  o.left = FirstCenterFrom(std::min({o.x[0], o.x[1], o.x[2]}), target.width);
  o.right = FirstCenterFrom(std::max({o.x[0], o.x[1], o.x[2]}), target.width);
  o.top = FirstCenterFrom(std::min({o.y[0], o.y[1], o.y[2]}), target.height);
  o.bottom = FirstCenterFrom(std::max({o.y[0], o.y[1], o.y[2]}), target.height);
  return o.left < o.right && o.top < o.bottom;
}

PICKBED_INLINE bool IsSmall(const Outline& o) {
  const auto [x0, x1] = std::minmax({o.x[0], o.x[1], o.x[2]});
  const auto [y0, y1] = std::minmax({o.y[0], o.y[1], o.y[2]});
  return x1 - x0 <= kSmall * kSubpixels && y1 - y0 <= kSmall * kSubpixels;
}

}  // namespace

PICKBED_WIDTHS int FillFaces(const ScreenVertices& given, const RasterTriangles& triangles,
                             const std::array<float, 4>& attributes,
                             const RasterTarget& given_target, int index, RasterFace* faces) {
  const ScreenVertices v = given;
  const RasterTarget target = given_target;
  for (int i = 0; i < triangles.count; ++i) {
    const std::array<int, 3> t = triangles.corners[i];
    Outline outline;
    if (!OutlineOf(v, t, triangles.cull_back, target, outline)) continue;
    RasterFace& face = faces[index];
    FillPlanes(v, t, triangles.normals ? triangles.normals + kAttributes * i : nullptr, face);
    face.attributes = attributes;
    const float a = v.attributes[kAttributes * t[0]], b = v.attributes[kAttributes * t[1]],
                c = v.attributes[kAttributes * t[2]];
    const RowDepth depth{a + face.by_row[0] * (static_cast<float>(outline.top) - v.y[t[0]]),
                         face.by_column[0], v.x[t[0]], std::max(std::max(a, b), c),
                         std::min(std::min(a, b), c)};
    if (IsSmall(outline)) {
      FillSmall(outline, depth, face.by_row[0], index, target);
    } else {
      FillLarge(outline, depth, face.by_row[0], index, target);
    }
    Touch(outline, target.touched);
    ++index;
  }
  return index;
}

}  // namespace pickbed::scenes
