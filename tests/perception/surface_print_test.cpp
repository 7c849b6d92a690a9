#include "perception/surface_print.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numbers>

#include "perception/final_set.h"
#include "scenes/random.h"
#include "tests/support/synthetic_depth.h"

namespace pickbed {
namespace {

constexpr double kSide_m = 0.08;
constexpr Rgb8 kGrey{176, 176, 180};

// Squares of random colours.
Image<Rgb8> RandomPrint(uint64_t seed) {
  constexpr int kTexels = 64, kSquare = 16;
  Rng rng(seed);
  Image<Rgb8> print(kTexels, kTexels);
  for (int y = 0; y < kTexels; y += kSquare) {
    for (int x = 0; x < kTexels; x += kSquare) {
      const auto channel = [&] { return static_cast<uint8_t>(rng.Index(256)); };
      const Rgb8 color{channel(), channel(), channel()};
      for (int i = 0; i < kSquare * kSquare; ++i) print(x + i % kSquare, y + i / kSquare) = color;
    }
  }
  return print;
}

Eigen::Vector2d PlaceOnPrint(const Eigen::Vector3d& p_O) {
  return {p_O.x() / kSide_m + 0.5, p_O.y() / kSide_m + 0.5};
}

// 80 x 80 x 20 mm, printed alike on the two large sides.
TriangleMesh PrintedSlab(const Image<Rgb8>& print) {
  TriangleMesh mesh = BoxMesh({kSide_m, kSide_m, 0.02}, Eigen::Vector3d::Zero());
  for (const Eigen::Vector3d& vertex : mesh.vertices) mesh.uvs.push_back(PlaceOnPrint(vertex));
  mesh.texture = print;
  return mesh;
}

// The slab faces the camera at 0.4 m; what its pixels show is told by a function of the place on
// the slab.
using Painting = std::function<Rgb8(const Eigen::Vector2d& uv)>;

Painting Showing(const Image<Rgb8>& print) {
  return [&print](const Eigen::Vector2d& uv) {
    const auto texel = [](double share, int size) {
      return std::clamp(static_cast<int>(share * size), 0, size - 1);
    };
    return print(texel(uv.x(), print.width()), texel(uv.y(), print.height()));
  };
}

class PrintOfASlab : public ::testing::Test {
 protected:
  OrganizedCloud Seen(const Painting& painting) const {
    SyntheticDepth scene(SmallCamera());
    scene.AddMesh(BoxMesh({kSide_m, kSide_m, 0.02}, Eigen::Vector3d::Zero()), X_CO_);
    OrganizedCloud cloud =
        BuildCloud(scene.frame(), std::nullopt, CloudOptions{.min_plane_share = 1});
    cloud.color = Image<Rgb8>(cloud.depth_m.width(), cloud.depth_m.height());
    for (size_t i = 0; i < cloud.points_C.size(); ++i) {
      if (!(cloud.depth_m.data()[i] > 0)) continue;
      const Eigen::Vector3d p_O = X_CO_.inverse() * cloud.points_C[i].cast<double>();
      cloud.color.data()[i] = painting(PlaceOnPrint(p_O));
    }
    return cloud;
  }
  std::optional<double> CorrelationWith(const Painting& painting) const {
    return PrintCorrelation(Seen(painting), model_, X_CO_);
  }

