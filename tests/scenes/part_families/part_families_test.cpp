#include "scenes/part_families/part_families.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <map>
#include <set>
#include <sstream>

#include "scenes/geometry/mass_properties.h"
#include "scenes/geometry/mesh_query.h"
#include "scenes/mesh_io/mesh_checks.h"
#include "scenes/objects/object_catalog.h"
#include "tests/scenes/convex_union.h"

namespace pickbed::tests {
namespace {

namespace fs = std::filesystem;
using Eigen::Vector3d;

// Expected properties of each family. The convex pieces fill screw holes and the bend of the elbow;
// there they may extend beyond the mesh by the radius of the hole.
struct Expected {
  const char* name;
  size_t group_order;  // of the discrete rotations, including the identity
  size_t continuous_axes;
  double filled_radius_m;
};

void PrintTo(const Expected& expected, std::ostream* out) { *out << expected.name; }

const Expected kExpected[] = {
    {"bracket", 1, 0, 6e-3},  {"rod", 2, 0, 0},      {"pipe_tee", 2, 0, 0}, {"u_clip", 2, 0, 0},
    {"flange", 6, 0, 3.5e-3}, {"hex_bolt", 6, 0, 0}, {"gear", 24, 0, 0},    {"elbow", 1, 0, 8e-3},
    {"carton", 4, 0, 0},      {"bottle", 1, 1, 0},   {"mug", 1, 0, 0},      {"ring", 2, 1, 0},
};

FamilyObject Make(const std::string& name) {
  for (const FamilyRow& row : FamilyTable()) {
    if (name == row.name) return row.make();
  }
  throw std::logic_error("no object " + name);
}

Pose RotationAbout(const Vector3d& axis, double angle_deg) {
  return Pose(Eigen::AngleAxisd(angle_deg * M_PI / 180, axis.normalized()));
}

// Returns the largest distance of the rotated vertices and surface samples to the original surface,
// in metres.
double LargestDeviation_m(const TriangleMesh& mesh, const Pose& rotation) {
  constexpr int kSamples = 400;
  const MeshQuery query(mesh);
  Rng rng(1);
  double largest = 0;
  for (const Vector3d& p : mesh.vertices) {
    largest = std::max(largest, query.ClosestPoint(rotation * p).distance);
  }
  for (const Vector3d& p : SampleSurface(mesh, kSamples, rng).points) {
    largest = std::max(largest, query.ClosestPoint(rotation * p).distance);
  }
  return largest;
}

// Counts the crossings along a ray. The direction is oblique, because edges of the objects are
// parallel to the axes.
bool IsInside(const MeshQuery& query, const Vector3d& p) {
  const std::vector<SurfaceHit> hits = query.AllHits(p, Vector3d(0.531, 0.277, 0.801).normalized());
  return std::count_if(hits.begin(), hits.end(),
                       [](const SurfaceHit& h) { return h.distance > 0; }) %
             2 ==
         1;
}

double PoseDistance(const Pose& a, const Pose& b) { return (a.matrix() - b.matrix()).norm(); }

bool Contains(const std::vector<Pose>& group, const Pose& X) {
  return std::any_of(group.begin(), group.end(),
                     [&](const Pose& element) { return PoseDistance(element, X) < 1e-6; });
}

std::vector<Pose> WithIdentity(const SymmetrySet& symmetries) {
  std::vector<Pose> group = {Pose::Identity()};
  group.insert(group.end(), symmetries.discrete_O.begin(), symmetries.discrete_O.end());
  return group;
}

std::string Bytes(const fs::path& path) {
  std::ifstream in(path, std::ios::binary);
  std::ostringstream bytes;
  bytes << in.rdbuf();
  return bytes.str();
}

std::set<std::string> FileNames(const fs::path& folder) {
  std::set<std::string> names;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder)) {
    names.insert(entry.path().filename().string());
  }
  return names;
}

TEST(FamilyTable, ListsEveryExpectedFamilyOnce) {
  std::vector<std::string> made, expected;
  for (const FamilyRow& row : FamilyTable()) made.push_back(row.name);
  for (const Expected& family : kExpected) expected.push_back(family.name);
  EXPECT_THAT(made, testing::UnorderedElementsAreArray(expected));
}

class PartFamily : public testing::TestWithParam<Expected> {
 protected:
  const FamilyObject object_ = Make(GetParam().name);
};

TEST_P(PartFamily, IsClosedAndOfPickableSize) {
  const MeshReport report = InspectMesh(object_.mesh_O);
  EXPECT_TRUE(report.finite);
  EXPECT_EQ(report.open_edges, 0);
  EXPECT_GT(report.volume_m3, 0);
  EXPECT_LE(report.triangles, 2500);
  const double diameter_m = Diameter(object_.mesh_O);
  EXPECT_GE(diameter_m, 0.02);
  EXPECT_LE(diameter_m, 0.20);
  EXPECT_LT(MeshBounds(object_.mesh_O).center().norm(), 1e-9);
}

