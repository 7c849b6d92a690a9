#include "perception/model/surface_texture.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numbers>

#include "perception/candidates/pose_selection.h"
#include "scenes/base/random.h"
#include "tests/support/synthetic_depth.h"

namespace pickbed::tests {
namespace {

constexpr double kSide_m = 0.08;
constexpr Rgb8 kGrey{176, 176, 180};

// A texture of squares in random colors.
Image<Rgb8> RandomTexture(uint64_t seed) {
  constexpr int kTexels = 64, kSquare = 16;
  Rng rng(seed);
  Image<Rgb8> texture(kTexels, kTexels);
  for (int y = 0; y < kTexels; y += kSquare) {
    for (int x = 0; x < kTexels; x += kSquare) {
      const auto channel = [&] { return static_cast<uint8_t>(rng.Index(256)); };
      const Rgb8 color{channel(), channel(), channel()};
      for (int i = 0; i < kSquare * kSquare; ++i) texture(x + i % kSquare, y + i / kSquare) = color;
    }
  }
  return texture;
}

Eigen::Vector2d TextureCoordinates(const Eigen::Vector3d& p_O) {
  return {p_O.x() / kSide_m + 0.5, p_O.y() / kSide_m + 0.5};
}

// A slab of 80 x 80 x 20 mm with the same texture on its two large sides.
TriangleMesh SlabWithTexture(const Image<Rgb8>& texture) {
  TriangleMesh mesh = BoxMesh({kSide_m, kSide_m, 0.02}, Eigen::Vector3d::Zero());
  for (const Eigen::Vector3d& vertex : mesh.vertices)
    mesh.uvs.push_back(TextureCoordinates(vertex));
  mesh.texture = texture;
  return mesh;
}

// Color of a pixel as a function of its texture coordinates on the slab. The slab faces the camera
// at 0.4 m.
using Painting = std::function<Rgb8(const Eigen::Vector2d& uv)>;

Painting Showing(const Image<Rgb8>& texture) {
  return [&texture](const Eigen::Vector2d& uv) {
    const auto texel = [](double share, int size) {
      return std::clamp(static_cast<int>(share * size), 0, size - 1);
    };
    return texture(texel(uv.x(), texture.width()), texel(uv.y(), texture.height()));
  };
}

class TexturedSlab : public ::testing::Test {
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
      cloud.color.data()[i] = painting(TextureCoordinates(p_O));
    }
    return cloud;
  }
  std::optional<double> CorrelationWith(const Painting& painting) const {
    return TextureCorrelation(Seen(painting), model_, X_CO_);
  }

  Image<Rgb8> texture_ = RandomTexture(1), other_ = RandomTexture(2);
  std::shared_ptr<const ObjectModel> object_ = ObjectOf(SlabWithTexture(texture_));
  ModelPoints model_ = MakeModelPoints(*object_);
  Pose X_CO_ = Translation({0, 0, 0.4});
};

TEST_F(TexturedSlab, CorrelationIsHighOnlyForItsTexture) {
  EXPECT_GT(CorrelationWith(Showing(texture_)), 0.9);
  EXPECT_LT(CorrelationWith(Showing(other_)), 0.35);
  EXPECT_LT(CorrelationWith([](const auto&) { return kGrey; }), 0.2);
}

TEST_F(TexturedSlab, StrengthAndTintOfTheLightDoNotMatter) {
  const auto lit = [&](const Eigen::Vector2d& uv) {
    const Rgb8 color = Showing(texture_)(uv);
    return Rgb8{static_cast<uint8_t>(20 + 0.7 * color.r), static_cast<uint8_t>(20 + 0.3 * color.g),
                static_cast<uint8_t>(0.5 * color.b)};
  };
  EXPECT_GT(CorrelationWith(lit), 0.85);
}

// The true correlation is 0 and the measured one is random. Its standard error is added, and it is
// larger for fewer points.
TEST_F(TexturedSlab, FewerPointsGiveWeakerEvidence) {
  OrganizedCloud cloud = Seen([](const auto&) { return kGrey; });
  const double whole = *TextureCorrelation(cloud, model_, X_CO_);
  for (int y = 0; y < cloud.depth_m.height(); ++y) {
    for (int x = 0; x < cloud.depth_m.width() / 2; ++x) cloud.depth_m(x, y) = 0;
  }
  EXPECT_GT(*TextureCorrelation(cloud, model_, X_CO_), whole);
}

