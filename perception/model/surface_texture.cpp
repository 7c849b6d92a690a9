#include "perception/model/surface_texture.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "perception/model/model_points.h"
#include "scenes/base/math.h"

namespace pickbed::perception {
namespace {

constexpr double kPixelDiameters = 1.0 / 60;  // footprint of a pixel on the object
constexpr int kContinuousSteps = 36;

Eigen::Vector3f ToVector(const Rgb8& color) {
  return {static_cast<float>(color.r), static_cast<float>(color.g), static_cast<float>(color.b)};
}

// Barycentric weights of p in triangle t; the first corner if the triangle has no area.
Eigen::Vector3d Barycentric(const TriangleMesh& mesh, const Eigen::Vector3i& t,
                            const Eigen::Vector3d& p) {
  const Eigen::Vector3d a = mesh.vertices[t.x()];
  const Eigen::Vector3d ab = mesh.vertices[t.y()] - a, ac = mesh.vertices[t.z()] - a, ap = p - a;
  const Eigen::Vector3d n = ab.cross(ac);
  const double squared = n.squaredNorm();
  if (!(squared > 0)) return {1, 0, 0};
  const double v = ap.cross(ac).dot(n) / squared, w = ab.cross(ap).dot(n) / squared;
  return {1 - v - w, v, w};
}

// Mean side of a texel on the surface.
double TexelSize_m(const TriangleMesh& mesh) {
  double texels = 0;
  for (const Eigen::Vector3i& t : mesh.triangles) {
    const Eigen::Vector2d a = mesh.uvs[t.x()];
    const Eigen::Vector2d ab = mesh.uvs[t.y()] - a, ac = mesh.uvs[t.z()] - a;
    texels += 0.5 * std::abs(ab.x() * ac.y() - ab.y() * ac.x());
  }
  texels *= static_cast<double>(mesh.texture.width()) * mesh.texture.height();
  return texels > 0 ? std::sqrt(SurfaceArea(mesh) / texels) : 0;
}

// Mean over a square of side 2 * reach + 1 texels; v = 0 is the top row.
Eigen::Vector3f TextureMean(const Image<Rgb8>& texture, const Eigen::Vector2d& uv, int reach) {
  const auto texel = [](double share, int size) {
    return std::clamp(static_cast<int>(std::floor((share - std::floor(share)) * size)), 0,
                      size - 1);
  };
  const int x = texel(uv.x(), texture.width()), y = texel(uv.y(), texture.height());
  const int x0 = std::max(0, x - reach), x1 = std::min(texture.width() - 1, x + reach);
  const int y0 = std::max(0, y - reach), y1 = std::min(texture.height() - 1, y + reach);
  Eigen::Vector3f sum = Eigen::Vector3f::Zero();
  for (int row = y0; row <= y1; ++row) {
    for (int column = x0; column <= x1; ++column) sum += ToVector(texture(column, row));
  }
  return sum / static_cast<float>((x1 - x0 + 1) * (y1 - y0 + 1));
}

// Moments of the value pairs (a, b) of one channel.
struct Moments {
  double n = 0, a = 0, b = 0, aa = 0, bb = 0, ab = 0;

