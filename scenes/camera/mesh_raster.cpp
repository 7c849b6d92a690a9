#include "scenes/camera/mesh_raster.h"

#include <algorithm>

#include "scenes/camera/mesh_raster_rows.h"

namespace pickbed::scenes {
namespace {

constexpr float kFarOut = 1 << 29;  // 1/256 px, outside every image

struct Projection {
  std::array<float, 12> X_CO_rows;
  float fx, fy, cx, cy;  // px, relative to the box
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

// Rounds to integers in units of 1/256 px.
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

void FaceRaster::Begin(const CameraIntrinsics& camera, const ImageBox& box) {
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

void FaceRaster::Project(const RasterMesh& mesh, const Pose& X_CO) {
  Projection p;
  for (int i = 0; i < 12; ++i) p.X_CO_rows[i] = static_cast<float>(X_CO(i / 4, i % 4));
  p.fx = static_cast<float>(camera_.fx());
  p.fy = static_cast<float>(camera_.fy());
  p.cx = static_cast<float>(camera_.cx() - box_.x);
  p.cy = static_cast<float>(camera_.cy() - box_.y);
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

void FaceRaster::Draw(const RasterMesh& mesh, const Pose& X_CO, bool cull_back,
                      const std::array<float, 4>& attributes) {
  Project(mesh, X_CO);
  const size_t room = face_count_ + mesh.triangles.size();
  if (faces_.size() < room) faces_.resize(std::max(room, 2 * faces_.size()));
  const ScreenVertices vertices{screen_x_.data(), screen_y_.data(), snapped_x_.data(),
                                snapped_y_.data(), over_depth_.data()};
  const RasterTriangles triangles{mesh.triangles.data(), static_cast<int>(mesh.triangles.size()),
                                  cull_back, mesh.flat ? face_normals_.data() : nullptr};
  const RasterTarget target{box_.width,      box_.height,    pitch_, inverse_depth_.data(),
                            face_at_.data(), touched_.data()};
  face_count_ = FillFaces(vertices, triangles, attributes, target, face_count_, faces_.data());
}

// Clears all touched pixels, because the next picture may have another pitch.
void FaceRaster::Clean() {
  for (int y = 0; y < box_.height; ++y) {
    const auto [begin, end] = touched_[y];
    if (begin >= end) continue;
    const size_t row = static_cast<size_t>(pitch_) * y;
    std::fill_n(inverse_depth_.begin() + row + begin, end - begin, 0.0f);
    std::fill_n(face_at_.begin() + row + begin, end - begin, 0);
  }
}

}  // namespace pickbed::scenes