TEST_P(PartFamily, CanBeLiftedByASmallJawGripper) {
  constexpr double kOpening_m = 0.07, kForce_N = 40, kGravity = 9.81;
  EXPECT_LT(MeshBounds(object_.mesh_O).size().minCoeff(), kOpening_m);
  const double mass_kg = InspectMesh(object_.mesh_O).volume_m3 * object_.density_kgpm3;
  EXPECT_LT(mass_kg * kGravity, 0.5 * 2 * object_.friction * kForce_N);
  EXPECT_GE(object_.friction, 0.4);
  EXPECT_LE(object_.friction, 0.7);
}

TEST_P(PartFamily, VertexNormalsAgreeWithFaceNormals) {
  const TriangleMesh& mesh = object_.mesh_O;
  const std::vector<Vector3d> faces = FaceNormals(mesh);
  ASSERT_EQ(mesh.normals.size(), mesh.vertices.size());
  for (size_t t = 0; t < mesh.triangles.size(); ++t) {
    ASSERT_GT(faces[t].norm(), 0.5) << "degenerate triangle " << t;
    for (int k = 0; k < 3; ++k) {
      const Vector3d& normal = mesh.normals[mesh.triangles[t][k]];
      EXPECT_NEAR(normal.norm(), 1, 1e-9);
      EXPECT_GT(normal.dot(faces[t]), std::cos(40 * M_PI / 180)) << "triangle " << t;
    }
  }
}

TEST_P(PartFamily, SymmetriesMapItOntoItself) {
  constexpr double kExact_m = 1e-6, kFacets_m = 1e-4;
  for (const Pose& X : object_.symmetries_O.discrete_O) {
    EXPECT_LT(LargestDeviation_m(object_.mesh_O, X), kExact_m) << X.matrix();
  }
  for (const ContinuousSymmetry& s : object_.symmetries_O.continuous_O) {
    EXPECT_LT(s.offset_O.norm(), 1e-9);
    for (double angle_deg : {1.3, 7.0, 41.0, 200.0}) {
      EXPECT_LT(LargestDeviation_m(object_.mesh_O, RotationAbout(s.axis_O, angle_deg)), kFacets_m);
    }
  }
}

TEST_P(PartFamily, SymmetriesAreAGroupOfTheExpectedOrder) {
  const std::vector<Pose> group = WithIdentity(object_.symmetries_O);
  EXPECT_EQ(group.size(), GetParam().group_order);
  EXPECT_EQ(object_.symmetries_O.continuous_O.size(), GetParam().continuous_axes);
  for (const Pose& a : group) {
    for (const Pose& b : group) EXPECT_TRUE(Contains(group, a * b));
  }
}

// The list holds every rotation about a main axis that maps the object onto itself.
TEST_P(PartFamily, NoSymmetryAboutAMainAxisIsMissing) {
  const std::vector<Pose> group = WithIdentity(object_.symmetries_O);
  for (int a = 0; a < 3; ++a) {
    const Vector3d axis = Vector3d::Unit(a);
    const auto& continuous = object_.symmetries_O.continuous_O;
    if (!continuous.empty() && std::abs(continuous[0].axis_O.dot(axis)) > 0.5) continue;
    for (int order = 2; order <= 12; ++order) {
      const Pose rotation = RotationAbout(axis, 360.0 / order);
      // About an axis normal to a continuous one, every flip is the listed flip combined with a
      // continuous rotation.
      const bool listed =
          Contains(group, rotation) || (!continuous.empty() && group.size() == 2 && order == 2);
      EXPECT_EQ(LargestDeviation_m(object_.mesh_O, rotation) < 2e-4, listed)
          << "axis " << axis.transpose() << " order " << order;
    }
  }
}

TEST_P(PartFamily, WrongSymmetryIsDetected) {
  constexpr double kClearly_m = 3e-4;  // three times the tolerance for facets
  const Vector3d axis = object_.symmetries_O.continuous_O.empty() ? Vector3d::UnitZ().eval()
                                                                  : Vector3d::UnitX().eval();
  EXPECT_GT(LargestDeviation_m(object_.mesh_O, RotationAbout(axis, 7)), kClearly_m);
  EXPECT_GT(LargestDeviation_m(object_.mesh_O, RotationAbout({1, 2, 3}, 180)), kClearly_m);
}