  void Add(double of_a, double of_b) {
    ++n;
    a += of_a;
    b += of_b;
    aa += of_a * of_a;
    bb += of_b * of_b;
    ab += of_a * of_b;
  }
  // Sums of squares and products about the means.
  double SquaresA() const { return n > 0 ? aa - a / n * a : 0; }
  double SquaresB() const { return n > 0 ? bb - b / n * b : 0; }
  double Products() const { return n > 0 ? ab - a / n * b : 0; }
};

// The light differs between the sides of an object, so each side is compared about its own mean.
constexpr int kSides = 6;
int SideOf(const Eigen::Vector3f& normal_O) {
  int axis = 0;
  normal_O.cwiseAbs().maxCoeff(&axis);
  return 2 * axis + (normal_O[axis] < 0 ? 1 : 0);
}

// Model and image colors at the visible points, by side and channel.
struct ColorSamples {
  int points = 0;
  std::array<std::array<Moments, 3>, kSides> sides;
};

ColorSamples ColorSamplesAt(const OrganizedCloud& cloud, const ModelPoints& model,
                            const Pose& X_CO) {
  ColorSamples samples;
  for (const auto& [point, pixel] : SeenPoints(cloud, model, X_CO)) {
    const Eigen::Vector3f& expected = model.texture.colors[point];
    const Eigen::Vector3f seen = ToVector(cloud.color.data()[pixel]);
    std::array<Moments, 3>& side = samples.sides[SideOf(model.normals_O[point])];
    for (int k = 0; k < 3; ++k) side[k].Add(expected[k], seen[k]);
    ++samples.points;
  }
  return samples;
}

std::optional<double> CorrelationOf(const ColorSamples& samples) {
  constexpr int kMinPoints = 40;
  constexpr double kMinVariance = 3 * 20.0 * 20.0;  // of the model colors, all channels
  constexpr double kPointsPerSample = 4;            // neighbouring points are correlated
  if (samples.points < kMinPoints) return {};
  double expected = 0, seen = 0, both = 0;
  for (const std::array<Moments, 3>& side : samples.sides) {
    for (const Moments& channel : side) {
      expected += channel.SquaresA();
      seen += channel.SquaresB();
      both += channel.Products();
    }
  }
  if (expected < kMinVariance * samples.points) return {};
  const double even = std::max(1.0 * samples.points, seen);  // an image of one color has variance 0
  return both / std::sqrt(expected * even) + 1 / std::sqrt(samples.points / kPointsPerSample);
}

}  // namespace

SurfaceTexture MakeSurfaceTexture(const ObjectModel& model, std::span<const Eigen::Vector3d> points,
                                  std::span<const int> triangles) {
  const TriangleMesh& mesh = model.mesh_O;
  const bool textured = !mesh.texture.empty() && !mesh.uvs.empty();
  SurfaceTexture texture;
  if (!textured && mesh.colors.empty()) return texture;
  const double texel_m = textured ? TexelSize_m(mesh) : 0;
  const double pixel_m = kPixelDiameters * model.diameter_m;
  const int reach = texel_m > 0 ? static_cast<int>(std::lround(0.5 * pixel_m / texel_m)) : 0;
  for (size_t i = 0; i < points.size(); ++i) {
    const Eigen::Vector3i& t = mesh.triangles[triangles[i]];
    const Eigen::Vector3d w = Barycentric(mesh, t, points[i]);
    if (textured) {
      const Eigen::Vector2d uv =
          w.x() * mesh.uvs[t.x()] + w.y() * mesh.uvs[t.y()] + w.z() * mesh.uvs[t.z()];
      texture.colors.push_back(TextureMean(mesh.texture, uv, reach));
    } else {
      const Eigen::Vector3f weights = w.cast<float>();
      texture.colors.push_back(weights.x() * ToVector(mesh.colors[t.x()]) +
                               weights.y() * ToVector(mesh.colors[t.y()]) +
                               weights.z() * ToVector(mesh.colors[t.z()]));
    }
  }
  texture.symmetries_O = SymmetryTransforms(model.symmetries_O, kContinuousSteps);
  return texture;
}

std::optional<double> TextureCorrelation(const OrganizedCloud& cloud, const ModelPoints& model,
                                         const Pose& X_CO) {
  if (model.texture.colors.empty() || cloud.color.empty()) return {};
  double best = -1;
  for (const Pose& S_O : model.texture.symmetries_O) {
    const std::optional<double> correlation =
        CorrelationOf(ColorSamplesAt(cloud, model, X_CO * S_O));
    if (!correlation) return {};
    best = std::max(best, *correlation);
  }
  return best;
}

double ScoreWithTexture(double score, std::optional<double> texture_correlation) {
  constexpr double kMissing = 12;  // nats against a pose if no texture is found
  if (!texture_correlation || *texture_correlation >= kTextureFound) return score;
  const double missing = std::min(1.0, (kTextureFound - *texture_correlation) / kTextureFound);
  return LessLikely(score, kMissing * missing);
}

}  // namespace pickbed::perception
