#include "sim/render/picture.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>

#include "scenes/base/parallel.h"
#include "scenes/base/random.h"
#include "scenes/image/srgb.h"

namespace pickbed::sim {
namespace {

using Eigen::Vector3f;

// The key light is a point light far above the bin, to the left of and behind the camera of most
// scenarios.
const Eigen::Vector3d kKeyLight_W{-1.1, -1.3, 2.6};
constexpr double kShadowSoftness_m = 0.012;
constexpr float kOcclusionRadius_m = 0.045f;
constexpr int kOcclusionSamples = 20;
constexpr int kOcclusionStep = 2;  // px between the points at which the occlusion is computed
constexpr int kOcclusionTile = 4;  // the pattern of samples repeats after this number of points
constexpr double kTableMargin_m = 0.55;
// Id of the table in the internal passes. Scenes have fewer instances.
constexpr uint16_t kTableId = 0xffff;

const Vector3f kBinColor{0.045f, 0.070f, 0.115f};
const Vector3f kTableColor{0.36f, 0.34f, 0.31f};
const Vector3f kCardboard{0.42f, 0.27f, 0.14f};
const Vector3f kAluminium{0.50f, 0.51f, 0.53f};
const Vector3f kSteel{0.44f, 0.43f, 0.41f};
// Neither blue nor orange, which mark right and wrong poses in overlays.
const std::array<Vector3f, 6> kPlastics{
    Vector3f{0.030f, 0.26f, 0.13f}, Vector3f{0.42f, 0.022f, 0.020f},
    Vector3f{0.74f, 0.70f, 0.60f},  Vector3f{0.055f, 0.058f, 0.065f},
    Vector3f{0.50f, 0.40f, 0.08f},  Vector3f{0.30f, 0.32f, 0.34f}};
constexpr float kDarkestMetal = 0.26f;  // luminance; a darker metal looks like paint

float Linear(uint8_t value) { return LinearOfSrgb(value / 255.0f); }

Vector3f LinearOf(const Rgb8& c) { return {Linear(c.r), Linear(c.g), Linear(c.b)}; }

float Luminance(const Vector3f& c) { return 0.2126f * c.x() + 0.7152f * c.y() + 0.0722f * c.z(); }

// Power of a cosine for highlights.
float Highlight(float cosine, float exponent) {
  constexpr float kNothing = 0.8f;  // below it a highlight is weaker than 1e-5
  return cosine < kNothing ? 0 : std::pow(cosine, exponent);
}

// Brightness of the surroundings in a direction: a bright ceiling with a large lamp, grey walls and
// a dark floor.
float Surroundings(const Vector3f& direction_W, const Vector3f& to_key_W) {
  const float up = direction_W.z();
  const float sky = up > 0 ? 0.42f + 0.75f * up : std::max(0.14f, 0.42f + 0.9f * up);
  const float lamp = std::clamp((direction_W.dot(to_key_W) - 0.80f) / 0.12f, 0.0f, 1.0f);
  return sky + 1.6f * lamp * lamp * (3 - 2 * lamp);
}

// Surface at one sample of the picture.
struct Surface {
  Vector3f color = Vector3f::Zero();
  Vector3f normal_W = Vector3f::UnitZ();
  Vector3f to_camera_W = Vector3f::UnitZ();
  Vector3f to_key_W = Vector3f::UnitZ();
  float direct = 0;     // light of the lamp that arrives, times the cosine
  float occlusion = 1;  // share of the surroundings that is visible
  Finish finish = Finish::kMatte;
};

// Diffuse light of the lamp and the surroundings, a reflection of both, and the highlight of the
// lamp (Blinn, "Models of Light Reflection for Computer Synthesized Pictures", SIGGRAPH 1977) with
// the Fresnel term of Schlick ("An Inexpensive BRDF Model for Physically-based Rendering", 1994).
Vector3f Shade(const Surface& s) {
  const float facing = std::clamp(s.normal_W.dot(s.to_camera_W), 0.0f, 1.0f);
  const Vector3f mirrored_W = 2 * facing * s.normal_W - s.to_camera_W;
  const float sky = 0.36f + 0.22f * s.normal_W.z();
  const Vector3f diffuse = s.color * (sky * s.occlusion + 0.95f * s.direct);
  if (s.finish == Finish::kMatte) return diffuse;
  const float halfway = std::max(0.0f, s.normal_W.dot((s.to_key_W + s.to_camera_W).normalized()));
  const float reflected = s.occlusion * Surroundings(mirrored_W, s.to_key_W);
  const float away = 1 - facing, grazing = away * away * away * away * away;
  if (s.finish == Finish::kMetal) {
    const Vector3f fresnel = s.color + (Vector3f::Ones() - s.color) * grazing;
    return 0.30f * diffuse +
           fresnel * (0.62f * reflected + 0.9f * s.direct * Highlight(halfway, 60));
  }
  const float fresnel = 0.04f + 0.5f * grazing;
  return diffuse +
         Vector3f::Constant(fresnel * reflected + 0.35f * s.direct * Highlight(halfway, 90));
}

uint8_t Displayed(float linear) {
  constexpr int kSteps = 4095;
  static const std::array<uint8_t, kSteps + 1> table = [] {
    std::array<uint8_t, kSteps + 1> srgb;
    for (int i = 0; i <= kSteps; ++i) {
      srgb[i] =
          static_cast<uint8_t>(std::lround(255 * SrgbOfLinear(static_cast<float>(i) / kSteps)));
    }
    return srgb;
  }();
  const float shown = 1 - std::exp(-1.55f * std::max(0.0f, linear));
  return table[static_cast<int>(kSteps * shown + 0.5f)];
}

// Directions in the half space z > 0 with lengths in 0..1, more of them short.
std::array<Vector3f, kOcclusionSamples> OcclusionKernel() {
  std::array<Vector3f, kOcclusionSamples> kernel;
  constexpr float kGolden = 2.39996323f;
  for (int i = 0; i < kOcclusionSamples; ++i) {
    const float share = (i + 0.5f) / kOcclusionSamples;
    const float z = std::sqrt(1 - share), radius = std::sqrt(share);
    const float length = 0.12f + 0.88f * ((i * 7) % kOcclusionSamples) / kOcclusionSamples;
    kernel[i] =
        length * Vector3f{radius * std::cos(kGolden * i), radius * std::sin(kGolden * i), z};
  }
  return kernel;
}

// Share of the surroundings that each pixel sees, estimated in the depth image ("Screen-space
// ambient occlusion", Mittring, "Finding Next Gen: CryEngine 2", SIGGRAPH 2007 courses).
// normals_C are unit vectors; pixels without depth get 1.
Image<float> AmbientOcclusion(const CameraIntrinsics& k, const Image<float>& depth_m,
                              const Image<Vector3f>& normals_C, int threads) {
  const std::array<Vector3f, kOcclusionSamples> kernel = OcclusionKernel();
  const auto fx = static_cast<float>(k.fx()), fy = static_cast<float>(k.fy());
  const auto cx = static_cast<float>(k.cx()), cy = static_cast<float>(k.cy());
  const auto raw_at = [&](int u, int v) {
    const float z = depth_m(u, v);
    const Vector3f p_C{(u - cx) / fx * z, (v - cy) / fy * z, z};
    const Vector3f n = normals_C(u, v);
    const Vector3f helper = std::abs(n.z()) < 0.9f ? Vector3f::UnitZ() : Vector3f::UnitX();
    const Vector3f a = n.cross(helper).normalized(), b = n.cross(a);
    const int cell = (u / kOcclusionStep % kOcclusionTile) +
                     kOcclusionTile * (v / kOcclusionStep % kOcclusionTile);
    const float angle = 6.2831853f * ((cell * 7) % 16) / 16;
    const float c = std::cos(angle), s = std::sin(angle);
    float hidden = 0;
    for (const Vector3f& direction : kernel) {
      const float x = c * direction.x() - s * direction.y();
      const float y = s * direction.x() + c * direction.y();
      const Vector3f q = p_C + kOcclusionRadius_m * (x * a + y * b + direction.z() * n);
      if (q.z() <= 0) continue;
      const float qx = fx * q.x() / q.z() + cx + 0.5f, qy = fy * q.y() / q.z() + cy + 0.5f;
      if (!(qx >= 0 && qy >= 0 && qx < depth_m.width() && qy < depth_m.height())) continue;
      const float there = depth_m(static_cast<int>(qx), static_cast<int>(qy));
      const float before = q.z() - there;
      if (there <= 0 || before < 0.0008f) continue;
      // Surfaces far before the sample are not near the point and hide little of it.
      hidden += std::clamp(1.6f - before / kOcclusionRadius_m, 0.0f, 1.0f);
    }
    return std::pow(1 - hidden / kOcclusionSamples, 1.6f);
  };
  const auto rows = (depth_m.height() + kOcclusionStep - 1) / kOcclusionStep;
  const auto columns = (depth_m.width() + kOcclusionStep - 1) / kOcclusionStep;
  Image<float> raw(columns, rows, 1.0f);
  ForRanges(rows, threads, [&](int begin, int end) {
    for (int j = begin; j < end; ++j) {
      for (int i = 0; i < columns; ++i) {
        const int u = i * kOcclusionStep, v = j * kOcclusionStep;
        if (depth_m(u, v) > 0) raw(i, j) = raw_at(u, v);
      }
    }
  });
  // The mean over one tile of the pattern removes its noise. Only points on the same surface count.
  Image<float> smooth(depth_m.width(), depth_m.height(), 1.0f);
  ForRanges(depth_m.height(), threads, [&](int begin, int end) {
    for (int v = begin; v < end; ++v) {
      for (int u = 0; u < depth_m.width(); ++u) {
        const float z = depth_m(u, v);
        if (z <= 0) continue;
        const Vector3f& n = normals_C(u, v);
        const int first_i = (u + 1) / kOcclusionStep - kOcclusionTile / 2;
        const int first_j = (v + 1) / kOcclusionStep - kOcclusionTile / 2;
        float sum = 0, count = 0;
        for (int j = first_j; j < first_j + kOcclusionTile; ++j) {
          for (int i = first_i; i < first_i + kOcclusionTile; ++i) {
            if (!raw.Contains(i, j)) continue;
            const int x = i * kOcclusionStep, y = j * kOcclusionStep;
            if (std::abs(depth_m(x, y) - z) > 0.01f || n.dot(normals_C(x, y)) < 0.7f) continue;
            sum += raw(i, j);
            ++count;
          }
        }
        smooth(u, v) = count > 0 ? sum / count : raw_at(u, v);
      }
    }
  });
  return smooth;
}

// Share of the lamp's light that is not shadowed at each pixel, smooth at the edges of shadows. All
// images have one pixel per pixel of the picture. `key_C` is the lamp in the camera frame.
Image<float> ShadowFactors(const CameraIntrinsics& k, const RenderedImage& thin,
                           const Image<Rgb8>& lit, const Vector3f& key_C, int threads) {
  constexpr float kFacing = 0.08f;  // surfaces that face the lamp less are dark anyway
  const int width = thin.depth_m.width(), height = thin.depth_m.height();
  const auto fx = static_cast<float>(k.fx()), fy = static_cast<float>(k.fy());
  const auto cx = static_cast<float>(k.cx()), cy = static_cast<float>(k.cy());
  Image<float> sharp(width, height, 1.0f);
  ForRanges(height, threads, [&](int begin, int end) {
    for (int v = begin; v < end; ++v) {
      for (int u = 0; u < width; ++u) {
        const float z = thin.depth_m(u, v);
        if (z <= 0) continue;
        const Vector3f p_C{(u - cx) / fx * z, (v - cy) / fy * z, z};
        const float cosine = thin.normals_C(u, v).dot((key_C - p_C).normalized());
        if (cosine < kFacing) continue;
        const Rgb8 own = thin.color(u, v), bright = lit(u, v);
        const float full = cosine * std::max({own.r, own.g, own.b, uint8_t{1}});
        sharp(u, v) = std::min(1.0f, std::max({bright.r, bright.g, bright.b}) / full);
      }
    }
  });
  // The filter of the shadow map has few samples, which leaves stripes.
  constexpr int kReach = 4;
  Image<float> smooth = sharp;
  ForRanges(height, threads, [&](int begin, int end) {
    for (int v = begin; v < end; ++v) {
      for (int u = 0; u < width; ++u) {
        const float z = thin.depth_m(u, v), own = sharp(u, v);
        if (z <= 0) continue;
        bool even = true;
        for (const int d : {-kReach, kReach}) {
          even = even && (!sharp.Contains(u + d, v) || std::abs(sharp(u + d, v) - own) < 0.02f) &&
                 (!sharp.Contains(u, v + d) || std::abs(sharp(u, v + d) - own) < 0.02f);
        }
        if (even) continue;
        float sum = 0, count = 0;
        for (int y = v - kReach; y <= v + kReach; y += 2) {
          for (int x = u - kReach; x <= u + kReach; x += 2) {
            if (!sharp.Contains(x, y) || thin.ids(x, y) != thin.ids(u, v)) continue;
            if (thin.normals_C(x, y).dot(thin.normals_C(u, v)) < 0.95f) continue;
            sum += sharp(x, y);
            ++count;
          }
        }
        smooth(u, v) = sum / count;
      }
    }
  });
  return smooth;
}

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

PictureMaterial PictureMaterialOf(const ObjectModel& object) {
  constexpr double kCardboard_kgpm3 = 450, kMetal_kgpm3 = 2600, kSteel_kgpm3 = 4500;
  const TriangleMesh& mesh = object.mesh_O;
  const double density_kgpm3 =
      object.mass.volume_m3 > 0 ? object.mass.mass_kg / object.mass.volume_m3 : 1000;
  PictureMaterial material;
  if (density_kgpm3 < kCardboard_kgpm3) {
    material = {Finish::kMatte, kCardboard};
  } else if (density_kgpm3 < kMetal_kgpm3) {
    const uint64_t name = HashBytes(object.name.data(), object.name.size());
    material = {Finish::kPlastic, kPlastics[name % kPlastics.size()]};
  } else {
    material = {Finish::kMetal, density_kgpm3 < kSteel_kgpm3 ? kAluminium : kSteel};
  }
  if (!mesh.colors.empty() || !mesh.texture.empty()) {
    material.color.setConstant(-1);
  } else if (mesh.base_color != TriangleMesh().base_color) {
    // The colors of meshes are made for weaker light.
    material.color = (material.finish == Finish::kMetal ? 1.0f : 0.65f) * LinearOf(mesh.base_color);
    if (material.finish == Finish::kMetal) {
      const float luminance = Luminance(material.color);
      if (luminance > 0) {
        material.color *= std::max(1.0f, kDarkestMetal / luminance);
        material.color = material.color.cwiseMin(1.0f);
      } else {
        material.color.setConstant(kDarkestMetal);  // black has no hue to keep
      }
    }
  }
  return material;
}

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
    Surface s;
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
