#include "sim/render/picture.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "scenes/base/parallel.h"
#include "sim/render/image_lighting.h"
#include "sim/render/picture_shading.h"

namespace pickbed::sim {
namespace {

using Eigen::Vector3f;

// The key light is a point light far above the bin, to the left of and behind the camera of most
// scenarios.
const Eigen::Vector3d kKeyLight_W{-1.1, -1.3, 2.6};
constexpr double kShadowSoftness_m = 0.012;
constexpr double kTableMargin_m = 0.55;
// Id of the table in the internal passes. Scenes have fewer instances.
constexpr uint16_t kTableId = 0xffff;

const Vector3f kBinColor{0.045f, 0.070f, 0.115f};
const Vector3f kTableColor{0.36f, 0.34f, 0.31f};

// Returns the camera that shows the same view with `factor` times the pixels per axis.
Camera Enlarged(const Camera& camera, int factor) {
  const CameraIntrinsics& k = camera.intrinsics;
  const double center = 0.5 * (factor - 1);  // pixel (0, 0) is the center of the first pixel
  return {{k.width() * factor, k.height() * factor, k.fx() * factor, k.fy() * factor,
           k.cx() * factor + center, k.cy() * factor + center},
          camera.X_WC()};
}

// Returns the camera of every `step`-th pixel of an image, see Thinned().
Camera ThinnedCamera(const Camera& camera, int step) {
  const CameraIntrinsics& k = camera.intrinsics;
  return {{k.width() / step, k.height() / step, k.fx() / step, k.fy() / step,
           (k.cx() - step / 2) / step, (k.cy() - step / 2) / step},
          camera.X_WC()};
}

template <typename T>
Image<T> Thinned(const Image<T>& image, int step) {
  if (step == 1) return image;
  Image<T> thin(image.width() / step, image.height() / step, image(0, 0));
  for (int v = 0; v < thin.height(); ++v) {
    for (int u = 0; u < thin.width(); ++u) {
      thin(u, v) = image(u * step + step / 2, v * step + step / 2);
    }
  }
  return thin;
}

// A square at z = 0 of two triangles.
TriangleMesh Square(double side_m) {
  const double h = 0.5 * side_m;
  TriangleMesh mesh;
  mesh.vertices = {{-h, -h, 0}, {h, -h, 0}, {h, h, 0}, {-h, h, 0}};
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  return mesh;
}

// Background of rays that hit nothing: a wall that darkens upwards.
Vector3f Backdrop(float share_of_height) {
  return Vector3f{0.40f, 0.41f, 0.43f} * (0.55f + 0.45f * share_of_height);
}

}  // namespace

void PictureOptions::Validate() const {
  const auto within = [](const char* name, int value, int low, int high) {
    if (value >= low && value <= high) return;
    throw std::logic_error(fmt::format("PictureOptions::{} is {}", name, value));
  };
  within("scale", scale, 1, 8);
  within("samples", samples, 1, 4);
  within("threads", threads, 1, 1024);
}

PictureRenderer::PictureRenderer(SceneRenderer& renderer, const ObjectSet& objects)
    : renderer_(renderer), objects_(objects) {}

int PictureRenderer::TableMesh(double side_m) {
  const auto [table, is_new] = tables_.try_emplace(side_m, -1);
  if (is_new) table->second = renderer_.renderer().AddMesh(Square(side_m));
  return table->second;
}

Picture PictureRenderer::Render(const Scene& scene, const Camera& camera,
                                const PictureOptions& options,
                                std::span<const PictureInstance> more) {
  options.Validate();
  Renderer& renderer = renderer_.renderer();
  std::vector<RenderInstance> instances = renderer_.InstancesOf(scene);
  const Bounds bin = renderer.MeshBoundsOf(instances.back().mesh);
  const double side_m =
      2 * kTableMargin_m + std::max(bin.max.x() - bin.min.x(), bin.max.y() - bin.min.y());
  // A little lower than the bin, so that the two surfaces do not mix.
  const Eigen::Vector3d table_W{0, 0, bin.min.z() - 5e-4};
  for (const PictureInstance& added : more) instances.push_back(added.instance);
  instances.push_back({TableMesh(side_m), Pose(Eigen::Translation3d(table_W)), kTableId});

  // Materials by id.
  std::map<uint16_t, PictureMaterial> materials{{0, {Finish::kPlastic, kBinColor}},
                                                {kTableId, {Finish::kMatte, kTableColor}}};
  for (const PosedObject& object : scene.objects) {
    PictureMaterial material = PictureMaterialOf(*objects_.at(object.object));
    // Instances differ a little in brightness, so that neighbors can be distinguished.
    const auto id = static_cast<uint16_t>(object.instance + 1);
    material.color *= 0.92f + 0.16f * static_cast<float>((id * 7) % 11) / 10;
    materials[id] = material;
  }
  for (const PictureInstance& added : more) materials[added.instance.id] = added.material;

  const int factor = options.scale * options.samples;
  const Camera fine = Enlarged(camera, factor);
  const RenderOutputs all{.color = true, .ids = true, .normals = true};
  const RenderedImage base = renderer.Render(fine, instances, Light{kKeyLight_W, 1, 0, false}, all);
  Picture picture;
  picture.camera = Enlarged(camera, options.scale);
  // Shadows and occlusion are smooth, so one value per pixel of the picture is enough.
  const Camera thin_camera = ThinnedCamera(fine, options.samples);
  const RenderedImage thin{Thinned(base.color, options.samples),
                           Thinned(base.depth_m, options.samples),
                           Thinned(base.ids, options.samples),
                           Thinned(base.normals_C, options.samples),
                           {}};
  const RenderedImage lit =
      renderer.Render(thin_camera, instances, Light{kKeyLight_W, 0, 1, true, kShadowSoftness_m},
                      RenderOutputs{.color = true, .ids = false});
  const Image<float> shadow =
      ShadowFactors(thin_camera.intrinsics, thin, lit.color,
                    (camera.X_CW() * kKeyLight_W).cast<float>(), options.threads);
  const Image<float> occlusion =
      AmbientOcclusion(thin_camera.intrinsics, thin.depth_m, thin.normals_C, options.threads);
  picture.ids = thin.ids;
  for (uint16_t& id : picture.ids.pixels()) id = id == kTableId ? 0 : id;

  const Eigen::Matrix3f R_WC = camera.X_WC().linear().cast<float>();
  const Vector3f eye_W = camera.X_WC().translation().cast<float>();
  const Vector3f key_W = kKeyLight_W.cast<float>();
  const CameraIntrinsics& k = fine.intrinsics;
  const auto fx = static_cast<float>(k.fx()), fy = static_cast<float>(k.fy());
  const auto cx = static_cast<float>(k.cx()), cy = static_cast<float>(k.cy());
  // Returns the pixel of the picture whose shadow and occlusion a sample gets: its own, or a
  // neighbor on the same surface.
  const auto pixel_of = [&](int u, int v) {
    constexpr float kSameSurfaceCos = 0.9f;
    const int x = u / options.samples, y = v / options.samples;
    for (const auto& [dx, dy] : {std::pair{0, 0}, {-1, 0}, {1, 0}, {0, -1}, {0, 1}}) {
      if (!thin.ids.Contains(x + dx, y + dy) || thin.ids(x + dx, y + dy) != base.ids(u, v))
        continue;
      if (thin.normals_C(x + dx, y + dy).dot(base.normals_C(u, v)) < kSameSurfaceCos) continue;
      return std::pair{x + dx, y + dy};
    }
    return std::pair{x, y};
  };
  // Returns the mean light of the samples in a square of `side` samples, shaded as one surface.
  const auto linear_of = [&](int u, int v, int side) -> Vector3f {
    const float z = base.depth_m(u, v);
    const float center = 0.5f * (side - 1);
    const Vector3f ray_C{(u + center - cx) / fx, (v + center - cy) / fy, 1};
    if (z <= 0) return Backdrop(static_cast<float>(v) / k.height());
    const PictureMaterial& material = materials.at(base.ids(u, v));
    PictureSurface s;
    s.color = material.color;
    if (material.color.x() < 0) {
      s.color.setZero();
      for (int j = v; j < v + side; ++j) {
        for (int i = u; i < u + side; ++i) s.color += LinearOf(base.color(i, j)) / (side * side);
      }
    }
    const Vector3f p_W = eye_W + R_WC * (z * ray_C);
    s.normal_W = R_WC * base.normals_C(u, v);
    s.to_camera_W = (eye_W - p_W).normalized();
    s.to_key_W = (key_W - p_W).normalized();
    const auto [x, y] = pixel_of(u, v);
    s.direct = shadow(x, y) * std::max(0.0f, s.normal_W.dot(s.to_key_W));
    s.occlusion = occlusion(x, y);
    s.finish = material.finish;
    // Limiting each sample keeps edges against highlights smooth.
    return Shade(s).cwiseMin(1.5f);
  };
  // Returns whether the samples of a pixel are on one smooth surface, so that one is enough.
  const auto is_smooth = [&](int u, int v) {
    constexpr float kSmoothCos = 0.998f;
    for (int j = v; j < v + options.samples; ++j) {
      for (int i = u; i < u + options.samples; ++i) {
        if (base.ids(i, j) != base.ids(u, v) ||
            (base.depth_m(i, j) > 0) != (base.depth_m(u, v) > 0))
          return false;
        if (base.normals_C(i, j).dot(base.normals_C(u, v)) < kSmoothCos) return false;
      }
    }
    return true;
  };
  const int width = picture.camera.intrinsics.width(), height = picture.camera.intrinsics.height();
  picture.color = Image<Rgb8>(width, height);
  ForRanges(height, options.threads, [&](int begin, int end) {
    for (int y = begin; y < end; ++y) {
      for (int x = 0; x < width; ++x) {
        const int u = x * options.samples, v = y * options.samples;
        Vector3f mean = Vector3f::Zero();
        if (is_smooth(u, v)) {
          mean = linear_of(u, v, options.samples);
        } else {
          for (int j = 0; j < options.samples; ++j) {
            for (int i = 0; i < options.samples; ++i) mean += linear_of(u + i, v + j, 1);
          }
          mean /= static_cast<float>(options.samples * options.samples);
        }
        picture.color(x, y) = {Displayed(mean.x()), Displayed(mean.y()), Displayed(mean.z())};
      }
    }
  });
  return picture;
}

}  // namespace pickbed::sim
