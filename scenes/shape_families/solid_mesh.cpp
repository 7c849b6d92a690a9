#include "scenes/shape_families/solid_mesh.h"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <map>
#include <unordered_map>

#include "scenes/base/error.h"
#include "scenes/geometry/mesh_levels.h"
#include "scenes/shape_families/solid_grid.h"

namespace pickbed::scenes {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3f;
using Eigen::Vector3i;

constexpr double kCellMargin = 0.02;       // of a cell, which has no vertex
constexpr float kNear = 0.25f;             // cells
constexpr float kSlopeStep = 0.02f;        // cells
constexpr double kSmallEigenvalue = 0.06;  // relative; directions below it follow the mean point

// ---- Sheets of the surface in a cell ----

// Corner k of a cell has the offsets (k & 1, k >> 1 & 1, k >> 2). Edge 4 a + i goes along axis a
// from the i-th corner with a zero offset along a.
struct CellTable {
  std::array<std::array<int, 2>, 12> ends;                // corners of each edge
  std::array<std::array<signed char, 12>, 256> sheet_of;  // by inside corners; -1 = no crossing
  std::array<int, 256> sheets;
};

int EdgeBetween(const CellTable& table, int a, int b) {
  for (int edge = 0; edge < 12; ++edge) {
    const std::array<int, 2>& ends = table.ends[edge];
    if ((ends[0] == a && ends[1] == b) || (ends[0] == b && ends[1] == a)) return edge;
  }
  return -1;
}

// Links the crossings of each face in pairs. Where all four edges cross, the two inside corners are
// separated. The rule depends only on the face, so both cells at a face link alike.
CellTable MakeCellTable() {
  CellTable table{};
  for (int axis = 0; axis < 3; ++axis) {
    const int u = 1 << (axis + 1) % 3, v = 1 << (axis + 2) % 3;
    for (int i = 0; i < 4; ++i) {
      const int low = (i & 1 ? u : 0) + (i & 2 ? v : 0);
      table.ends[4 * axis + i] = {low, low + (1 << axis)};
    }
  }
  for (int inside = 0; inside < 256; ++inside) {
    std::array<signed char, 12>& sheet_of = table.sheet_of[inside];
    std::array<int, 12> root;
    for (int e = 0; e < 12; ++e) root[e] = e;
    const auto find = [&](int e) {
      while (root[e] != e) e = root[e];
      return e;
    };
    for (int face = 0; face < 6; ++face) {
      const int axis = face / 2, base = face % 2 << axis;
      const int u = 1 << (axis + 1) % 3, v = 1 << (axis + 2) % 3;
      const std::array<int, 4> corners{base, base + u, base + u + v, base + v};
      std::vector<int> crossed;
      for (int k = 0; k < 4; ++k) {
        const int a = corners[k], b = corners[(k + 1) % 4];
        if ((inside >> a & 1) != (inside >> b & 1)) crossed.push_back(EdgeBetween(table, a, b));
      }
      if (crossed.size() == 2) root[find(crossed[0])] = find(crossed[1]);
      if (crossed.size() == 4) {
        for (int k = 0; k < 4; ++k) {
          if (inside >> corners[k] & 1) root[find(crossed[k])] = find(crossed[(k + 3) % 4]);
        }
      }
    }
    std::map<int, int> number;
    for (int e = 0; e < 12; ++e) {
      const bool crosses = (inside >> table.ends[e][0] & 1) != (inside >> table.ends[e][1] & 1);
      sheet_of[e] = static_cast<signed char>(
          crosses ? number.try_emplace(find(e), static_cast<int>(number.size())).first->second
                  : -1);
    }
    table.sheets[inside] = static_cast<int>(number.size());
  }
  return table;
}

// ---- Vertices ----

// Crossings of one sheet: sums for the least squares distance to their tangent planes.
struct SheetVertex {
  Vector3d sum = Vector3d::Zero();
  Eigen::Matrix3d AtA = Eigen::Matrix3d::Zero();
  Vector3d Atb = Vector3d::Zero();  // relative to the cell's corner
  int count = 0;
  Vector3f low = Vector3f::Zero();  // corner of the cell

