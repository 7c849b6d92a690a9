#include "scenes/shape_families/solid_program.h"

#include <algorithm>
#include <bit>
#include <cmath>

#define PICKBED_INLINE inline __attribute__((always_inline))

namespace pickbed::scenes {

// Loops over the points of a block are vectorized. Products are not contracted, so that all clones
// give the same bits.
constexpr int kBlock = 64;
using Lanes = float[kBlock];
constexpr int kAlignment = 64;  // bytes of the widest vector

struct alignas(kAlignment) SolidBlock {
  Lanes values[kSolidValues];
  Lanes points[kSolidPoints][3];
  Lanes x, y, z;  // of the current primitive
};

namespace {

PICKBED_INLINE float Max(float a, float b) { return a > b ? a : b; }
PICKBED_INLINE float Min(float a, float b) { return a < b ? a : b; }
PICKBED_INLINE float Abs(float a) { return a < 0 ? -a : a; }
PICKBED_INLINE float Length(float a, float b) { return __builtin_sqrtf(a * a + b * b); }

// Distance to a product of two sets with distances a and b.
PICKBED_INLINE float Product(float a, float b) {
  return Min(Max(a, b), 0.0f) + Length(Max(a, 0.0f), Max(b, 0.0f));
}

// Base-2 logarithm by the series of atanh; relative error under 1e-7 for positive normal numbers.
PICKBED_INLINE float Log2(float x) {
  const int32_t bits = std::bit_cast<int32_t>(x);
  const int32_t shifted = bits - 0x3f3504f3;  // sqrt(1/2), so that the mantissa is around 1
  const float exponent = static_cast<float>(shifted >> 23);
  const float m = std::bit_cast<float>((shifted & 0x007fffff) + 0x3f3504f3);
  const float t = (m - 1) / (m + 1), s = t * t;
  return exponent + t * (2.885390082f + s * (0.961796694f + s * (0.577078016f + s * 0.412198583f)));
}

// 2^x by its Taylor series around the nearest integer; relative error under 1e-6.
PICKBED_INLINE float Exp2(float x) {
  x = Max(Min(x, 126.0f), -126.0f);
  const int32_t n = static_cast<int32_t>(x + 512.5f) - 512;
  const float f = x - static_cast<float>(n);
  const float series =
      1 + f * (0.693147181f +
               f * (0.240226507f +
                    f * (0.0555041087f +
                         f * (0.00961812911f + f * (0.00133335581f + f * 0.000154035304f)))));
  return series * std::bit_cast<float>((n + 127) << 23);
}

// x^e for x >= 0 and e > 0.
PICKBED_INLINE float Power(float x, float e) { return Exp2(e * Log2(Max(x, 1e-37f))); }

PICKBED_INLINE void Box(const SolidInstruction& op, SolidBlock& b, Lanes& out) {
  const float r = op.v[3], hx = op.v[0] - r, hy = op.v[1] - r, hz = op.v[2] - r;
  for (int i = 0; i < kBlock; ++i) {
    const float x = Abs(b.x[i]) - hx, y = Abs(b.y[i]) - hy, z = Abs(b.z[i]) - hz;
    const float ox = Max(x, 0.0f), oy = Max(y, 0.0f), oz = Max(z, 0.0f);
    out[i] = Min(Max(x, Max(y, z)), 0.0f) + __builtin_sqrtf(ox * ox + oy * oy + oz * oz) - r;
  }
}

PICKBED_INLINE void Cylinder(const SolidInstruction& op, SolidBlock& b, Lanes& out) {
  const float r = op.v[2], radius = op.v[0] - r, half = op.v[1] - r;
  for (int i = 0; i < kBlock; ++i) {
    out[i] = Product(Length(b.x[i], b.y[i]) - radius, Abs(b.z[i]) - half) - r;
  }
}

PICKBED_INLINE void Capsule(const SolidInstruction& op, SolidBlock& b, Lanes& out) {
  for (int i = 0; i < kBlock; ++i) {
    const float z = Max(Abs(b.z[i]) - op.v[1], 0.0f);
    out[i] = __builtin_sqrtf(b.x[i] * b.x[i] + b.y[i] * b.y[i] + z * z) - op.v[0];
  }
}

PICKBED_INLINE void Torus(const SolidInstruction& op, SolidBlock& b, Lanes& out) {
  for (int i = 0; i < kBlock; ++i) {
    out[i] = Length(Length(b.x[i], b.y[i]) - op.v[0], b.z[i]) - op.v[1];
  }
}

// A superquadric is the unit ball of a norm, because its exponents 2/e are at least 1. The norm
// changes by at most 1/slope per mm. Far away, the box around it is a better bound.
PICKBED_INLINE void Superquadric(const SolidInstruction& op, SolidBlock& b, Lanes& out) {
  const float n_xy = op.v[3], n_z = op.v[4], slope = op.v[5];
  const float inverse_z = 1 / n_z, ratio = n_z / n_xy;
  for (int i = 0; i < kBlock; ++i) {
    const float ax = Abs(b.x[i]), ay = Abs(b.y[i]), az = Abs(b.z[i]);
    const float x = ax / op.v[0], y = ay / op.v[1], z = az / op.v[2];
    const float largest = Max(Max(Max(x, y), z), 1e-6f), inverse = 1 / largest;
    const float section = Power(x * inverse, n_xy) + Power(y * inverse, n_xy);
    const float sum = Power(section, ratio) + Power(z * inverse, n_z);
    const float norm = largest * Power(sum, inverse_z);
    const float box = Product(Product(ax - op.v[0], ay - op.v[1]), az - op.v[2]);
    out[i] = Max((norm - 1) * slope, box);
  }
}

// Signed distance in the plane to a closed polygon. With `revolved`, edges on the axis u = 0 are
// not part of the surface.
PICKBED_INLINE void Polygon(const SolidInstruction& op, const SolidProgram& program, const float* u,
                            const float* v, bool revolved, Lanes& out) {
  Lanes sign;
  for (int i = 0; i < kBlock; ++i) out[i] = 1e12f, sign[i] = 1;
  const Eigen::Vector2f* corners = program.outlines.data() + op.first;
  for (int k = 0, last = op.count - 1; k < op.count; last = k++) {
    const float ax = corners[last].x(), ay = corners[last].y();
    const float ex = corners[k].x() - ax, ey = corners[k].y() - ay, by = corners[k].y();
    if (revolved && ax == 0 && ex == 0) continue;
    const float inverse = 1 / Max(ex * ex + ey * ey, 1e-12f);
    const float slope = ey == 0 ? 0 : ex / ey;
    for (int i = 0; i < kBlock; ++i) {
      const float wx = u[i] - ax, wy = v[i] - ay;
      const float s = Max(Min((wx * ex + wy * ey) * inverse, 1.0f), 0.0f);
      const float dx = wx - s * ex, dy = wy - s * ey;
      out[i] = Min(out[i], dx * dx + dy * dy);
      const bool crossed = (ay > v[i]) != (by > v[i]) && wx < wy * slope;
      sign[i] = crossed ? -sign[i] : sign[i];
    }
  }
  for (int i = 0; i < kBlock; ++i) out[i] = sign[i] * __builtin_sqrtf(out[i]);
}

PICKBED_INLINE void Extruded(const SolidInstruction& op, const SolidProgram& program, SolidBlock& b,
                             Lanes& out) {
  Polygon(op, program, b.x, b.y, false, out);
  for (int i = 0; i < kBlock; ++i) out[i] = Product(out[i], Abs(b.z[i]) - op.v[0]);
}

PICKBED_INLINE void Revolved(const SolidInstruction& op, const SolidProgram& program, SolidBlock& b,
                             Lanes& out) {
  for (int i = 0; i < kBlock; ++i) b.x[i] = Length(b.x[i], b.y[i]);
  Polygon(op, program, b.x, b.z, true, out);
}

PICKBED_INLINE void Planes(const SolidInstruction& op, const SolidProgram& program, SolidBlock& b,
                           Lanes& out) {
  for (int i = 0; i < kBlock; ++i) out[i] = -1e12f;
  for (int k = op.first; k < op.first + op.count; ++k) {
    const Eigen::Vector4f& n = program.planes[k];
    const float nx = n.x(), ny = n.y(), nz = n.z(), offset = n.w();
    for (int i = 0; i < kBlock; ++i) {
      out[i] = Max(out[i], nx * b.x[i] + ny * b.y[i] + nz * b.z[i] - offset);
    }
  }
}

PICKBED_INLINE void Sector(const SolidInstruction& op, SolidBlock& b, Lanes& out) {
  const float c = op.v[0], s = op.v[1];
  for (int i = 0; i < kBlock; ++i) {
    const float x = b.x[i], y = Abs(b.y[i]);
    const float along = Max(x * c + y * s, 0.0f);
    const float distance = Length(x - along * c, y - along * s);
    out[i] = x * s - y * c > 0 ? -distance : distance;
  }
}

// Takes the copy whose axis is nearest in direction to the point.
PICKBED_INLINE void FoldCopies(const SolidInstruction& op, const SolidProgram& program,
                               const SolidBlock& b, Lanes (&to)[3]) {
  for (int i = 0; i < kBlock; ++i) to[0][i] = -1e12f;
  for (int k = op.first; k < op.first + op.count; ++k) {
    const float c = program.outlines[k].x(), s = program.outlines[k].y();
    for (int i = 0; i < kBlock; ++i) {
      const float along = b.x[i] * c + b.y[i] * s, across = Abs(b.y[i] * c - b.x[i] * s);
      const bool nearer = along > to[0][i];
      to[0][i] = nearer ? along : to[0][i];
      to[1][i] = nearer ? across : to[1][i];
    }
  }
  for (int i = 0; i < kBlock; ++i) to[2][i] = b.z[i];
}

PICKBED_INLINE void FoldMirrors(const SolidInstruction& op, const SolidBlock& b, Lanes (&to)[3]) {
  const Lanes* from[3] = {&b.x, &b.y, &b.z};
  for (int axis = 0; axis < 3; ++axis) {
    const bool mirrored = op.v[axis] > 0;
    for (int i = 0; i < kBlock; ++i) {
      const float p = (*from[axis])[i];
      to[axis][i] = mirrored ? Abs(p) : p;
    }
  }
}

PICKBED_INLINE void ToOwnFrame(const SolidInstruction& op, const Lanes (&p)[3], SolidBlock& b) {
  const std::array<float, 9>& R = op.R;
  const bool turned = R[0] != 1 || R[4] != 1 || R[8] != 1;
  if (turned) {
    for (int i = 0; i < kBlock; ++i) {
      b.x[i] = R[0] * p[0][i] + R[1] * p[1][i] + R[2] * p[2][i] + op.t[0];
      b.y[i] = R[3] * p[0][i] + R[4] * p[1][i] + R[5] * p[2][i] + op.t[1];
      b.z[i] = R[6] * p[0][i] + R[7] * p[1][i] + R[8] * p[2][i] + op.t[2];
    }
  } else {
    for (int i = 0; i < kBlock; ++i) {
      b.x[i] = p[0][i] + op.t[0];
      b.y[i] = p[1][i] + op.t[1];
      b.z[i] = p[2][i] + op.t[2];
    }
  }
}

// Polynomial smooth minimum of https://iquilezles.org/articles/smin.
PICKBED_INLINE void SmoothUnion(float width, const Lanes& b, Lanes& a) {
  const float inverse = 1 / width, quarter = 0.25f * width;
  for (int i = 0; i < kBlock; ++i) {
    const float h = Max(width - Abs(a[i] - b[i]), 0.0f) * inverse;
    a[i] = Min(a[i], b[i]) - h * h * quarter;
  }
}

constexpr bool IsPrimitive(SolidOp op) { return op <= SolidOp::kSector; }

}  // namespace

// Evaluates the points of block.points[0]; the result is block.values[0].
__attribute__((target_clones("arch=x86-64-v4", "avx2", "default"))) void RunSolidBlock(
    const SolidProgram& program, SolidBlock& block) {
  int value = -1, point = 0;
  for (const SolidInstruction& op : program.instructions) {
    if (IsPrimitive(op.op)) {
      ++value;
      ToOwnFrame(op, block.points[point], block);
    }
    Lanes& out = block.values[std::max(value, 0)];
    switch (op.op) {
      case SolidOp::kBox:
        Box(op, block, out);
        break;
      case SolidOp::kCylinder:
        Cylinder(op, block, out);
        break;
      case SolidOp::kCapsule:
        Capsule(op, block, out);
        break;
      case SolidOp::kTorus:
        Torus(op, block, out);
        break;
      case SolidOp::kSuperquadric:
        Superquadric(op, block, out);
        break;
      case SolidOp::kExtruded:
        Extruded(op, program, block, out);
        break;
      case SolidOp::kRevolved:
        Revolved(op, program, block, out);
        break;
      case SolidOp::kPlanes:
        Planes(op, program, block, out);
        break;
      case SolidOp::kSector:
        Sector(op, block, out);
        break;
      case SolidOp::kUnion: {
        Lanes& a = block.values[--value];
        for (int i = 0; i < kBlock; ++i) a[i] = Min(a[i], out[i]);
        break;
      }
      case SolidOp::kCut: {
        Lanes& a = block.values[--value];
        for (int i = 0; i < kBlock; ++i) a[i] = Max(a[i], -out[i]);
        break;
      }
      case SolidOp::kIntersect: {
        Lanes& a = block.values[--value];
        for (int i = 0; i < kBlock; ++i) a[i] = Max(a[i], out[i]);
        break;
      }
      case SolidOp::kSmoothUnion:
        SmoothUnion(op.v[0], out, block.values[--value]);
        break;
      case SolidOp::kOffset:
        for (int i = 0; i < kBlock; ++i) out[i] -= op.v[0];
        break;
      case SolidOp::kShell: {
        const float half = 0.5f * op.v[0];
        for (int i = 0; i < kBlock; ++i) out[i] = Abs(out[i] + half) - half;
        break;
      }
      case SolidOp::kPushCopies:
        ToOwnFrame(op, block.points[point], block);
        FoldCopies(op, program, block, block.points[++point]);
        break;
      case SolidOp::kPushMirror:
        ToOwnFrame(op, block.points[point], block);
        FoldMirrors(op, block, block.points[++point]);
        break;
      case SolidOp::kPopPoints:
        --point;
        break;
    }
  }
}

bool SolidProgram::IsValid() const {
  int value = 0, point = 1;
  for (const SolidInstruction& op : instructions) {
    if (IsPrimitive(op.op)) {
      ++value;
    } else if (op.op <= SolidOp::kSmoothUnion) {
      if (--value < 1) return false;
    } else if (op.op == SolidOp::kPushCopies || op.op == SolidOp::kPushMirror) {
      ++point;
    } else if (op.op == SolidOp::kPopPoints) {
      if (--point < 1) return false;
    } else if (value < 1) {
      return false;
    }
    if (value > kSolidValues || point > kSolidPoints) return false;
  }
  return value == 1 && point == 1;
}

void RunSolidProgram(const SolidProgram& program, const Eigen::Vector3f& offset_mm,
                     std::span<const Eigen::Vector3f> points_m, std::span<float> distances_mm) {
  SolidBlock block;
  for (size_t begin = 0; begin < points_m.size(); begin += kBlock) {
    const size_t count = std::min<size_t>(kBlock, points_m.size() - begin);
    for (int i = 0; i < kBlock; ++i) {
      // The last block repeats its last point.
      const Eigen::Vector3f& p = points_m[begin + std::min<size_t>(i, count - 1)];
      for (int axis = 0; axis < 3; ++axis) {
        block.points[0][axis][i] = 1e3f * p[axis] + offset_mm[axis];
      }
    }
    RunSolidBlock(program, block);
    std::copy_n(block.values[0], count, distances_mm.begin() + begin);
  }
}

}  // namespace pickbed::scenes
