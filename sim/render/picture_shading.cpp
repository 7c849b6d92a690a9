#include "sim/render/picture_shading.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "scenes/base/random.h"
#include "scenes/image/srgb.h"

namespace pickbed::sim {
namespace {

using Eigen::Vector3f;

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

}  // namespace

Vector3f LinearOf(const Rgb8& c) { return {Linear(c.r), Linear(c.g), Linear(c.b)}; }

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

Vector3f Shade(const PictureSurface& s) {
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

}  // namespace pickbed::sim