TEST_P(PartFamily, PiecesAreFewSmallAndConvex) {
  EXPECT_GE(object_.convex_pieces_O.size(), 1u);
  EXPECT_LE(object_.convex_pieces_O.size(), 24u);
  for (const ConvexPiece& piece : object_.convex_pieces_O) {
    EXPECT_LE(piece.vertices_O.size(), 32u);
    std::set<int> corners;
    for (const Eigen::Vector3i& t : FacesOf(piece).mesh.triangles) {
      corners.insert({t[0], t[1], t[2]});
    }
    EXPECT_EQ(corners.size(), piece.vertices_O.size()) << "a vertex is inside the hull";
  }
}

TEST_P(PartFamily, PiecesCoverTheSurface) {
  constexpr double kTolerance_m = 0.6e-3;
  const ConvexUnion pieces(object_.convex_pieces_O);
  Rng rng(2);
  for (const Vector3d& p : SampleSurface(object_.mesh_O, 2000, rng).points) {
    EXPECT_LT(pieces.Distance(p), kTolerance_m) << "at " << 1e3 * p.transpose() << " mm";
  }
}

TEST_P(PartFamily, PiecesDoNotExtendBeyondTheMesh) {
  const double tolerance_m = std::max(0.8e-3, GetParam().filled_radius_m);
  const MeshQuery query(object_.mesh_O);
  const auto outside_m = [&](const Vector3d& p) {
    return IsInside(query, p) ? 0.0 : query.ClosestPoint(p).distance;
  };
  Rng rng(3);
  for (const ConvexPiece& piece : object_.convex_pieces_O) {
    const HullFaces hull = FacesOf(piece);
    for (const Vector3d& p : hull.mesh.vertices) EXPECT_LT(outside_m(p), 1e-3);
    for (const Vector3d& p : SampleSurface(hull.mesh, 150, rng).points) {
      EXPECT_LT(outside_m(p), tolerance_m) << "at " << 1e3 * p.transpose() << " mm";
    }
  }
}

// The committed files equal the output of the table byte for byte.
TEST_P(PartFamily, CommittedFilesEqualTheGeneratedFiles) {
  const fs::path shipped = fs::path(PICKBED_SOURCE_DIR) / "assets/objects" / GetParam().name;
  const fs::path again =
      fs::path(testing::TempDir()) / fmt::format("parts_{}_{}", getpid(), GetParam().name);
  for (const FamilyRow& row : FamilyTable()) {
    if (std::string(row.name) == GetParam().name) WriteFamilyObject(row, again);
  }
  EXPECT_EQ(FileNames(again), FileNames(shipped));
  for (const std::string& name : FileNames(again)) {
    EXPECT_TRUE(Bytes(again / name) == Bytes(shipped / name))
        << name << " differs: run pickbed_make_parts";
  }
  fs::remove_all(again);
}

TEST_P(PartFamily, CatalogLoadsTheSameObject) {
  const ObjectCatalog catalog({fs::path(PICKBED_SOURCE_DIR) / "assets/objects"});
  const auto model = catalog.Load(GetParam().name);
  ASSERT_EQ(model->mesh_O.triangles.size(), object_.mesh_O.triangles.size());
  ASSERT_EQ(model->mesh_O.uvs.empty(), object_.mesh_O.uvs.empty());
  EXPECT_NEAR(model->diameter_m, Diameter(object_.mesh_O), 1e-6);
  EXPECT_EQ(model->friction, object_.friction);
  EXPECT_EQ(model->mesh_O.texture, object_.mesh_O.texture);
  EXPECT_EQ(model->mesh_O.base_color, object_.mesh_O.base_color);
  EXPECT_NEAR(model->mass.mass_kg, object_.density_kgpm3 * InspectMesh(object_.mesh_O).volume_m3,
              1e-5 * model->mass.mass_kg);
  ASSERT_EQ(model->convex_pieces_O.size(), object_.convex_pieces_O.size());
  for (size_t i = 0; i < object_.convex_pieces_O.size(); ++i) {
    EXPECT_EQ(model->convex_pieces_O[i].vertices_O.size(),
              object_.convex_pieces_O[i].vertices_O.size());
  }
  for (size_t t = 0; t < object_.mesh_O.triangles.size(); ++t) {
    const int before = object_.mesh_O.triangles[t][0], after = model->mesh_O.triangles[t][0];
    EXPECT_LT((model->mesh_O.vertices[after] - object_.mesh_O.vertices[before]).norm(), 1e-8);
    if (!model->mesh_O.normals.empty()) {  // the reader drops the normals of flat faces
      EXPECT_LT((model->mesh_O.normals[after] - object_.mesh_O.normals[before]).norm(), 1e-4);
    }
    if (!object_.mesh_O.uvs.empty()) {
      EXPECT_LT((model->mesh_O.uvs[after] - object_.mesh_O.uvs[before]).norm(), 1e-5);
    }
  }
  const std::vector<Pose> group = WithIdentity(model->symmetries_O);
  EXPECT_EQ(group.size(), GetParam().group_order);
  for (const Pose& X : object_.symmetries_O.discrete_O) EXPECT_TRUE(Contains(group, X));
  EXPECT_EQ(model->symmetries_O.continuous_O.size(), GetParam().continuous_axes);
}

