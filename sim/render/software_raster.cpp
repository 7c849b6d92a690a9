#include "sim/render/software_raster.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "scenes/camera/mesh_raster_rows.h"
#include "sim/render/gl_readback.h"

namespace pickbed::sim {
namespace {

constexpr int RoundUpToVector(int n) {
  return (n + kRasterPadding - 1) / kRasterPadding * kRasterPadding;
}

// Looks up the face values of a row's pixels: 1 / z and normal / z; red, green, blue and id.
PICKBED_WIDTHS void LookUpRow(int begin, int end, float y, const int* face_at,
                              const RasterFace* faces, float* __restrict normals,
                              float* __restrict attributes) {
  for (int x = begin; x < end; ++x) {
    const RasterFace& face = faces[face_at[x]];
    *reinterpret_cast<Four*>(normals + 4 * x) =
        *reinterpret_cast<const Four*>(face.at_origin.data()) +
        static_cast<float>(x) * *reinterpret_cast<const Four*>(face.by_column.data()) +
        y * *reinterpret_cast<const Four*>(face.by_row.data());
    *reinterpret_cast<Four*>(attributes + 4 * x) =
        *reinterpret_cast<const Four*>(face.attributes.data());
  }
}

// Shading constants of a row.
struct RowLight {
  float light_x = 0, light_y = 0, light_z = 0, ambient = 0, diffuse = 0;
  float ray_x0 = 0, ray_x = 0;  // x / z of the first column, and its change per column
  float ray_y = 0;              // y / z
};

// Lambertian shading on both sides, as in sim/render/shaders.h. Writes four bytes per pixel.
PICKBED_WIDTHS void ShadeRow(const RowLight& given, int begin, int end, const float* inverse_depth,
                             const float* normals, const float* attributes,
                             uint32_t* __restrict rgba) {
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
    const float red = std::min(1.0f, attributes[4 * x] * shade) * 255 + 0.5f;
    const float green = std::min(1.0f, attributes[4 * x + 1] * shade) * 255 + 0.5f;
    const float blue = std::min(1.0f, attributes[4 * x + 2] * shade) * 255 + 0.5f;
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

PICKBED_WIDTHS void IdRow(int begin, int end, const float* inverse_depth, const float* attributes,
                          uint16_t* __restrict ids) {
  for (int x = begin; x < end; ++x) {
    const int id = static_cast<int>(attributes[4 * x + 3]);
    ids[x] = static_cast<uint16_t>(inverse_depth[x] > 0 ? id : 0);
  }
}

}  // namespace

void CpuRaster::Draw(const RasterMesh& mesh, const RasterInstance& instance) {
  const auto& [red, green, blue] = instance.albedo;
  raster_.Draw(mesh, instance.X_CO, instance.cull_back,
               {red, green, blue, static_cast<float>(instance.id)});
}

void CpuRaster::Write(const Light& light, const Eigen::Vector3d& light_C, RenderedImage& out) {
  const int pitch = raster_.pitch();
  rgba_.resize(pitch);
  normals_.resize(4 * pitch);
  attributes_.resize(4 * pitch);
  const ImageBox& box = raster_.box();
  const Eigen::Vector3f at = light_C.cast<float>();
  RowLight row{at.x(), at.y(), at.z(), static_cast<float>(light.ambient),
               static_cast<float>(light.diffuse)};
  row.ray_x0 = static_cast<float>((box.x - camera_.cx()) / camera_.fx());
  row.ray_x = static_cast<float>(1 / camera_.fx());
  for (int y = 0; y < box.height; ++y) {
    const auto [begin, end] = raster_.Touched(y);
    if (begin >= end) continue;
    const float* inverse = raster_.InverseDepths(y);
    const int* face_at = raster_.FacesAt(y);
    DepthRow(begin, end, inverse, out.depth_m.row(box.y + y) + box.x);
    if (out.ids.empty() && out.color.empty()) continue;
    LookUpRow(begin, end, static_cast<float>(y), face_at, raster_.faces(), normals_.data(),
              attributes_.data());
    if (!out.ids.empty()) {
      IdRow(begin, end, inverse, attributes_.data(), out.ids.row(box.y + y) + box.x);
    }
    if (out.color.empty()) continue;
    row.ray_y = static_cast<float>((box.y + y - camera_.cy()) / camera_.fy());
    // Whole vectors are shaded, because the row's padding has no faces.
    const int padded = begin + RoundUpToVector(end - begin);
    ShadeRow(row, begin, padded, inverse, normals_.data(), attributes_.data(), rgba_.data());
    PackRgb(rgba_.data() + begin, out.color.row(box.y + y) + box.x + begin, end - begin);
  }
  raster_.Clean();
}

int CpuRaster::CountCovered() {
  int count = 0;
  for (int y = 0; y < raster_.box().height; ++y) {
    const float* inverse = raster_.InverseDepths(y);
    const auto [begin, end] = raster_.Touched(y);
    for (int x = begin; x < end; ++x) count += inverse[x] > 0;
  }
  raster_.Clean();
  return count;
}

void PlainDrawer::AddMesh(const std::vector<MeshLevel>& levels, const GlMesh& uploaded) {
  Mesh mesh;
  mesh.one_color = !uploaded.texture && !uploaded.colored_vertices;
  mesh.cull_back = uploaded.cull_back;
  mesh.color = uploaded.base_color;
  for (const MeshLevel& level : levels) mesh.levels.emplace_back(level.mesh);
  meshes_.push_back(std::move(mesh));
}

bool PlainDrawer::CanDraw(const RenderInstance& instance, bool color) const {
  if (!color) return true;
  const Material& material = instance.material;
  return meshes_.at(instance.mesh).one_color && material.gloss == 0 && material.grain == 0;
}

void PlainDrawer::Draw(const RenderInstance& instance, int level, const Pose& X_CO) {
  const Mesh& mesh = meshes_.at(instance.mesh);
  RasterInstance drawn{X_CO, mesh.cull_back, mesh.color, instance.id};
  for (int k = 0; k < 3; ++k) drawn.albedo[k] *= static_cast<float>(instance.material.tint[k]);
  raster_.Draw(mesh.levels.at(level), drawn);
}

}  // namespace pickbed::sim
