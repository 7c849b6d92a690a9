#include "grasp/tolerance/tolerance_model.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <numbers>
#include <regex>

#include "scenes/base/error.h"
#include "scenes/base/files.h"
#include "scenes/base/random.h"
#include "tests/grasp/grasp_scenes.h"
#include "tests/support/error_of.h"
#include "tests/support/temporary_folder.h"

namespace pickbed::tests {
namespace {

constexpr double kPi = std::numbers::pi;

std::shared_ptr<ObjectModel> Box() {
  return std::make_shared<ObjectModel>(*BoxObject({0.04, 0.03, 0.02}, 0.1));
}

PoseOffset Error(double x, double y, double z, double rx = 0, double ry = 0, double rz = 0) {
  PoseOffset error;
  error << x, y, z, rx, ry, rz;
  return error;
}

PoseOffset RandomError(Rng& rng, double length_m, double angle_rad) {
  PoseOffset error;
  for (int i = 0; i < 3; ++i) error[i] = rng.Uniform(-length_m, length_m);
  for (int i = 3; i < 6; ++i) error[i] = rng.Uniform(-angle_rad, angle_rad);
  return error;
}

// Outcomes of a known rule: an ellipsoid in the error relative to the hand, with half axes of 4 mm
// along the closing direction, 12 mm across, 8 mm along the approach, and 0.4 rad about each axis.
// Success is a radius below 1.
double PlantedRadius(const PoseOffset& error_G) {
  const PoseOffset half = Error(0.004, 0.012, 0.008, 0.4, 0.4, 0.4);
  return error_G.cwiseQuotient(half).norm();
}

ToleranceModel PlantedModel(const std::vector<Pose>& X_OG, int count = 3000) {
  ToleranceModel model = EmptyToleranceModel(*Box(), "test jaw", X_OG);
  Rng rng(1);
  std::vector<ToleranceSample> samples;
  for (int i = 0; i < count; ++i) {
    const PoseOffset error = rng.Uniform() * RandomError(rng, 0.02, 0.6);
    samples.push_back({error, PlantedRadius(error) < 1, i % 40});
  }
  FitTolerance(samples, {}, model);
  return model;
}

TEST(Tolerance, PoseOffsetConvertsToPoseAndBack) {
  Rng rng(3);
  for (int i = 0; i < 200; ++i) {
    const PoseOffset error = RandomError(rng, 0.1, 1.7);
    EXPECT_LT((ToPoseOffset(ToPose(error)) - error).norm(), 1e-12);
  }
  EXPECT_TRUE(ToPose(PoseOffset::Zero()).isApprox(Pose::Identity()));
}

TEST(Tolerance, FindsThePlantedRegionAlongEachAxis) {
  const ToleranceModel model = PlantedModel({Pose::Identity()});
  EXPECT_GT(SuccessProbability(model, Pose::Identity()), 0.97);
  // The probability crosses 0.5 near the limits of the planted rule.
  const double ends[] = {0.004, 0.012, 0.008, 0.4, 0.4, 0.4};
  for (int axis = 0; axis < 6; ++axis) {
    for (const double sign : {-1.0, 1.0}) {
      PoseOffset error = PoseOffset::Zero();
      error[axis] = 0.6 * sign * ends[axis];
      EXPECT_GT(SuccessProbability(model, ToPose(error)), 0.6) << axis;
      error[axis] = 1.6 * sign * ends[axis];
      EXPECT_LT(SuccessProbability(model, ToPose(error)), 0.4) << axis;
    }
  }
}

TEST(Tolerance, ClassifiesPlantedOutcomes) {
  const ToleranceModel model = PlantedModel({Pose::Identity()});
  Rng rng(9);
  int right = 0, samples = 2000;
  for (int i = 0; i < samples; ++i) {
    const PoseOffset error = rng.Uniform() * RandomError(rng, 0.02, 0.6);
    right += (SuccessProbability(model, ToPose(error)) > 0.5) == (PlantedRadius(error) < 1);
  }
  EXPECT_GT(right, 0.93 * samples);
}

TEST(Tolerance, SmallRandomSamplesAreRegularized) {
  // Outcomes without any rule: the ridge must suppress the apparent rule of a small sample.
  Rng rng(11);
  std::vector<ToleranceSample> samples;
  for (int i = 0; i < 120; ++i) {
    samples.push_back({RandomError(rng, 0.02, 0.6), rng.Uniform() < 0.5, i % 10});
  }
  ToleranceFitOptions none;
  none.ridges = 1;
  none.min_ridge = 1e-3;
  const auto spread = [&](const ToleranceFitOptions& options) {
    ToleranceModel model = EmptyToleranceModel(*Box(), "", {Pose::Identity()});
    FitTolerance(samples, options, model);
    Rng draw(12);
    double sum = 0;
    for (int i = 0; i < 200; ++i) {
      sum += std::abs(SuccessProbability(model, ToPose(RandomError(draw, 0.02, 0.6))) - 0.5);
    }
    return sum / 200;
  };
  EXPECT_LT(spread({}), 0.15);
  EXPECT_LT(spread({}), 0.5 * spread(none));
}

TEST(Tolerance, ErrorIsMeasuredInTheHandFrame) {
  // The closing direction x of the hand is y of the object: 8 mm along y fail, along x they
  // succeed.
  const Pose X_OG = MakePose(
      Eigen::AngleAxisd(kPi / 2, Eigen::Vector3d::UnitZ()).toRotationMatrix(), {0.1, 0.2, 0.3});
  const ToleranceModel model = PlantedModel({X_OG});
  EXPECT_GT(SuccessProbability(model, ToPose(Error(0.008, 0, 0))), 0.6);
  EXPECT_LT(SuccessProbability(model, ToPose(Error(0, 0.008, 0))), 0.2);
  // With two equally frequent grasps, the probability is the mean of both.
  const ToleranceModel both = PlantedModel({X_OG, Pose::Identity()});
  const Pose X = ToPose(Error(0, 0.008, 0));
  EXPECT_NEAR(
      SuccessProbability(both, X),
      0.5 * (SuccessProbability(both, X, X_OG) + SuccessProbability(both, X, Pose::Identity())),
      1e-12);
  EXPECT_GT(SuccessProbability(both, X, Pose::Identity()), 0.6);
}

TEST(Tolerance, AmbiguousPosesHaveTheSameProbability) {
  auto box = Box();
  box->symmetries_O.discrete_O = {Pose(Eigen::AngleAxisd(kPi, Eigen::Vector3d::UnitZ())),
                                  Pose(Eigen::AngleAxisd(kPi, Eigen::Vector3d::UnitX())),
                                  Pose(Eigen::AngleAxisd(kPi, Eigen::Vector3d::UnitY()))};
  ToleranceModel model = PlantedModel({Pose::Identity()});
  const double without = SuccessProbability(model, box->symmetries_O.discrete_O[0]);
  const ToleranceModel known = EmptyToleranceModel(*box, "test jaw", {Pose::Identity()});
  model.symmetry_inverses_O = known.symmetry_inverses_O;
  Rng rng(4);
  for (int i = 0; i < 50; ++i) {
    const Pose X = ToPose(RandomError(rng, 0.006, 0.2));
    for (const Pose& S : box->symmetries_O.discrete_O) {
      EXPECT_NEAR(SuccessProbability(model, S * X), SuccessProbability(model, X), 1e-9);
      EXPECT_TRUE(NearestError(model, S * X).isApprox(X, 1e-9));
    }
  }
  EXPECT_LT(without, 0.1);
  EXPECT_GT(SuccessProbability(model, box->symmetries_O.discrete_O[0]), 0.97);
}

TEST(Tolerance, RotationAboutAContinuousAxisIsNoError) {
  auto rod = Box();
  rod->symmetries_O.continuous_O = {{Eigen::Vector3d::UnitZ(), Eigen::Vector3d::Zero()}};
  ToleranceModel model = PlantedModel({Pose::Identity()});
  model.symmetry_inverses_O = EmptyToleranceModel(*rod, "", {Pose::Identity()}).symmetry_inverses_O;
  for (const double angle : {0.5, 1.3, 2.9, -2.0}) {
    const Pose rotated(Eigen::AngleAxisd(angle, Eigen::Vector3d::UnitZ()));
    // Up to half a step of the discretized axis.
    EXPECT_LT(ToPoseOffset(NearestError(model, rotated)).norm(), 0.0101) << angle;
    EXPECT_GT(SuccessProbability(model, rotated), 0.95) << angle;
  }
}

TEST(Tolerance, SurfaceMomentsOfABoxMatchTheFormula) {
  // For the faces of a box a x b x c: E[x^2] = (a^2/12 (ab + ac) + a^2/4 bc) / (ab + bc + ca).
  const double a = 0.04, b = 0.03, c = 0.02;
  const ToleranceModel model = EmptyToleranceModel(*Box(), "", {Pose::Identity()});
  const double area = a * b + b * c + c * a;
  EXPECT_LT(model.surface_mean_O.norm(), 1e-12);
  EXPECT_NEAR(model.surface_covariance_O(0, 0),
              (a * a / 12 * (a * b + a * c) + a * a / 4 * b * c) / area, 1e-12);
  EXPECT_NEAR(model.surface_covariance_O(2, 2),
              (c * c / 12 * (c * b + a * c) + c * c / 4 * a * b) / area, 1e-12);
  EXPECT_NEAR(model.surface_covariance_O(0, 1), 0, 1e-12);
}

TEST(Tolerance, ModelFileReadsBackUnchanged) {
  TemporaryFolder folder;
  auto box = Box();
  box->symmetries_O.discrete_O = {Pose(Eigen::AngleAxisd(kPi, Eigen::Vector3d::UnitZ()))};
  ToleranceModel model = PlantedModel(
      {Pose::Identity(),
       MakePose(Eigen::AngleAxisd(0.7, Eigen::Vector3d(1, 2, 3).normalized()).toRotationMatrix(),
                {0.01, -0.02, 0.03})},
      500);
  model.symmetries_O = box->symmetries_O;
  model.symmetry_inverses_O = InverseSymmetries(model.symmetries_O);
  const auto file = folder.path() / "model.yaml";
  WriteToleranceModel(file, model);
  const ToleranceModel read = ReadToleranceModel(file);
  EXPECT_EQ(read.object, model.object);
  EXPECT_EQ(read.gripper, model.gripper);
  EXPECT_EQ(read.weights, model.weights);
  Rng rng(2);
  for (int i = 0; i < 20; ++i) {
    const Pose X = ToPose(RandomError(rng, 0.01, 3));
    EXPECT_NEAR(SuccessProbability(read, X), SuccessProbability(model, X), 1e-9);
  }
}

// Files of an earlier version have no names of the terms. A wrong name is an error, because the
// weights have a fixed order.
TEST(Tolerance, ModelFileNamesTheTerms) {
  const std::vector<std::string>& terms = ToleranceTerms();
  const ToleranceModel model = PlantedModel({Pose::Identity()}, 500);
  ASSERT_EQ(terms.size(), model.weights.size());
  EXPECT_EQ(terms[0], "1");
  EXPECT_EQ(terms[2], "x**2");
  EXPECT_EQ(terms[14], "z*abs(z)");
  EXPECT_EQ(terms.back(), "abs(ry*rz)");
  TemporaryFolder folder;
  const auto file = folder.path() / "model.yaml";
  WriteToleranceModel(file, model);
  const std::string text = ReadFileBytes(file);
  EXPECT_THAT(text, testing::HasSubstr("abs(x*rz)"));
  std::ofstream(file) << std::regex_replace(text, std::regex("term: [^,\n}]*(, |\n *)?"), "");
  EXPECT_THAT(ReadFileBytes(file), testing::Not(testing::HasSubstr("term")));
  EXPECT_EQ(ReadToleranceModel(file).weights, model.weights);
  std::ofstream(file) << std::regex_replace(text, std::regex("term: [^,\n}]*(, |\n *)?"), "",
                                            std::regex_constants::format_first_only);
  EXPECT_THAT(ErrorOf([&] { ReadToleranceModel(file); }),
              testing::HasSubstr("weights have a term; make the file again"));
  std::ofstream(file) << std::regex_replace(text, std::regex("x\\*\\*2"), "y**2");
  EXPECT_THAT(ErrorOf([&] { ReadToleranceModel(file); }),
              testing::HasSubstr("weights.2.term 'y**2'"));
}

TEST(Tolerance, WrongPosesAndAxesOfAFileAreRefused) {
  TemporaryFolder folder;
  const auto file = folder.path() / "model.yaml";
  const ToleranceModel sound = PlantedModel({Pose::Identity()}, 500);
  const auto error_of = [&](const ToleranceModel& model) {
    WriteToleranceModel(file, model);
    return ErrorOf([&] { ReadToleranceModel(file); });
  };
  EXPECT_EQ(error_of(sound), "no error");
  ToleranceModel grasp = sound, turn = sound, axis = sound;
  grasp.X_OG[0].linear().col(0) *= 3;
  turn.symmetries_O.discrete_O = {Pose::Identity()};
  turn.symmetries_O.discrete_O[0].linear().col(2).x() = 0.1;
  axis.symmetries_O.continuous_O = {{Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero()}};
  EXPECT_THAT(error_of(grasp), testing::HasSubstr("model.yaml: x and z of a grasp"));
  EXPECT_THAT(error_of(turn), testing::HasSubstr("model.yaml: x and z of a grasp"));
  EXPECT_THAT(error_of(axis), testing::HasSubstr("model.yaml: an axis of symmetry_axes"));
}

TEST(Tolerance, InvalidModelFileIsRefused) {
  TemporaryFolder folder;
  const auto file = folder.path() / "other.yaml";
  std::ofstream(file) << "kind: pickbed tolerance model 1\nobject: rod\n";
  EXPECT_THAT(ErrorOf([&] { ReadToleranceModel(file); }),
              testing::AllOf(testing::HasSubstr("other.yaml"), testing::HasSubstr("0 weights")));
  std::ofstream(file) << "kind: something else\n";
  EXPECT_THAT(ErrorOf([&] { ReadToleranceModel(file); }), testing::HasSubstr("kind"));
  ToleranceModel model = EmptyToleranceModel(*Box(), "", {Pose::Identity()});
  EXPECT_THROW(FitTolerance({}, {}, model), InputError);
}

}  // namespace
}  // namespace pickbed::tests