INSTANTIATE_TEST_SUITE_P(Families, PartFamily, testing::ValuesIn(kExpected),
                         [](const auto& info) { return std::string(info.param.name); });

// Volume of a ring with bevelled outer edges by Pappus's theorem, reduced by the area that the
// facets of a circle cut off. The factor is the same for every radius.
TEST(PartFamilyVolume, RingMatchesTheFormula) {
  const double inner = 22e-3, outer = 30e-3, height = 14e-3, bevel = 0.6e-3;
  const int facets = 72;
  const double facet_area_ratio = facets / (2 * M_PI) * std::sin(2 * M_PI / facets);
  const double plain = M_PI * (outer * outer - inner * inner) * height;
  const double corner = bevel * bevel / 2 * 2 * M_PI * (outer - bevel / 3);
  EXPECT_NEAR(InspectMesh(Make("ring").mesh_O).volume_m3, facet_area_ratio * (plain - 2 * corner),
              1e-11);
}

TEST(PartFamilyVolume, CartonAndBracketMatchTheFormula) {
  EXPECT_NEAR(InspectMesh(Make("carton").mesh_O).volume_m3, 60e-3 * 90e-3 * 140e-3, 1e-12);
  const auto disc_mm2 = [](double radius, int facets) {
    return 0.5 * facets * radius * radius * std::sin(2 * M_PI / facets);
  };
  const double plates = 80 * 40 * 6 + 6 * 40 * 44, rib = 6 * 24 * 24 / 2.0;
  const double boss = 8 * disc_mm2(8, 32), holes = 6 * (disc_mm2(5, 24) + disc_mm2(6, 24));
  EXPECT_NEAR(InspectMesh(Make("bracket").mesh_O).volume_m3 * 1e9, plates + rib + boss - holes,
              1e-2);
}

// The volume of two intersecting tubes has no closed form, so the reference is a Monte Carlo
// estimate.
TEST(PartFamilyVolume, PipeTeeMatchesAMonteCarloEstimate) {
  const auto solid = [](const Vector3d& p) {
    const double run = std::hypot(p.y(), p.z()), branch = std::hypot(p.x(), p.y());
    const bool outside = run < 14 || (branch < 12 && p.z() > 0);
    const bool bore = run < 10 || (branch < 8 && p.z() > 0);
    return outside && !bore && p.z() < 36;
  };
  constexpr int kCount = 2000000;
  Rng rng(4);
  int hits = 0;
  for (int i = 0; i < kCount; ++i) {
    hits += solid({rng.Uniform(-40, 40), rng.Uniform(-14, 14), rng.Uniform(-14, 36)});
  }
  const double counted_mm3 = 80.0 * 28 * 50 * hits / kCount;
  EXPECT_NEAR(InspectMesh(Make("pipe_tee").mesh_O).volume_m3 * 1e9, counted_mm3,
              0.02 * counted_mm3);
}

TEST(PartFamilyTexture, CartonHasDifferentColorsOnEachSide) {
  const FamilyObject carton = Make("carton");
  ASSERT_FALSE(carton.mesh_O.texture.empty());
  ASSERT_EQ(carton.mesh_O.uvs.size(), carton.mesh_O.vertices.size());
  const Image<Rgb8>& sheet = carton.mesh_O.texture;
  std::map<std::array<long, 3>, Vector3d> color_sums;  // by face normal
  for (size_t t = 0; t < carton.mesh_O.triangles.size(); ++t) {
    const Eigen::Vector3i& corners = carton.mesh_O.triangles[t];
    const Vector3d& n = carton.mesh_O.normals[corners[0]];
    const std::array<long, 3> face = {std::lround(n.x()), std::lround(n.y()), std::lround(n.z())};
    const Eigen::Vector2d uv = (carton.mesh_O.uvs[corners[0]] + carton.mesh_O.uvs[corners[1]] +
                                carton.mesh_O.uvs[corners[2]]) /
                               3;
    const Rgb8 c =
        sheet(static_cast<int>(uv.x() * sheet.width()), static_cast<int>(uv.y() * sheet.height()));
    color_sums.try_emplace(face, Vector3d::Zero()).first->second += Vector3d(c.r, c.g, c.b);
  }
  ASSERT_EQ(color_sums.size(), 6u);
  for (auto a = color_sums.begin(); a != color_sums.end(); ++a) {
    for (auto b = std::next(a); b != color_sums.end(); ++b) {
      EXPECT_GT((a->second - b->second).norm(), 100);
    }
  }
}

}  // namespace
}  // namespace pickbed::tests
