// Every function of scenes/geometry on degenerate input: the result is lawful and finite, or the
// function throws InputError where its header says so.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>

#include "scenes/base/error.h"
#include "scenes/camera/footprint.h"
#include "scenes/geometry/decompositions.h"
#include "scenes/geometry/edge_collapse.h"
#include "scenes/geometry/mass_properties.h"
#include "scenes/geometry/mesh_bytes.h"
#include "scenes/geometry/mesh_edges.h"
#include "scenes/geometry/mesh_levels.h"
#include "scenes/geometry/mesh_query.h"
#include "scenes/geometry/polygon_triangulation.h"
#include "scenes/geometry/sphere_directions.h"
#include "scenes/geometry/symmetry.h"
#include "scenes/geometry/symmetry_finder.h"
#include "scenes/mesh_io/mesh_checks.h"
#include "tests/scenes/geometry/degenerate_meshes.h"
#include "tests/support/error_of.h"

namespace pickbed::tests {
namespace {

using Eigen::Vector3d;
using testing::HasSubstr;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

// Whether `work` finishes; false if it throws InputError.
bool Finishes(const std::function<void()>& work) {
  try {
    work();
    return true;
  } catch (const InputError&) {
    return false;
  }
}

bool AllFinite(const std::vector<Vector3d>& points) {
  return std::all_of(points.begin(), points.end(), [](const Vector3d& p) { return p.allFinite(); });
}

bool IsSound(const TriangleMesh& mesh) {
  const int count = static_cast<int>(mesh.vertices.size());
  return AllFinite(mesh.vertices) && AllFinite(mesh.normals) &&
         std::all_of(mesh.triangles.begin(), mesh.triangles.end(), [&](const Eigen::Vector3i& t) {
           return t.minCoeff() >= 0 && t.maxCoeff() < count;
         });
}

class DegenerateMeshTest : public testing::TestWithParam<DegenerateMesh> {
 protected:
  const TriangleMesh& mesh() const { return GetParam().mesh; }
};

TEST_P(DegenerateMeshTest, MeasuresAreFinite) {
  const Bounds bounds = MeshBounds(mesh());
  EXPECT_TRUE(bounds.min.allFinite() && bounds.max.allFinite());
  EXPECT_TRUE((bounds.size().array() >= 0).all());
  EXPECT_GE(Diameter(mesh()), 0);
  EXPECT_LE(Diameter(mesh()), bounds.size().norm() * (1 + 1e-9));
  EXPECT_EQ(SurfaceArea(mesh()) > 0, GetParam().has_area);
  const std::vector<Vector3d> normals = FaceNormals(mesh());
  ASSERT_EQ(normals.size(), mesh().triangles.size());
  for (const Vector3d& n : normals) {
    EXPECT_TRUE(n.isZero(0) || std::abs(n.norm() - 1) < 1e-9) << n.transpose();
  }
  EXPECT_EQ(MeshHash(mesh()), MeshHash(TriangleMesh(mesh())));
}

TEST_P(DegenerateMeshTest, MassNeedsAVolume) {
  const auto properties_at = [&](const MassProperties& p) {
    EXPECT_TRUE(p.com_O.allFinite() && p.inertia_com_O.allFinite());
    EXPECT_GT(p.volume_m3, 0);
    EXPECT_GT(p.mass_kg, 0);
    EXPECT_TRUE((EigenOfSymmetric3(p.inertia_com_O).values.array() > 0).all());
  };
  EXPECT_EQ(Finishes([&] { properties_at(UniformMassProperties(mesh(), 0.2)); }),
            GetParam().has_volume);
  EXPECT_EQ(Finishes([&] { properties_at(UniformDensityProperties(mesh(), 1000)); }),
            GetParam().has_volume);
}

TEST_P(DegenerateMeshTest, SamplesAndQueriesNeedAnArea) {
  const bool has_area = GetParam().has_area;
  EXPECT_EQ(Finishes([&] {
              Rng rng(1);
              const SurfaceSamples samples = SampleSurface(mesh(), 50, rng);
              EXPECT_EQ(samples.points.size(), 50u);
              EXPECT_TRUE(AllFinite(samples.points));
              for (const Vector3d& n : samples.normals) EXPECT_NEAR(n.norm(), 1, 1e-9);
            }),
            has_area);
  EXPECT_EQ(Finishes([&] {
              const MeshQuery query(mesh());
              const SurfaceHit hit = query.ClosestPoint(Vector3d(0.3, -0.2, 0.1));
              EXPECT_TRUE(hit.point.allFinite());
              EXPECT_NEAR(hit.normal.norm(), 1, 1e-9);
              EXPECT_TRUE(std::isfinite(hit.distance));
              EXPECT_TRUE(query.IsWithin(Vector3d(0.3, -0.2, 0.1), hit.distance * (1 + 1e-9)));
              for (const Vector3d& direction : SphereDirections(20)) {
                const auto first = query.Raycast(hit.point - direction, direction, 0, 1e9);
                EXPECT_TRUE(!first || first->point.allFinite());
                for (const SurfaceHit& crossing : query.AllHits(hit.point, direction)) {
                  EXPECT_TRUE(std::isfinite(crossing.distance));
                }
              }
            }),
            has_area);
  EXPECT_EQ(Finishes([&] {
              const SymmetrySet found = FindSymmetries(mesh());
              for (const Pose& S : found.discrete_O) EXPECT_TRUE(S.matrix().allFinite());
              for (const ContinuousSymmetry& axis : found.continuous_O) {
                EXPECT_NEAR(axis.axis_O.norm(), 1, 1e-9);
                EXPECT_TRUE(axis.offset_O.allFinite());
              }
            }),
            has_area);
}

TEST_P(DegenerateMeshTest, OtherMeshesOfItAreSound) {
  EXPECT_TRUE(IsSound(Transformed(mesh(), Translation({1, 2, 3}))));
  EXPECT_TRUE(IsSound(Scaled(mesh(), 0.5)));
  TriangleMesh joined = BoxShape({0.1, 0.1, 0.1}, {0, 0, 0});
  Append(mesh(), joined);
  EXPECT_TRUE(IsSound(joined));
  for (const MeshLevel& level : MakeMeshLevels(mesh())) {
    EXPECT_TRUE(IsSound(level.mesh));
    EXPECT_TRUE(level.deviation_m >= 0 && std::isfinite(level.deviation_m));
  }
  EXPECT_TRUE(IsSound(ReducedMesh(mesh(), 1e-3)));
  EXPECT_TRUE(IsSound(WithoutRepeatedFaces(mesh())));
  EXPECT_TRUE(IsSound(WithAgreeingFaces(mesh())));
  EXPECT_TRUE(IsSound(TurnedOutwards(mesh())));
  EXPECT_TRUE(std::isfinite(InspectMesh(mesh()).volume_m3));
  EXPECT_EQ(Finishes([&] { RequireUsableMesh(mesh(), "test"); }), GetParam().has_volume);
  const TriangleMesh read = MeshFromBytes(MeshToBytes(mesh()));
  EXPECT_EQ(read.vertices.size(), mesh().vertices.size());
  EdgeCollapse collapse(mesh().vertices, mesh().triangles,
                        std::vector<bool>(mesh().vertices.size()), 1e-4);
  collapse.ReduceTo(1e-3);
  EXPECT_LE(collapse.Triangles().size(), mesh().triangles.size());
}

TEST_P(DegenerateMeshTest, EdgesHaveUnitNormals) {
  const auto edges = MeshEdges(mesh());
  if (GetParam().has_volume) {
    EXPECT_FALSE(edges.empty());
  }
  for (const MeshEdge& edge : edges) {
    EXPECT_TRUE(edge.a.allFinite() && edge.b.allFinite());
    EXPECT_NEAR(edge.normal_1.norm(), 1, 1e-9);
    EXPECT_NEAR(edge.normal_2.norm(), 1, 1e-9);
  }
}

TEST_P(DegenerateMeshTest, FootprintIsFinite) {
  const CameraIntrinsics k(640, 480, 600, 600, 320, 240);
  for (const double z_m : {-1.0, 0.0, 1e-300, 1.0, 1e300}) {
    const Footprint f = FootprintOf(MeshBounds(mesh()), Translation({0, 0, z_m}), k);
    EXPECT_FALSE(std::isnan(f.near_m) || std::isnan(f.far_m)) << z_m;
    EXPECT_TRUE(!f.in_front || (f.min_px.allFinite() && f.max_px.allFinite())) << z_m;
  }
}

INSTANTIATE_TEST_SUITE_P(Meshes, DegenerateMeshTest, testing::ValuesIn(DegenerateMeshes()),
                         [](const auto& info) {
                           std::string name = info.param.name;
                           std::replace(name.begin(), name.end(), ' ', '_');
                           return name;
                         });

TEST(DegenerateMeshes, VerticesThatAreNotFiniteAreRefused) {
  for (const double value : {kNaN, std::numeric_limits<double>::infinity()}) {
    TriangleMesh mesh = BoxShape({0.1, 0.2, 0.3}, {0, 0, 0});
    mesh.vertices[3].y() = value;
    EXPECT_FALSE(InspectMesh(mesh).finite);
    EXPECT_THROW(RequireUsableMesh(mesh, "test"), InputError);
    EXPECT_THROW(MeshFromBytes(MeshToBytes(mesh)), InputError);
    EXPECT_THROW(UniformMassProperties(mesh, 1), InputError);
  }
}

struct OutlineCase {
  const char* name;
  Outline outline;
  bool is_lawful;  // it has triangles; others give none or throw std::logic_error
};

TEST(DegenerateOutlines, GiveTrianglesNoneOrALogicError) {
  const Eigen::Vector2d a(0, 0), b(1, 0), c(1, 1), d(0, 1);
  const OutlineCase cases[] = {{"empty", {}, false},
                               {"one point", {a}, false},
                               {"two points", {a, b}, false},
                               {"one place", {a, a, a, a}, false},
                               {"a line", {a, b, {2, 0}, {3, 0}}, false},
                               {"there and back", {a, b, a, b}, false},
                               {"crossing itself", {a, c, b, d}, false},
                               {"square", {a, b, c, d}, true},
                               {"a vertex twice", {a, b, b, c, d}, true},
                               {"a vertex on a side", {a, {0.5, 0}, b, c, d}, true}};
  for (const OutlineCase& test : cases) {
    EXPECT_TRUE(std::isfinite(SignedArea(test.outline))) << test.name;
    try {
      const std::vector<Eigen::Vector3i> triangles = TriangulatePolygon(test.outline);
      for (const Eigen::Vector3i& t : triangles) {
        EXPECT_GE(t.minCoeff(), 0) << test.name;
        EXPECT_LT(t.maxCoeff(), static_cast<int>(test.outline.size())) << test.name;
      }
      EXPECT_TRUE(!test.is_lawful || triangles.size() >= 2) << test.name;
    } catch (const std::logic_error&) {
      EXPECT_FALSE(test.is_lawful) << test.name;
    }
  }
}

TEST(DegenerateDecompositions, AreFinite) {
  for (const Eigen::Matrix3d& m :
       {Eigen::Matrix3d(Eigen::Matrix3d::Zero()), Eigen::Matrix3d(Eigen::Matrix3d::Ones()),
        Eigen::Matrix3d(Vector3d(1, 0, 0).asDiagonal()),
        Eigen::Matrix3d(1e-200 * Eigen::Matrix3d::Identity()),
        Eigen::Matrix3d(1e150 * Eigen::Matrix3d::Identity())}) {
    EXPECT_TRUE(EigenOfSymmetric3(m).values.allFinite());
    EXPECT_TRUE(EigenOfSymmetric3(m).vectors.allFinite());
    EXPECT_TRUE(EigenOfSymmetric(m).values.allFinite());
    EXPECT_TRUE(MinimumNormSolution(m, m * Vector3d(1, 2, 3)).allFinite());
    EXPECT_TRUE(SolveSymmetric(m, m * Vector3d(1, 2, 3)).allFinite());
    const Eigen::Matrix3d R = Orthonormalized(m);
    EXPECT_LT((R * R.transpose() - Eigen::Matrix3d::Identity()).norm(), 1e-9);
    EXPECT_NEAR(R.determinant(), 1, 1e-9);
  }
  const Vector3d zero = Vector3d::Zero(), x = Vector3d::UnitX();
  for (const auto& [from, to] : {std::pair(x, Vector3d(-x)), std::pair(x, x), std::pair(zero, x),
                                 std::pair(zero, zero), std::pair(Vector3d(1e-200 * x), x)}) {
    const Eigen::Quaterniond q = RotationBetween(from, to);
    EXPECT_TRUE(q.coeffs().allFinite());
    EXPECT_NEAR(q.norm(), 1, 1e-9);
  }
}

TEST(DegeneratePoses, AnglesAndViewsAreFiniteOrRefused) {
  const Eigen::Matrix3d I = Eigen::Matrix3d::Identity();
  EXPECT_EQ(RotationAngleRad(I, I), 0);
  EXPECT_NEAR(RotationAngleRad(I, Eigen::AngleAxisd(M_PI, Vector3d::UnitX()).toRotationMatrix()),
              M_PI, 1e-7);
  EXPECT_THROW(LookAt(Vector3d::Zero(), Vector3d::Zero(), Vector3d::UnitZ()), InputError);
  EXPECT_THROW(LookAt(Vector3d::Zero(), Vector3d::UnitZ(), Vector3d::UnitZ()), InputError);
  EXPECT_THROW(LookAt(Vector3d::Zero(), Vector3d::UnitX(), Vector3d::Zero()), InputError);
  EXPECT_THROW(LookAt(Vector3d(kNaN, 0, 0), Vector3d::UnitX(), Vector3d::UnitZ()), InputError);
  EXPECT_THROW(ProperRotation(Eigen::Matrix3d::Zero(), "R"), InputError);
  EXPECT_THROW(ProperRotation(kNaN * I, "R"), InputError);
  EXPECT_THROW(ProperRotation(-I, "R"), InputError);
  EXPECT_TRUE(PointOnAxis(Pose::Identity()).allFinite());
  EXPECT_TRUE(PointOnAxis(Translation({1, 2, 3})).allFinite());
  EXPECT_TRUE(TurnAbout({}, 0).matrix().allFinite());
}

SymmetrySet SymmetriesAbout(const std::vector<ContinuousSymmetry>& axes) { return {{}, axes}; }

TEST(DegenerateSymmetries, OneAxisGivenTwiceIsOneAxis) {
  const Vector3d z = Vector3d::UnitZ(), x = Vector3d::UnitX();
  const ContinuousSymmetry axis{z, {0.1, 0, 0}};
  const SymmetrySet sets[] = {SymmetriesAbout({axis}), SymmetriesAbout({axis, axis}),
                              SymmetriesAbout({axis, {-z, axis.offset_O + z}}),
                              SymmetriesAbout({axis, {(z + 1e-9 * x).normalized(), {0.1, 0, 0}}})};
  for (const SymmetrySet& set : sets) {
    EXPECT_EQ(SecondAxis(set), nullptr);
    const std::vector<Pose> turns = SymmetryTransforms(set, 12);
    ASSERT_EQ(turns.size(), 12u);
    for (const Pose& S : turns) {
      EXPECT_LT((S * axis.offset_O - axis.offset_O).norm(), 1e-12);
    }
    EXPECT_EQ(SymmetryTransforms(set, 1).size(), 1u);
    EXPECT_THROW(SymmetryTransforms(set, 0), std::invalid_argument);
  }
  EXPECT_EQ(SecondAxis({}), nullptr);
  EXPECT_THROW(SymmetryTransforms({}, 0), std::invalid_argument);
}

TEST(DegenerateSymmetries, AxesThatDoNotMeetAreRefused) {
  const Vector3d x = Vector3d::UnitX(), z = Vector3d::UnitZ();
  const ContinuousSymmetry axis{z, Vector3d::Zero()};
  const SymmetrySet sets[] = {SymmetriesAbout({axis, {z, {0.1, 0, 0}}}),    // parallel
                              SymmetriesAbout({axis, {-z, {0, 1e-4, 0}}}),  // opposite
                              SymmetriesAbout({axis, {x, {0, 0.1, 0}}}),    // skew
                              SymmetriesAbout({axis, {kNaN * x, {0, 0, 0}}}),
                              SymmetriesAbout({axis, {x, kNaN * x}})};
  for (const SymmetrySet& set : sets) {
    EXPECT_THAT(ErrorOf([&] { SymmetryTransforms(set, 12); }),
                HasSubstr("two continuous symmetry axes do not meet in a point"));
  }
}

TEST(DegenerateSymmetries, TwoAxesThatMeetAreABall) {
  const Vector3d center(0.1, 0.2, 0.3), x = Vector3d::UnitX(), z = Vector3d::UnitZ();
  const SymmetrySet ball = SymmetriesAbout({{z, center - 5 * z}, {x, center + 5 * x}});
  ASSERT_NE(SecondAxis(ball), nullptr);
  EXPECT_EQ(SecondAxis(ball)->axis_O, x);
  for (const int steps : {1, 12}) {
    const std::vector<Pose> turns = SymmetryTransforms(ball, steps);
    EXPECT_GT(turns.size(), 4u);
    for (const Pose& S : turns) {
      EXPECT_TRUE(S.matrix().allFinite());
      EXPECT_LT((S * center - center).norm(), 1e-9);
    }
  }
}

TEST(DegenerateQueries, PointsThatAreNotFiniteMeetNothing) {
  const MeshQuery query(BoxShape({0.1, 0.2, 0.3}));
  const Vector3d zero = Vector3d::Zero(), x = Vector3d::UnitX();
  const double infinity = std::numeric_limits<double>::infinity();
  for (const Vector3d& p :
       {Vector3d(kNaN, 0, 0), Vector3d(0, 0, infinity), Vector3d(1e200, 0, 0)}) {
    EXPECT_THAT(ErrorOf([&] { query.ClosestPoint(p); }), HasSubstr("not finite or too far"));
    EXPECT_FALSE(query.IsWithin(p, 1));
  }
  for (const auto& [origin, direction] :
       {std::pair(Vector3d(kNaN, 0, 0), x), std::pair(zero, Vector3d(kNaN, 0, 0)),
        std::pair(zero, zero), std::pair(Vector3d(0, infinity, 0), x)}) {
    EXPECT_FALSE(query.Raycast(origin, direction, -1e9, 1e9));
    EXPECT_TRUE(query.AllHits(origin, direction).empty());
  }
  EXPECT_FALSE(query.IsWithin(zero, kNaN));
  EXPECT_FALSE(query.Raycast(zero, x, 1, -1));
  EXPECT_FALSE(query.Raycast(zero, x, kNaN, 1));
}

TEST(DegenerateDirections, AnyCountGivesUnitVectors) {
  for (const int count : {0, 1, 2, 3}) {
    const std::vector<Vector3d> directions = SphereDirections(count);
    ASSERT_EQ(directions.size(), static_cast<size_t>(count));
    for (const Vector3d& d : directions) EXPECT_NEAR(d.norm(), 1, 1e-9) << count;
  }
}

}  // namespace
}  // namespace pickbed::tests