  Image<Rgb8> print_ = RandomPrint(1), other_ = RandomPrint(2);
  std::shared_ptr<const ObjectModel> object_ = ObjectOf(PrintedSlab(print_));
  ModelPoints model_ = MakeModelPoints(*object_);
  Pose X_CO_ = Translation({0, 0, 0.4});
};

TEST_F(PrintOfASlab, IsFoundWhereItIsAndNotInAnother) {
  EXPECT_GT(CorrelationWith(Showing(print_)), 0.9);
  EXPECT_LT(CorrelationWith(Showing(other_)), 0.35);
  EXPECT_LT(CorrelationWith([](const auto&) { return kGrey; }), 0.2);
}

TEST_F(PrintOfASlab, NeitherStrengthNorTintOfTheLightMatters) {
  const auto lit = [&](const Eigen::Vector2d& uv) {
    const Rgb8 color = Showing(print_)(uv);
    return Rgb8{static_cast<uint8_t>(20 + 0.7 * color.r), static_cast<uint8_t>(20 + 0.3 * color.g),
                static_cast<uint8_t>(0.5 * color.b)};
  };
  EXPECT_GT(CorrelationWith(lit), 0.85);
}

// The best would be 0 by chance alone; what is told is by how much less it may be meant.
TEST_F(PrintOfASlab, FewerPointsSayLess) {
  OrganizedCloud cloud = Seen([](const auto&) { return kGrey; });
  const double whole = *PrintCorrelation(cloud, model_, X_CO_);
  for (int y = 0; y < cloud.depth_m.height(); ++y) {
    for (int x = 0; x < cloud.depth_m.width() / 2; ++x) cloud.depth_m(x, y) = 0;
  }
  EXPECT_GT(*PrintCorrelation(cloud, model_, X_CO_), whole);
}

TEST_F(PrintOfASlab, SaysNothingWhereThereIsNothingToTell) {
  OrganizedCloud cloud = Seen(Showing(print_));
  EXPECT_FALSE(PrintCorrelation(cloud, model_, Translation({0, 0, 0.3}))) << "in front of it";
  const auto plain = ObjectOf(BoxMesh({kSide_m, kSide_m, 0.02}, Eigen::Vector3d::Zero()));
  EXPECT_FALSE(PrintCorrelation(cloud, MakeModelPoints(*plain), X_CO_));
  const auto one_colour = ObjectOf(PrintedSlab(Image<Rgb8>(8, 8, kGrey)));
  EXPECT_FALSE(PrintCorrelation(cloud, MakeModelPoints(*one_colour), X_CO_));
  cloud.color = {};
  EXPECT_FALSE(PrintCorrelation(cloud, model_, X_CO_));
}

// Depth does not tell which way up a symmetric part lies, so that either may be reported.
TEST_F(PrintOfASlab, IsLookedForAtEverySymmetricPose) {
  const Pose half_turn(Eigen::AngleAxisd(std::numbers::pi, Eigen::Vector3d::UnitZ()));
  const auto turned = [&](const Eigen::Vector2d& uv) {
    return Showing(print_)(Eigen::Vector2d(1, 1) - uv);
  };
  EXPECT_LT(CorrelationWith(turned), 0.5);
  ObjectModel symmetric = *object_;
  symmetric.symmetries_O.discrete_O = {half_turn};
  model_ = MakeModelPoints(symmetric);
  EXPECT_GT(CorrelationWith(turned), 0.9);
  EXPECT_GT(CorrelationWith(Showing(print_)), 0.9);
}

TEST_F(PrintOfASlab, MayBeOfColouredVertices) {
  ObjectModel coloured = *object_;
  TriangleMesh& mesh = coloured.mesh_O;
  mesh.uvs.clear();
  mesh.texture = {};
  // Red grows with x, green with y.
  for (const Eigen::Vector3d& vertex : mesh.vertices) {
    mesh.colors.push_back({static_cast<uint8_t>(vertex.x() > 0 ? 250 : 0),
                           static_cast<uint8_t>(vertex.y() > 0 ? 250 : 0), 90});
  }
  model_ = MakeModelPoints(coloured);
  const auto as_told = [](const Eigen::Vector2d& uv) {
    return Rgb8{static_cast<uint8_t>(250 * uv.x()), static_cast<uint8_t>(250 * uv.y()), 90};
  };
  const auto swapped = [](const Eigen::Vector2d& uv) {
    return Rgb8{static_cast<uint8_t>(250 * uv.y()), static_cast<uint8_t>(250 * uv.x()), 90};
  };
  EXPECT_GT(CorrelationWith(as_told), 0.95);
  EXPECT_LT(CorrelationWith(swapped), 0.3);
}

TEST_F(PrintOfASlab, AForeignThingOfTheSameShapeScoresLess) {
  Verifier sure;  // 0.95, whatever it is shown
  sure.mean = Eigen::VectorXf::Zero(kVerifyFeatures);
  sure.scale = Eigen::VectorXf::Ones(kVerifyFeatures);
  sure.w1 = Eigen::MatrixXf::Zero(1, kVerifyFeatures);
  sure.b1 = sure.w2 = Eigen::VectorXf::Zero(1);
  sure.b2 = 3;
  Candidate candidate;
  candidate.hypothesis.X_CO = X_CO_;
  const auto score = [&](const Painting& painting, double least) {
    return CandidateScore(Seen(painting), model_, sure, candidate, CandidateMode::kHard, least);
  };
  const Painting grey = [](const auto&) { return kGrey; };
  EXPECT_EQ(score(Showing(print_), 0), sure.Score({}));
  EXPECT_LT(score(grey, 0), 0.1);
  EXPECT_EQ(score(grey, 0.99), sure.Score({})) << "less than is asked for: it is not looked at";
}

TEST(ScoreWithPrint, FallsWithWhatIsMissingAndNeverRises) {
  EXPECT_EQ(ScoreWithPrint(0.9, std::nullopt), 0.9);
  double before = 0;
  for (double correlation = -1; correlation <= 1; correlation += 0.125) {
    const double score = ScoreWithPrint(0.9, correlation);
    EXPECT_GE(score, before);
    EXPECT_LE(score, 0.9);
    before = score;
  }
  EXPECT_EQ(before, 0.9);
  EXPECT_LT(ScoreWithPrint(0.9, 0), 0.01);
  for (const double certain : {0.0, 1.0}) {
    EXPECT_TRUE(std::isfinite(ScoreWithPrint(certain, 0)));
    EXPECT_LE(ScoreWithPrint(certain, 0), certain);
  }
}

}  // namespace
}  // namespace pickbed
