#include "sim/cpu_raster.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "sim/gl_readback.h"
#include "sim/raster_vectors.h"

namespace pickbed {
namespace {

constexpr float kFarOut = 1 << 29;  // 1/256 px, beyond any image

constexpr int RoundUpToVector(int n) {
  return (n + kRasterPadding - 1) / kRasterPadding * kRasterPadding;
}

struct Projection {
  std::array<float, 12> X_CO_rows;
  float fx, fy, cx, cy;  // px, of the box
};

PICKBED_WIDTHS void ProjectVertices(const Projection& given, int n, const float* x_O,
                                    const float* y_O, const float* z_O, float* __restrict x_px,
                                    float* __restrict y_px, float* __restrict over_depth) {
  const Projection p = given;
  const std::array<float, 12>& m = p.X_CO_rows;
  for (int i = 0; i < n; ++i) {
    const float x = m[0] * x_O[i] + m[1] * y_O[i] + m[2] * z_O[i] + m[3];
    const float y = m[4] * x_O[i] + m[5] * y_O[i] + m[6] * z_O[i] + m[7];
    const float z = m[8] * x_O[i] + m[9] * y_O[i] + m[10] * z_O[i] + m[11];
    const float inverse = 1 / z;
    x_px[i] = p.fx * x * inverse + p.cx;
    y_px[i] = p.fy * y * inverse + p.cy;
    over_depth[kAttributes * i] = inverse;
  }
}

// To whole numbers of 1/256 px.
PICKBED_WIDTHS void Snap(int n, const float* px, int* __restrict snapped) {
  for (int i = 0; i < n; ++i) {
    const float scaled = std::min(std::max(px[i] * kSubpixels, -kFarOut), kFarOut);
    snapped[i] = static_cast<int>(scaled + (scaled < 0 ? -0.5f : 0.5f));
  }
}

PICKBED_WIDTHS void TurnNormals(const std::array<float, 12>& given, int n, const float* x_O,
                                const float* y_O, const float* z_O, float* __restrict over_depth) {
  const std::array<float, 12> m = given;
  for (int i = 0; i < n; ++i) {
    float* out = over_depth + kAttributes * i;
    const float inverse = out[0];
    out[1] = inverse * (m[0] * x_O[i] + m[1] * y_O[i] + m[2] * z_O[i]);
    out[2] = inverse * (m[4] * x_O[i] + m[5] * y_O[i] + m[6] * z_O[i]);
    out[3] = inverse * (m[8] * x_O[i] + m[9] * y_O[i] + m[10] * z_O[i]);
  }
}

// What the faces of a row's pixels say there: 1 / z and normal / z; red, green, blue and id.
PICKBED_WIDTHS void LookUpRow(int begin, int end, float y, const int* face_at,
                              const RasterFace* faces, float* __restrict normals,
                              float* __restrict looks) {
  for (int x = begin; x < end; ++x) {
    const RasterFace& face = faces[face_at[x]];
    *reinterpret_cast<Four*>(normals + 4 * x) =
        *reinterpret_cast<const Four*>(face.at_origin.data()) +
        static_cast<float>(x) * *reinterpret_cast<const Four*>(face.by_column.data()) +
        y * *reinterpret_cast<const Four*>(face.by_row.data());
    *reinterpret_cast<Four*>(looks + 4 * x) = *reinterpret_cast<const Four*>(face.look.data());
  }
}

// Constants of the shading of a row.
struct RowLight {
  float light_x = 0, light_y = 0, light_z = 0, ambient = 0, diffuse = 0;
  float ray_x0 = 0, ray_x = 0;  // x / z of the first column, its change by a column
  float ray_y = 0;              // y / z
};

// Lambert's law on both sides, as in sim/shaders.h; four bytes a pixel.
PICKBED_WIDTHS void ShadeRow(const RowLight& given, int begin, int end, const float* inverse_depth,
                             const float* normals, const float* looks, uint32_t* __restrict rgba) {
  const RowLight r = given;
  for (int x = begin; x < end; ++x) {
    const float nx = normals[4 * x + 1], ny = normals[4 * x + 2], nz = normals[4 * x + 3];
    const float z = 1 / std::max(inverse_depth[x], 1e-9f);
    const float px = (r.ray_x0 + r.ray_x * static_cast<float>(x)) * z, py = r.ray_y * z;
    const float lx = r.light_x - px, ly = r.light_y - py, lz = r.light_z - z;
    const float to_light = nx * lx + ny * ly + nz * lz;
    const float lit = nx * px + ny * py + nz * z > 0 ? -to_light : to_light;
    const float squares = (nx * nx + ny * ny + nz * nz) * (lx * lx + ly * ly + lz * lz);
    const float cosine = std::max(lit, 0.0f) / std::sqrt(std::max(squares, 1e-30f));
    const float shade = r.ambient + r.diffuse * cosine;
    const float red = std::min(1.0f, looks[4 * x] * shade) * 255 + 0.5f;
    const float green = std::min(1.0f, looks[4 * x + 1] * shade) * 255 + 0.5f;
    const float blue = std::min(1.0f, looks[4 * x + 2] * shade) * 255 + 0.5f;
    const int packed =
        static_cast<int>(red) | static_cast<int>(green) << 8 | static_cast<int>(blue) << 16;
    rgba[x] = inverse_depth[x] > 0 ? packed : 0;
  }
}

PICKBED_WIDTHS void DepthRow(int begin, int end, const float* inverse_depth,
                             float* __restrict depth_m) {
  for (int x = begin; x < end; ++x) {
    const float inverse = inverse_depth[x];
    depth_m[x] = inverse > 0 ? 1 / inverse : 0;
  }
}

PICKBED_WIDTHS void IdRow(int begin, int end, const float* inverse_depth, const float* looks,
                          uint16_t* __restrict ids) {
  for (int x = begin; x < end; ++x) {
    const int id = static_cast<int>(looks[4 * x + 3]);
    ids[x] = static_cast<uint16_t>(inverse_depth[x] > 0 ? id : 0);
  }
}

}  // namespace

RasterMesh::RasterMesh(const TriangleMesh& mesh) : flat(mesh.normals.empty()) {
  const auto append = [](const Eigen::Vector3d& from, std::array<std::vector<float>, 3>& to) {
    for (int k = 0; k < 3; ++k) to[k].push_back(static_cast<float>(from[k]));
  };
  for (const Eigen::Vector3d& p : mesh.vertices) append(p, position_O);
  for (const Eigen::Vector3d& n : mesh.normals) append(n, normal_O);
  for (const Eigen::Vector3i& t : mesh.triangles) {
    triangles.push_back({t[0], t[1], t[2]});
    if (!flat) continue;
    const Eigen::Vector3d& a = mesh.vertices[t[0]];
    append((mesh.vertices[t[1]] - a).cross(mesh.vertices[t[2]] - a).normalized(), normal_O);
  }
}

void CpuRaster::Begin(const CameraIntrinsics& camera, const ImageBox& box) {
  camera_ = camera;
  box_ = box;
  pitch_ = box.width + kRasterPadding;
  const size_t pixels = static_cast<size_t>(pitch_) * box.height;
  if (inverse_depth_.size() < pixels) {
    inverse_depth_.resize(pixels, 0.0f);
    face_at_.resize(pixels, 0);
  }
  touched_.assign(box.height, {box.width, 0});
  face_count_ = 0;
}

void CpuRaster::Project(const RasterMesh& mesh, const Pose& X_CO) {
  Projection p;
  for (int i = 0; i < 12; ++i) p.X_CO_rows[i] = static_cast<float>(X_CO(i / 4, i % 4));
  p.fx = static_cast<float>(camera_.fx);
  p.fy = static_cast<float>(camera_.fy);
  p.cx = static_cast<float>(camera_.cx - box_.x);
  p.cy = static_cast<float>(camera_.cy - box_.y);
  const size_t count = mesh.position_O[0].size();
  if (screen_x_.size() < count) {
    screen_x_.resize(count);
    screen_y_.resize(count);
    snapped_x_.resize(count);
    snapped_y_.resize(count);
    over_depth_.resize(kAttributes * count);
  }
  ProjectVertices(p, static_cast<int>(count), mesh.position_O[0].data(), mesh.position_O[1].data(),
                  mesh.position_O[2].data(), screen_x_.data(), screen_y_.data(),
                  over_depth_.data());
  Snap(static_cast<int>(count), screen_x_.data(), snapped_x_.data());
  Snap(static_cast<int>(count), screen_y_.data(), snapped_y_.data());
  std::vector<float>& turned = mesh.flat ? face_normals_ : over_depth_;
  if (mesh.flat) turned.assign(kAttributes * mesh.triangles.size(), 1.0f);
  TurnNormals(p.X_CO_rows, static_cast<int>(mesh.normal_O[0].size()), mesh.normal_O[0].data(),
              mesh.normal_O[1].data(), mesh.normal_O[2].data(), turned.data());
}

void CpuRaster::Draw(const RasterMesh& mesh, const RasterInstance& instance) {
  Project(mesh, instance.X_CO);
  const size_t room = face_count_ + mesh.triangles.size();
  if (faces_.size() < room) faces_.resize(std::max(room, 2 * faces_.size()));
  const auto& [red, green, blue] = instance.albedo;
  const ScreenVertices vertices{screen_x_.data(), screen_y_.data(), snapped_x_.data(),
                                snapped_y_.data(), over_depth_.data()};
  const RasterTriangles triangles{mesh.triangles.data(), static_cast<int>(mesh.triangles.size()),
                                  instance.cull_back, mesh.flat ? face_normals_.data() : nullptr};
  const RasterTarget target{box_.width,      box_.height,    pitch_, inverse_depth_.data(),
                            face_at_.data(), touched_.data()};
  face_count_ = FillFaces(vertices, triangles, {red, green, blue, static_cast<float>(instance.id)},
                          target, face_count_, faces_.data());
}

void CpuRaster::Write(const Light& light, const Eigen::Vector3d& light_C, RenderedImage& out) {
  rgba_.resize(pitch_);
  normals_.resize(4 * pitch_);
  looks_.resize(4 * pitch_);
  const Eigen::Vector3f at = light_C.cast<float>();
  RowLight row{at.x(), at.y(), at.z(), static_cast<float>(light.ambient),
               static_cast<float>(light.diffuse)};
  row.ray_x0 = static_cast<float>((box_.x - camera_.cx) / camera_.fx);
  row.ray_x = static_cast<float>(1 / camera_.fx);
  for (int y = 0; y < box_.height; ++y) {
    const auto [begin, end] = touched_[y];
    if (begin >= end) continue;
    const float* inverse = inverse_depth_.data() + static_cast<size_t>(pitch_) * y;
    const int* face_at = face_at_.data() + static_cast<size_t>(pitch_) * y;
    DepthRow(begin, end, inverse, out.depth_m.row(box_.y + y) + box_.x);
    if (out.ids.empty() && out.color.empty()) continue;
    LookUpRow(begin, end, static_cast<float>(y), face_at, faces_.data(), normals_.data(),
              looks_.data());
    if (!out.ids.empty()) {
      IdRow(begin, end, inverse, looks_.data(), out.ids.row(box_.y + y) + box_.x);
    }
    if (out.color.empty()) continue;
    row.ray_y = static_cast<float>((box_.y + y - camera_.cy) / camera_.fy);
    // Whole vectors: the row's padding holds no faces.
    const int padded = begin + RoundUpToVector(end - begin);
    ShadeRow(row, begin, padded, inverse, normals_.data(), looks_.data(), rgba_.data());
    PackRgb(rgba_.data() + begin, out.color.row(box_.y + y) + box_.x + begin, end - begin);
  }
  Clean();
}

int CpuRaster::CountCovered() {
  int count = 0;
  for (int y = 0; y < box_.height; ++y) {
    const float* inverse = inverse_depth_.data() + static_cast<size_t>(pitch_) * y;
    for (int x = touched_[y][0]; x < touched_[y][1]; ++x) count += inverse[x] > 0;
  }
  Clean();
  return count;
}

// Leaves nothing for the next picture, which may have another pitch.
void CpuRaster::Clean() {
  for (int y = 0; y < box_.height; ++y) {
    const auto [begin, end] = touched_[y];
    if (begin >= end) continue;
    const size_t row = static_cast<size_t>(pitch_) * y;
    std::fill_n(inverse_depth_.begin() + row + begin, end - begin, 0.0f);
    std::fill_n(face_at_.begin() + row + begin, end - begin, 0);
  }
}

}  // namespace pickbed