  void Add(const GridCrossing& crossing) {
    const Vector3d p = (crossing.point - low).cast<double>(), n = crossing.normal.cast<double>();
    sum += p;
    AtA += n * n.transpose();
    Atb += n * n.dot(p);
    ++count;
  }

  // The point is limited to the cell, so that sheets of neighbors do not cross.
  Vector3f Solve(float cell_m) const {
    const Vector3d mean = sum / count;
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(AtA);
    Vector3d x = mean;
    for (int k = 0; k < 3; ++k) {
      const double value = solver.eigenvalues()[k];
      if (value < kSmallEigenvalue * solver.eigenvalues()[2]) continue;
      const Vector3d axis = solver.eigenvectors().col(k);
      x += axis * (axis.dot(Atb - AtA * mean) / value);
    }
    const double margin = kCellMargin * cell_m;
    const Vector3d limited = x.cwiseMax(margin).cwiseMin(cell_m - margin);
    return low + limited.cast<float>();
  }
};

// ---- Faces ----

using Polygon = std::vector<int>;  // vertices, counter-clockwise as seen from outside

struct DualSurface {
  std::vector<Vector3f> vertices;
  std::vector<Polygon> polygons;  // one for each crossing of the grid
};

DualSurface Contour(const SolidGrid& grid) {
  static const CellTable table = MakeCellTable();
  DualSurface surface;
  std::vector<SheetVertex> sheets;
  std::unordered_map<int, int> first_sheet;  // of a cell
  const auto sheet_at = [&](int cell, int edge) {
    int inside = 0;
    for (int k = 0; k < 8; ++k) {
      const int corner = cell + (k & 1) + (k >> 1 & 1) * grid.stride(1) + (k >> 2) * grid.stride(2);
      inside |= grid.inside[corner] << k;
    }
    const auto [it, added] = first_sheet.try_emplace(cell, static_cast<int>(sheets.size()));
    if (added) {
      sheets.resize(sheets.size() + table.sheets[inside]);
      for (int k = it->second; k < static_cast<int>(sheets.size()); ++k) {
        sheets[k].low = grid.Point(cell);
      }
    }
    return it->second + table.sheet_of[inside][edge];
  };
  for (const GridCrossing& crossing : grid.crossings) {
    const int u = grid.stride((crossing.axis + 1) % 3), v = grid.stride((crossing.axis + 2) % 3);
    Polygon quad(4);
    // The four cells around the edge, counter-clockwise about its axis.
    const std::array<std::array<int, 2>, 4> offsets{{{1, 1}, {0, 1}, {0, 0}, {1, 0}}};
    for (int k = 0; k < 4; ++k) {
      const auto [du, dv] = offsets[k];
      quad[k] = sheet_at(crossing.corner - du * u - dv * v, 4 * crossing.axis + du + 2 * dv);
      sheets[quad[k]].Add(crossing);
    }
    if (!crossing.leaves) std::swap(quad[1], quad[3]);
    surface.polygons.push_back(quad);
  }
  for (const SheetVertex& sheet : sheets) surface.vertices.push_back(sheet.Solve(grid.cell_m));
  return surface;
}

uint64_t EdgeKey(int a, int b) {
  return static_cast<uint64_t>(std::min(a, b)) << 32 | static_cast<uint32_t>(std::max(a, b));
}

// Where two sheets pass through one face between the same two vertices, their common edge has four
// polygons. It gets a new vertex for each sheet. The two crossings of a sheet in such a face have
// the same inside corner, see MakeCellTable().
void SeparateSheets(const SolidGrid& grid, DualSurface& surface) {
  std::unordered_map<uint64_t, int> uses;
  for (const Polygon& polygon : surface.polygons) {
    for (int k = 0; k < 4; ++k) ++uses[EdgeKey(polygon[k], polygon[(k + 1) % 4])];
  }
  std::map<std::pair<uint64_t, int>, int> added;  // by edge and inside corner
  for (size_t i = 0; i < surface.polygons.size(); ++i) {
    const GridCrossing& crossing = grid.crossings[i];
    const int inside =
        crossing.leaves ? crossing.corner : crossing.corner + grid.stride(crossing.axis);
    const Polygon quad = surface.polygons[i];
    Polygon& polygon = surface.polygons[i];
    polygon.clear();
    for (int k = 0; k < 4; ++k) {
      polygon.push_back(quad[k]);
      const uint64_t edge = EdgeKey(quad[k], quad[(k + 1) % 4]);
      if (uses[edge] == 2) continue;
      const auto [it, is_new] =
          added.try_emplace({edge, inside}, static_cast<int>(surface.vertices.size()));
      if (is_new) surface.vertices.push_back(crossing.point);
      Vector3f& vertex = surface.vertices[it->second];
      if (!is_new) vertex = 0.5f * (vertex + crossing.point);
      polygon.push_back(it->second);
    }
    // A fan from an added vertex has no triangle with two edges on one line.
    if (polygon.size() > 4) {
      const auto first = std::find_if(polygon.begin(), polygon.end(), [&](int v) {
        return std::find(quad.begin(), quad.end(), v) == quad.end();
      });
      std::rotate(polygon.begin(), first, polygon.end());
    }
  }
}

// Moves the vertices along the gradient onto the surface, where it is near.
void Project(const SolidShape& solid, float cell_m, DualSurface& surface) {
  std::vector<float> distances(surface.vertices.size());
  solid.SignedDistances_m(surface.vertices, distances);
  const std::vector<Vector3f> normals = solid.Normals(surface.vertices, kSlopeStep * cell_m);
  for (size_t i = 0; i < surface.vertices.size(); ++i) {
    if (std::abs(distances[i]) > kNear * cell_m) continue;
    surface.vertices[i] -= distances[i] * normals[i];
  }
}

// Cuts each quad along the diagonal whose center is nearer to the surface, and other polygons into
// a fan.
TriangleMesh Triangulate(const SolidShape& solid, const DualSurface& surface) {
  TriangleMesh mesh;
  for (const Vector3f& p : surface.vertices) mesh.vertices.push_back(p.cast<double>());
  for (const Vector3f& n : solid.Normals(surface.vertices)) {
    mesh.normals.push_back(n.cast<double>());
  }
  std::vector<Vector3f> centers;
  for (const Polygon& p : surface.polygons) {
    centers.push_back(0.5f * (surface.vertices[p[0]] + surface.vertices[p[2]]));
    centers.push_back(0.5f * (surface.vertices[p[1]] + surface.vertices[p[3]]));
  }
  std::vector<float> distances(centers.size());
  solid.SignedDistances_m(centers, distances);
  for (size_t i = 0; i < surface.polygons.size(); ++i) {
    Polygon p = surface.polygons[i];
    const bool second = std::abs(distances[2 * i]) > std::abs(distances[2 * i + 1]);
    if (p.size() == 4 && second) std::rotate(p.begin(), p.begin() + 1, p.end());
    for (size_t k = 1; k + 1 < p.size(); ++k) mesh.triangles.emplace_back(p[0], p[k], p[k + 1]);
  }
  return mesh;
}

}  // namespace