TEST_F(TexturedSlab, NoCorrelationWithoutTextureOrColor) {
  OrganizedCloud cloud = Seen(Showing(texture_));
  EXPECT_FALSE(TextureCorrelation(cloud, model_, Translation({0, 0, 0.3}))) << "in front of it";
  const auto plain = ObjectOf(BoxMesh({kSide_m, kSide_m, 0.02}, Eigen::Vector3d::Zero()));
  EXPECT_FALSE(TextureCorrelation(cloud, MakeModelPoints(*plain), X_CO_));
  const auto one_color = ObjectOf(SlabWithTexture(Image<Rgb8>(8, 8, kGrey)));
  EXPECT_FALSE(TextureCorrelation(cloud, MakeModelPoints(*one_color), X_CO_));
  cloud.color = {};
  EXPECT_FALSE(TextureCorrelation(cloud, model_, X_CO_));
}

// Depth does not determine the orientation of a symmetric object, so any symmetric pose may be
// reported.
TEST_F(TexturedSlab, EverySymmetricPoseIsTried) {
  const Pose half_turn(Eigen::AngleAxisd(std::numbers::pi, Eigen::Vector3d::UnitZ()));
  const auto turned = [&](const Eigen::Vector2d& uv) {
    return Showing(texture_)(Eigen::Vector2d(1, 1) - uv);
  };
  EXPECT_LT(CorrelationWith(turned), 0.5);
  ObjectModel symmetric = *object_;
  symmetric.symmetries_O.discrete_O = {half_turn};
  model_ = MakeModelPoints(symmetric);
  EXPECT_GT(CorrelationWith(turned), 0.9);
  EXPECT_GT(CorrelationWith(Showing(texture_)), 0.9);
}

TEST_F(TexturedSlab, VertexColorsAreSupported) {
  ObjectModel colored = *object_;
  TriangleMesh& mesh = colored.mesh_O;
  mesh.uvs.clear();
  mesh.texture = {};
  // Red increases with x, green with y.
  for (const Eigen::Vector3d& vertex : mesh.vertices) {
    mesh.colors.push_back({static_cast<uint8_t>(vertex.x() > 0 ? 250 : 0),
                           static_cast<uint8_t>(vertex.y() > 0 ? 250 : 0), 90});
  }
  model_ = MakeModelPoints(colored);
  const auto matching = [](const Eigen::Vector2d& uv) {
    return Rgb8{static_cast<uint8_t>(250 * uv.x()), static_cast<uint8_t>(250 * uv.y()), 90};
  };
  const auto swapped = [](const Eigen::Vector2d& uv) {
    return Rgb8{static_cast<uint8_t>(250 * uv.y()), static_cast<uint8_t>(250 * uv.x()), 90};
  };
  EXPECT_GT(CorrelationWith(matching), 0.95);
  EXPECT_LT(CorrelationWith(swapped), 0.3);
}

TEST_F(TexturedSlab, DistractorOfTheSameShapeScoresLess) {
  Verifier sure;  // score 0.95 for any features
  sure.known.mean = Eigen::VectorXf::Zero(kVerifyFeatures);
  sure.known.scale = Eigen::VectorXf::Ones(kVerifyFeatures);
  sure.known.w1 = Eigen::MatrixXf::Zero(1, kVerifyFeatures);
  sure.known.b1 = sure.known.w2 = Eigen::VectorXf::Zero(1);
  sure.known.b2 = 3;
  sure.unknown = sure.known;
  Candidate candidate;
  candidate.hypothesis.X_CO = X_CO_;
  const PoseDistance distance(*object_);
  const auto score = [&](const Painting& painting, double min_score) {
    PoseSelectionOptions options;
    options.min_score = min_score;
    return CandidateScores(Seen(painting), {model_}, {distance}, {&sure, 1}, {candidate}, options)
        .at(0);
  };
  const Painting grey = [](const auto&) { return kGrey; };
  EXPECT_EQ(score(Showing(texture_), 0), sure.Score({}));
  EXPECT_LT(score(grey, 0), 0.1);
  EXPECT_EQ(score(grey, 0.99), sure.Score({}))
      << "below the minimum score: the texture is not compared";
}

TEST(ScoreWithTexture, ScoreFallsWithCorrelationAndNeverRises) {
  EXPECT_EQ(ScoreWithTexture(0.9, std::nullopt), 0.9);
  double before = 0;
  for (double correlation = -1; correlation <= 1; correlation += 0.125) {
    const double score = ScoreWithTexture(0.9, correlation);
    EXPECT_GE(score, before);
    EXPECT_LE(score, 0.9);
    before = score;
  }
  EXPECT_EQ(before, 0.9);
  EXPECT_LT(ScoreWithTexture(0.9, 0), 0.01);
  for (const double certain : {0.0, 1.0}) {
    EXPECT_TRUE(std::isfinite(ScoreWithTexture(certain, 0)));
    EXPECT_LE(ScoreWithTexture(certain, 0), certain);
  }
}

}  // namespace
}  // namespace pickbed::tests
