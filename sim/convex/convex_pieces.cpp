#include "sim/convex/convex_pieces.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <sstream>
#include <utility>

#include "scenes/base/cache_file.h"
#include "scenes/base/error.h"
#include "scenes/objects/convex_file.h"
#include "scenes/objects/object_catalog.h"
#include "sim/convex/convex_cuts.h"
#include "sim/convex/convex_hull.h"

namespace pickbed::sim {
namespace {

using Eigen::Vector3d;

// Increase it whenever the same mesh and options give other pieces.
constexpr int kCacheVersion = 4;
// Share of the hull's size. A vertex that is less far outside is not added.
constexpr double kNegligible = 1e-5;

// Returns the largest distance of a point outside the planes of a hull; negative inside.
double Outside(const ConvexHull& hull, const std::vector<double>& offsets, const Vector3d& p) {
  double maximum = -1;
  for (size_t i = 0; i < offsets.size(); ++i) {
    maximum = std::max(maximum, hull.normals[i].dot(p) - offsets[i]);
  }
  return maximum;
}

// Returns the four vertices of the first tetrahedron. Two are far apart, one is far from their
// line, and one is far from the plane of the three.
std::vector<Vector3d> FirstFour(const std::vector<Vector3d>& points) {
  const auto farthest = [&](const auto& distance) {
    return *std::max_element(
        points.begin(), points.end(),
        [&](const Vector3d& a, const Vector3d& b) { return distance(a) < distance(b); });
  };
  const Vector3d a = farthest([](const Vector3d& p) { return -p.x(); });
  const Vector3d b = farthest([&](const Vector3d& p) { return (p - a).squaredNorm(); });
  const Vector3d c =
      farthest([&](const Vector3d& p) { return (p - a).cross(b - a).squaredNorm(); });
  const Vector3d normal = (b - a).cross(c - a);
  const Vector3d d = farthest([&](const Vector3d& p) { return std::abs((p - a).dot(normal)); });
  return {a, b, c, d};
}

std::vector<Vector3d> Thinned(const std::vector<Vector3d>& vertices, int max_vertices) {
  if (static_cast<int>(vertices.size()) <= max_vertices) return vertices;
  Eigen::AlignedBox3d box;
  for (const Vector3d& p : vertices) box.extend(p);
  const double negligible = kNegligible * box.sizes().maxCoeff();
  std::vector<Vector3d> taken = FirstFour(vertices);
  while (static_cast<int>(taken.size()) < max_vertices) {
    const ConvexHull hull = MakeConvexHull(taken);
    std::vector<double> offsets(hull.normals.size(), -1e300);
    for (size_t i = 0; i < hull.triangles.size(); ++i) {
      const int face = hull.triangle_faces[i];
      offsets[face] = hull.normals[face].dot(hull.vertices[hull.triangles[i][0]]);
    }
    double maximum = negligible;
    const Vector3d* next = nullptr;
    for (const Vector3d& p : vertices) {
      const double outside = Outside(hull, offsets, p);
      if (outside <= maximum) continue;
      maximum = outside;
      next = &p;
    }
    if (next == nullptr) break;
    taken.push_back(*next);
  }
  return taken;
}

std::filesystem::path CacheFile(const ObjectModel& model, const DecompositionOptions& options) {
  return CacheDir() / "convex" /
         fmt::format("{:016x}-v{}-{}-{}-{}.pieces", model.mesh_hash, kCacheVersion,
                     options.max_pieces, options.max_vertices, options.max_air_share);
}

std::string ToText(const std::vector<ConvexPiece>& pieces) {
  std::string text = fmt::format("{}\n", pieces.size());
  for (const ConvexPiece& piece : pieces) {
    text += fmt::format("{}\n", piece.vertices_O.size());
    for (const Vector3d& p : piece.vertices_O) {
      text += fmt::format("{} {} {}\n", p.x(), p.y(), p.z());  // shortest exact text
    }
  }
  return text;
}

std::vector<ConvexPiece> FromText(const std::string& text) {
  std::istringstream in(text);
  size_t count = 0;
  in >> count;
  std::vector<ConvexPiece> pieces;
  for (size_t i = 0; i < count && in; ++i) {
    size_t vertices = 0;
    in >> vertices;
    pieces.emplace_back();
    Vector3d p;
    for (size_t k = 0; k < vertices && in >> p.x() >> p.y() >> p.z(); ++k) {
      pieces.back().vertices_O.push_back(p);
    }
  }
  CheckInput(in && count > 0, "a piece is cut short");
  CheckInput((in >> std::ws).eof(), "there is text behind the pieces");
  for (const ConvexPiece& piece : pieces) {
    CheckInput(scenes::SpansAVolume(piece.vertices_O), "a piece has no volume");
  }
  return pieces;
}

}  // namespace

std::vector<ConvexPiece> DecomposeConvex(const TriangleMesh& mesh,
                                         const DecompositionOptions& options) {
  PlaneCutOptions cuts;
  cuts.max_pieces = options.max_pieces;
  cuts.max_air_share = options.max_air_share;
  std::vector<ConvexPiece> pieces;
  for (const std::vector<Vector3d>& points : CutByPlanes(mesh, cuts)) {
    const ConvexHull hull = MakeConvexHull(points);
    if (hull.vertices.empty()) continue;  // a sliver without volume
    std::vector<Vector3d> vertices = Thinned(hull.vertices, options.max_vertices);
    if (scenes::SpansAVolume(vertices)) pieces.push_back({std::move(vertices)});
  }
  return pieces;
}

std::shared_ptr<const ObjectModel> WithConvexPieces(std::shared_ptr<const ObjectModel> model,
                                                    const DecompositionOptions& options) {
  if (!model->convex_pieces_O.empty()) return model;
  auto copy = std::make_shared<ObjectModel>(*model);
  const auto make = [&] {
    std::vector<ConvexPiece> pieces = DecomposeConvex(model->mesh_O, options);
    CheckInput(!pieces.empty(),
               "object '" + model->name +
                   "' is flat: its mesh encloses no volume, or is thinner than collisions allow; "
                   "give it a thickness");
    return pieces;
  };
  copy->convex_pieces_O = Cached(CacheFile(*model, options), FromText, make, ToText);
  return copy;
}

ObjectSet WithConvexPieces(const ObjectSet& objects, const DecompositionOptions& options) {
  ObjectSet with_pieces;
  for (const auto& object : objects) with_pieces.push_back(WithConvexPieces(object, options));
  return with_pieces;
}

}  // namespace pickbed::sim