void SolidMeshOptions::Validate() const {
  CheckInput(cells >= 8 && cells <= 512, fmt::format("cells: {} is not within 8 to 512", cells));
  CheckInput(cells_per_wall >= 1 && cells_per_wall <= 10,
             fmt::format("cells_per_wall: {:g} is not within 1 to 10", cells_per_wall));
  CheckInput(tolerance_share >= 0 && tolerance_share <= 0.1,
             fmt::format("tolerance_share: {:g} is not within 0 to 0.1", tolerance_share));
}

TriangleMesh MeshOfSolid(const SolidShape& solid, const SolidMeshOptions& options) {
  options.Validate();
  CheckInput(!solid.program().instructions.empty(), "an empty solid has no surface");
  const double size_m = solid.box_O().sizes().maxCoeff();
  double cell_m = size_m / options.cells;
  if (solid.min_wall_m() > 0) {
    cell_m = std::min(cell_m, solid.min_wall_m() / options.cells_per_wall);
  }
  const SolidGrid grid = SampleGrid(solid, static_cast<float>(cell_m));
  DualSurface surface = Contour(grid);
  SeparateSheets(grid, surface);
  Project(solid, grid.cell_m, surface);
  TriangleMesh mesh = Triangulate(solid, surface);
  return options.tolerance_share == 0 ? mesh : ReducedMesh(mesh, options.tolerance_share * size_m);
}

}  // namespace pickbed::scenes
