#include "eval/cell/cell_errors.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "eval/cell/simulated_cell.h"
#include "eval/summary/run_csv.h"
#include "eval/trial/estimator_runner.h"
#include "eval/trial/recorded_scene.h"
#include "eval/trial/trial.h"
#include "grasp/grippers/suction_cup.h"
#include "grasp/grippers/table.h"
#include "grasp/grippers/tools.h"
#include "scenes/base/math.h"
#include "scenes/objects/contact.h"
#include "tests/eval/cube_scenario.h"
#include "tests/grasp/grasp_scenes.h"
#include "tests/support/error_of.h"

namespace pickbed::tests {
namespace {

using Eigen::Vector3d;
using testing::HasSubstr;

CellErrorsSpec AllCellErrors() {
  CellErrorsSpec spec;
  spec.hand_eye_mm = spec.bin_mm = 1;
  spec.hand_eye_deg = spec.bin_deg = 0.2;
  spec.focal_percent = spec.depth_scale_percent = 0.1;
  spec.principal_px = spec.depth_bias_mm = spec.repeatability_mm = 0.5;
  spec.force_percent = spec.friction_percent = spec.mass_percent = 10;
  spec.size_percent = 2;
  return spec;
}

TrialResult RunWith(const CellErrorsSpec& errors, int cubes = 3, int bin = 0) {
  ScenarioSpec spec = CubeScenario(cubes);
  spec.cell = errors;
  return TrialRunner(spec, EasyCube()).Run(BinIndex(bin));
}

// True pose of the instance that a hypothesis matches.
Pose TruePoseOf(const HypothesisRecord& hypothesis, const Scene& scene) {
  for (const PosedObject& posed : scene.objects) {
    if (posed.instance == hypothesis.instance) return posed.X_WO;
  }
  throw std::out_of_range("the hypothesis matches no instance");
}

TEST(CellErrors, DrawsDependOnlyOnSeedBinAndAttempt) {
  const CellErrorsSpec spec = AllCellErrors();
  const BinIndex bin{4};
  const AttemptErrors third = DrawAttemptErrors(spec, 7, bin, 2);
  DrawAttemptErrors(spec, 7, bin, 0);
  EXPECT_EQ(DrawAttemptErrors(spec, 7, bin, 2).robot_m, third.robot_m) << "in any order";
  EXPECT_EQ(DrawAttemptErrors(spec, 7, bin, 2).force, third.force);
  EXPECT_NE(DrawAttemptErrors(spec, 7, bin, 3).robot_m, third.robot_m);
  EXPECT_NE(DrawAttemptErrors(spec, 7, BinIndex{5}, 2).robot_m, third.robot_m);
  EXPECT_NE(DrawAttemptErrors(spec, 8, bin, 2).robot_m, third.robot_m);
  EXPECT_EQ(DrawBinErrors(spec, 7, bin).hand_eye_m, DrawBinErrors(spec, 7, bin).hand_eye_m);
  EXPECT_NE(DrawBinErrors(spec, 7, bin).hand_eye_m, DrawBinErrors(spec, 7, BinIndex{5}).hand_eye_m);
  EXPECT_NE(DrawDeviation(spec, 7, bin, InstanceId{0}), DrawDeviation(spec, 7, bin, InstanceId{1}));
}

// So a sweep of one error compares cells that differ only in it.
TEST(CellErrors, SettingScalesItsOwnDrawAndNoOther) {
  const CellErrorsSpec all = AllCellErrors();
  CellErrorsSpec one;
  one.hand_eye_mm = 3 * all.hand_eye_mm;
  for (int bin = 0; bin < 5; ++bin) {
    const BinErrors a = DrawBinErrors(all, 7, BinIndex(bin));
    const BinErrors b = DrawBinErrors(one, 7, BinIndex(bin));
    EXPECT_TRUE(b.hand_eye_m.isApprox(3 * a.hand_eye_m, 1e-12));
    EXPECT_TRUE(b.hand_eye_rotation_rad.isZero(0));
    EXPECT_TRUE(b.bin_m.isZero(0));
    EXPECT_EQ(b.depth_scale, 0);
  }
  CellErrorsSpec mass;
  mass.mass_percent = all.mass_percent;
  EXPECT_EQ(DrawDeviation(mass, 7, BinIndex{0}, InstanceId{3}).mass,
            DrawDeviation(all, 7, BinIndex{0}, InstanceId{3}).mass);
}

TEST(CellErrors, SettingIsTheStandardDeviationOfTheDraws) {
  constexpr int kBins = 4000;
  const CellErrorsSpec spec = AllCellErrors();
  double position = 0, angle = 0, force = 0, size = 0, largest_mm = 0;
  for (int bin = 0; bin < kBins; ++bin) {
    const BinErrors errors = DrawBinErrors(spec, 1, BinIndex(bin));
    position += errors.hand_eye_m.squaredNorm() / 3;
    angle += errors.hand_eye_rotation_rad.squaredNorm();
    largest_mm = std::max(largest_mm, 1e3 * errors.hand_eye_m.cwiseAbs().maxCoeff());
    force += std::pow(DrawAttemptErrors(spec, 1, BinIndex(bin), 0).force, 2);
    size += std::pow(DrawSizes(spec, 1, BinIndex(bin), 1)[0], 2);
  }
  // The limit of 3 standard deviations lowers the deviation by 0.7 %.
  EXPECT_NEAR(1e3 * std::sqrt(position / kBins), 1, 0.03);
  EXPECT_NEAR(Degrees(std::sqrt(angle / kBins)), 0.2, 0.01);
  EXPECT_NEAR(std::sqrt(force / kBins), 0.1, 0.005);
  EXPECT_NEAR(std::sqrt(size / kBins), 0.02, 0.001);
  EXPECT_LE(largest_mm, CellErrorsSpec::kMaxDeviate + 1e-9);
  EXPECT_GT(largest_mm, CellErrorsSpec::kMaxDeviate - 0.2) << "the limit was not reached";
}

TEST(CellErrors, ExactCellHasTheTrueCalibrationInEveryBit) {
  const SimulatedCell cell(CubeScenario(1), EasyCube());
  const CellCalibration calibration = CalibrationOf(cell.camera(), cell.ErrorsOf(BinIndex{3}));
  EXPECT_EQ(calibration.camera.intrinsics, cell.camera().intrinsics);
  EXPECT_EQ(calibration.camera.X_WC().matrix(), cell.camera().X_WC().matrix());
  EXPECT_EQ(calibration.X_BD().matrix(), cell.camera().X_WC().matrix());
  EXPECT_EQ(calibration.Background(cell.bin()).X_CB.matrix(), cell.camera().X_CW().matrix());
  EXPECT_FALSE(calibration.X_WB.has_value());
  EXPECT_EQ(cell.TrueObjects(BinIndex{3})[0], cell.objects()[0]) << "not a copy";
}

// The oracle estimator has no error of its own.
TEST(CellErrors, ExecutedGraspMissesByTheDrawnHandEyeOffset) {
  CellErrorsSpec errors;
  errors.hand_eye_mm = 2;
  const TrialResult result = RunWith(errors);
  const SimulatedCell cell(CubeScenario(3), EasyCube());
  const Scene scene = cell.MakeScene(BinIndex{0}).scene;
  const Vector3d offset_W = cell.camera().X_WC().linear() * result.errors.hand_eye_m;
  ASSERT_GT(offset_W.norm(), 1e-4);
  const TrialResult exact = RunWith({});
  for (const HypothesisRecord& hypothesis : result.attempts[0].hypotheses) {
    const Pose X_WO = TruePoseOf(hypothesis, scene);
    EXPECT_TRUE((hypothesis.X_WO.translation() - X_WO.translation()).isApprox(offset_W, 1e-9));
    EXPECT_TRUE(hypothesis.X_OE.isApprox(X_WO.inverse() * hypothesis.X_WO, 1e-9));
    EXPECT_NEAR(hypothesis.translation_m(), 0, 1e-9) << "the estimator makes no error";
    EXPECT_TRUE(hypothesis.correct);
  }
  EXPECT_EQ(result.attempts[0].hashes[TrialStage::kImage],
            exact.attempts[0].hashes[TrialStage::kImage])
      << "the image is exact";
  ASSERT_TRUE(result.attempts[0].grasp && exact.attempts[0].grasp);
  EXPECT_NE(result.attempts[0].grasp->X_WG.matrix(), exact.attempts[0].grasp->X_WG.matrix());
}

// A rotated camera displaces a point by the chord at its distance from the axis of rotation.
TEST(CellErrors, HandEyeRotationDisplacesPointsByTheirChord) {
  CellErrorsSpec errors;
  errors.hand_eye_deg = 1;
  const BinErrors drawn = DrawBinErrors(errors, 5, BinIndex{1});
  const double angle_rad = drawn.hand_eye_rotation_rad.norm();
  ASSERT_GT(angle_rad, 1e-3);
  const Camera camera = SimulatedCell(CubeScenario(1), EasyCube()).camera();
  const Camera calibrated = CalibrationOf(camera, drawn).camera;
  const Vector3d p_C(0.05, -0.02, 0.8);
  const double arm_m = p_C.cross(drawn.hand_eye_rotation_rad / angle_rad).norm();
  EXPECT_NEAR((calibrated.X_WC() * p_C - camera.X_WC() * p_C).norm(),
              2 * arm_m * std::sin(0.5 * angle_rad), 1e-12);
}

TEST(CellErrors, DepthScaleMovesPosesByItsShareOfTheirDistance) {
  BinErrors errors;
  errors.depth_scale = 0.01;
  const CameraIntrinsics k;
  const Pose X_CO = Translation({0.1, -0.05, 0.8});
  const Pose seen = PoseInImage(X_CO, Vector3d::Zero(), k, k, errors);
  EXPECT_TRUE(seen.translation().isApprox(1.01 * X_CO.translation(), 1e-12));
  EXPECT_EQ(seen.linear(), X_CO.linear());

  ScenarioSpec spec = CubeScenario(2);
  spec.cell.depth_scale_percent = 1;
  SimulatedCell wrong(spec, EasyCube()), exact(CubeScenario(2), EasyCube());
  const BinIndex bin{0};
  const double factor = 1 + wrong.ErrorsOf(bin).depth_scale;
  const Scene scene = exact.MakeScene(bin).scene;
  const Image<float> a = exact.Capture(scene, bin, 0).frame.depth_m;
  const Image<float> b = wrong.Capture(scene, bin, 0).frame.depth_m;
  ASSERT_NE(factor, 1);
  for (size_t i = 0; i < a.size(); ++i) {
    ASSERT_NEAR(b.pixels()[i], factor * a.pixels()[i], 1e-6) << "holes stay holes";
  }
}

TEST(CellErrors, DepthBiasMovesPosesAlongTheirRay) {
  BinErrors errors;
  errors.depth_bias_m = 0.004;
  const CameraIntrinsics k;
  const Vector3d p_C(0.1, -0.05, 0.8);
  const Vector3d seen_C =
      PoseInImage(Translation(p_C), Vector3d::Zero(), k, k, errors).translation();
  EXPECT_NEAR(seen_C.z(), p_C.z() + 0.004, 1e-12);
  EXPECT_TRUE(Project(k, seen_C).isApprox(Project(k, p_C), 1e-12));
  Image<float> depth_m(2, 1);
  depth_m(0, 0) = 0.5f;
  AddDepthErrors(errors, depth_m);
  EXPECT_NEAR(depth_m(0, 0), 0.504, 1e-6);
  EXPECT_EQ(depth_m(1, 0), 0) << "no reading stays none";
  errors.depth_bias_m = -0.6;
  AddDepthErrors(errors, depth_m);
  EXPECT_EQ(depth_m(0, 0), 0) << "never negative";
}

TEST(CellErrors, IntrinsicsMovePosesAcrossTheRay) {
  BinErrors errors;
  errors.focal = 0.02;
  const Camera camera;
  const Vector3d p_C(0.1, -0.05, 0.8);
  const auto seen_with = [&](const BinErrors& drawn) -> Vector3d {
    const CameraIntrinsics calibrated = CalibrationOf(camera, drawn).camera.intrinsics;
    return PoseInImage(Translation(p_C), Vector3d::Zero(), camera.intrinsics, calibrated, drawn)
        .translation();
  };
  EXPECT_TRUE(seen_with(errors).isApprox(Vector3d(0.1 / 1.02, -0.05 / 1.02, 0.8), 1e-12));
  BinErrors shifted;
  shifted.principal_px = {3, -1};
  const double metres_per_px = 0.8 / camera.intrinsics.fx();
  EXPECT_TRUE(seen_with(shifted).isApprox(p_C + metres_per_px * Vector3d(-3, 1, 0), 1e-12));
}

TEST(CellErrors, EstimatorGetsTheCalibratedIntrinsicsAndTheAssumedBin) {
  ScenarioSpec spec = CubeScenario(2);
  spec.cell.focal_percent = 1;
  spec.cell.bin_mm = 5;
  SimulatedCell cell(spec, EasyCube());
  const BinIndex bin{0};
  const BinErrors errors = cell.ErrorsOf(bin);
  const Observation view = cell.Capture(cell.MakeScene(bin).scene, bin, 0);
  EXPECT_NEAR(view.frame.intrinsics.fx(), cell.camera().intrinsics.fx() * (1 + errors.focal), 1e-9);
  const Pose X_WB = cell.camera().X_WC() * view.calibration.Background(cell.bin()).X_CB;
  EXPECT_TRUE(X_WB.translation().isApprox(errors.bin_m, 1e-9));
}

// A pose beside the true wall is kept where the cell assumes the bin.
TEST(CellErrors, AssumedBinDecidesWhichPosesAreInside) {
  const SimulatedCell cell(CubeScenario(1), EasyCube());
  const auto kept = [&](const Vector3d& bin_m, const Vector3d& p_W) {
    BinErrors errors;
    errors.bin_m = bin_m;
    std::vector<PoseHypothesis> hypotheses{
        {ObjectId{0}, cell.camera().X_CW() * Translation(p_W), 0.9, {}}};
    RemoveOutsideBin(cell, CalibrationOf(cell.camera(), errors), hypotheses);
    return !hypotheses.empty();
  };
  const Vector3d beside(0.25, 0, 0.02);
  EXPECT_FALSE(kept({0, 0, 0}, beside));
  EXPECT_TRUE(kept({0.08, 0, 0}, beside));
}

TEST(CellErrors, BinPoseChangesTheGraspButNotThePoses) {
  CellErrorsSpec errors;
  errors.bin_mm = 60;
  const TrialResult exact = RunWith({}), wrong = RunWith(errors);
  EXPECT_EQ(exact.attempts[0].hashes[TrialStage::kHypotheses],
            wrong.attempts[0].hashes[TrialStage::kHypotheses]);
  EXPECT_NE(exact.attempts[0].hashes[TrialStage::kGrasp],
            wrong.attempts[0].hashes[TrialStage::kGrasp]);
}

// Tests of the execution: one box of 40 x 50 x 50 mm, and a jaw of 40 N with pads of friction 1.
class ExecuteWithErrorsTest : public testing::Test {
 protected:
  GraspOutcome Try(double mass_kg, const AttemptErrors& errors,
                   const InstanceDeviation& deviation = {}) const {
    const ObjectSet objects{BoxObject({0.040, 0.050, 0.050}, mass_kg, 0.2)};
    Scene scene = BoxesOnFloor({{0, 0}}, 0.050);
    scene.objects[0].deviation = deviation;
    Grasp grasp;
    grasp.X_WG = FromAbove({0, 0, 0.015});
    grasp.width_m = 0.040;
    return ExecuteWithErrors({scene, objects}, grasp, SmallJaw(), InstanceId{10}, {}, errors)
        .outcome;
  }
};

// The pads hold 2 * 0.2 * 40 N = 16 N.
TEST_F(ExecuteWithErrorsTest, WeakerGripperLosesWhatTheNominalOneHolds) {
  AttemptErrors weak;
  weak.force = -0.5;
  EXPECT_TRUE(Try(1.2, {}).success) << "11.8 N";
  EXPECT_FALSE(Try(1.2, weak).success) << "8 N hold";
  EXPECT_TRUE(Try(0.4, weak).success) << "3.9 N";
}

TEST_F(ExecuteWithErrorsTest, HeavierOrSmootherInstanceSlips) {
  EXPECT_FALSE(Try(1.2, {}, {.mass = 0.8}).success) << "21 N";
  EXPECT_FALSE(Try(1.2, {}, {.friction = -0.5}).success) << "8 N hold";
  EXPECT_TRUE(Try(2.5, {}, {.friction = 0.9, .mass = -0.2}).success) << "20 N, 30 N hold";
}

TEST_F(ExecuteWithErrorsTest, HandFeelsTheWeightOfTheInstance) {
  const double mass_kg = 0.5;
  const double nominal_n = Try(mass_kg, {}).contact_force_n.norm();
  const double heavy_n = Try(mass_kg, {}, {.mass = 0.3}).contact_force_n.norm();
  EXPECT_NEAR(nominal_n, mass_kg * kGravity_mps2, 0.1);
  EXPECT_NEAR(heavy_n, 1.3 * mass_kg * kGravity_mps2, 0.1);
}

TEST_F(ExecuteWithErrorsTest, RobotErrorMovesTheExecutedGrasp) {
  const ObjectSet objects{BoxObject({0.040, 0.050, 0.050}, 0.2, 0.5)};
  const Scene scene = BoxesOnFloor({{0, 0}}, 0.050);
  Grasp planned;
  planned.X_WG = FromAbove({0, 0, 0.015});
  planned.width_m = 0.040;
  AttemptErrors errors;
  errors.robot_m = {0.001, -0.004, 0.002};
  Grasp moved = planned;
  moved.X_WG = Translation(errors.robot_m) * planned.X_WG;
  ExecuteOptions options;
  options.carry = false;
  Vector3d lowest_W(0, 0, 1);
  const MotionListener note_lowest = [&](const MotionState& state) {
    const Vector3d p_W = state.hand.X_WG().translation();
    if (p_W.z() < lowest_W.z()) lowest_W = p_W;
  };
  const GraspOutcome a = ExecuteWithErrors({scene, objects}, planned, SmallJaw(), InstanceId{10},
                                           options, errors, note_lowest)
                             .outcome;
  const GraspOutcome b =
      ExecuteGrasp(scene, objects, moved, SmallJaw(), InstanceId{10}, options).outcome;
  EXPECT_TRUE((lowest_W - planned.X_WG.translation()).isApprox(errors.robot_m, 1e-6));
  EXPECT_EQ(a.contact_force_n, b.contact_force_n);
  // A finger lands on the box: the opening leaves 3 mm on each side.
  errors.robot_m = {0.008, 0, 0};
  EXPECT_EQ(Try(0.2, errors).failure, FailureReason::kCollision);
}

// The cell plans the placement for the grasp that it planned, so the object is put down beside its
// place by the error of the grasp.
TEST_F(ExecuteWithErrorsTest, RobotErrorDisplacesThePlacedObject) {
  AttemptErrors errors;
  EXPECT_LT(Try(0.2, errors).place_error_m, 0.001);
  errors.robot_m = {0, 0.004, 0};  // along the fingers' width
  const GraspOutcome outcome = Try(0.2, errors);
  ASSERT_TRUE(outcome.place_executed);
  EXPECT_NEAR(outcome.place_error_m, 0.004, 0.0015);
}

// The cell plans the placement with the nominal height, so the center of a higher object comes to
// rest above its planned place.
TEST_F(ExecuteWithErrorsTest, PlacementIsPlannedAtNominalSize) {
  const auto nominal = BoxObject({0.040, 0.050, 0.050}, 0.2, 0.5);
  const ObjectSet larger = ObjectsOfSizes({nominal}, {0.08});
  Scene scene = BoxesOnFloor({{0, 0}}, 0.050 * 1.08);
  Grasp grasp;
  grasp.X_WG = FromAbove({0, 0, 0.015});
  grasp.width_m = 0.043;
  const auto place_error_m = [&](const ObjectModel* assumed) {
    const GraspTarget target(InstanceId{10}, ObjectId{0}, scene.objects[0].X_WO, assumed);
    const GraspOutcome outcome =
        ExecuteWithErrors({scene, larger}, grasp, SmallJaw(), target, {}, {}).outcome;
    EXPECT_TRUE(outcome.place_executed);
    return outcome.place_error_m;
  };
  EXPECT_LT(place_error_m(nullptr), 0.001) << "the true size is known";
  EXPECT_NEAR(place_error_m(nominal.get()), 0.08 * 0.025, 0.0008);
}

TEST(CellErrors, CupLosesPullAndMomentTogether) {
  SuctionCup cup;
  const auto weak = cup.WithForce(0.5);
  EXPECT_NEAR(weak->Capacity_n(0.5), 0.5 * cup.Capacity_n(0.5), 1e-12);
  const CupSpec& numbers = dynamic_cast<const SuctionCup&>(*weak).cup;
  EXPECT_NEAR(numbers.moment_limit_nm, 0.5 * cup.cup.moment_limit_nm, 1e-12);
  EXPECT_NEAR(RingRadius_m(numbers), RingRadius_m(cup.cup), 1e-12) << "the lip is the same";
}

// The hand closes on the true size; the estimator and the planner know only the model.
TEST(CellErrors, PartsOfAnotherSizeAreSeenAndHeldAtIt) {
  ScenarioSpec spec = CubeScenario(1);
  spec.cell.size_percent = 5;
  BinIndex bin{0};
  const SimulatedCell cell(spec, EasyCube());
  while (std::abs(cell.SizesOf(bin)[0]) < 0.04) ++bin;
  const double size = cell.SizesOf(bin)[0];
  const TrialResult result = TrialRunner(spec, EasyCube()).Run(bin);
  ASSERT_EQ(result.instances_cleared, 1);
  const TrialResult nominal = TrialRunner(CubeScenario(1), EasyCube()).Run(bin);
  EXPECT_NEAR(result.attempts.back().outcome.final_opening_m -
                  nominal.attempts.back().outcome.final_opening_m,
              0.03 * size, 0.0003);
  EXPECT_EQ(result.outcomes[0].size_deviation, size);
  // The cube rests on the floor, so its center is at half of its true height.
  const Scene scene = cell.MakeScene(bin).scene;
  EXPECT_NEAR(scene.objects[0].X_WO.translation().z(), 0.015 * (1 + size), 0.0007);
}

TEST(CellErrors, PicturesShowTheTrueSize) {
  ScenarioSpec spec = CubeScenario(1);
  spec.cell.size_percent = 10;
  SimulatedCell cell(spec, EasyCube()), nominal(CubeScenario(1), EasyCube());
  BinIndex large{0}, small{0};
  while (cell.SizesOf(large)[0] < 0.1) ++large;
  while (cell.SizesOf(small)[0] > -0.1) ++small;
  Scene scene = nominal.MakeScene(BinIndex{0}).scene;
  const auto pixels_in = [&](SimulatedCell& drawn, BinIndex bin) {
    const sim::Picture picture = drawn.PictureOf(scene, bin, cell.camera());
    return std::count_if(picture.ids.pixels().begin(), picture.ids.pixels().end(),
                         [](uint16_t id) { return id > 0; });
  };
  const double as_model = static_cast<double>(pixels_in(nominal, BinIndex{0}));
  ASSERT_GT(as_model, 300);
  for (const BinIndex bin : {large, small, large}) {  // also back again
    const double factor = 1 + cell.SizesOf(bin)[0];
    EXPECT_NEAR(static_cast<double>(pixels_in(cell, bin)) / as_model, factor * factor, 0.06);
  }
}

TEST(CellErrors, DrawnSizesThatDoNotFitAreRefused) {
  ScenarioSpec spec = CubeScenario(1);
  spec.trials = 20;
  spec.cell.size_percent = 5;
  const auto error_of = [&](double side_m, double mass_kg) {
    return ErrorOf(
        [&] { RequireSizesFit(spec, {Cube(side_m, mass_kg, 0.5)}, LoadTools({"jaw_8cm"})); });
  };
  EXPECT_EQ(error_of(0.03, 0.05), "no error");
  // Fits into 30 cm at its nominal size.
  const std::string wide = error_of(0.295, 0.05);
  EXPECT_THAT(wide, HasSubstr("cell.size_percent = 5: in bin "));
  EXPECT_THAT(wide, HasSubstr("does not fit into the bin of 400 x 300 mm"));
  const double capacity_kg = LoadGripper("jaw_8cm")->Capacity_n(0.5) / kGravity_mps2;
  EXPECT_THAT(error_of(0.03, 0.99 * capacity_kg), HasSubstr("which no gripper carries"));
  spec.trials = 1;
  while (DrawSizes(spec.cell, spec.seed, BinIndex{0}, 1)[0] > 0) ++spec.seed;
  EXPECT_EQ(error_of(0.295, 0.05), "no error") << "no bin has a larger object";
}

TEST(CellErrors, DrawnValuesAreRecordedAndWritten) {
  const TrialResult result = RunWith(AllCellErrors(), 2, 1);
  const SimulatedCell cell = [&] {
    ScenarioSpec spec = CubeScenario(2);
    spec.cell = AllCellErrors();
    return SimulatedCell(spec, EasyCube());
  }();
  const BinIndex bin{1};
  EXPECT_EQ(result.errors.hand_eye_m, cell.ErrorsOf(bin).hand_eye_m);
  EXPECT_EQ(result.errors.depth_bias_m, cell.ErrorsOf(bin).depth_bias_m);
  for (const AttemptRecord& attempt : result.attempts) {
    EXPECT_EQ(attempt.errors.robot_m, cell.ErrorsOf(bin, attempt.attempt).robot_m);
    EXPECT_EQ(attempt.errors.force, cell.ErrorsOf(bin, attempt.attempt).force);
  }
  for (const InstanceOutcome& outcome : result.outcomes) {
    EXPECT_EQ(outcome.deviation, DrawDeviation(AllCellErrors(), 11, bin, outcome.instance));
    EXPECT_NE(outcome.deviation.mass, 0);
  }
  EXPECT_THAT(TrialsCsv({result}),
              HasSubstr(std::to_string(1e3 * result.errors.hand_eye_m.x()).substr(0, 6)));
  EXPECT_THAT(AttemptsCsv({result}, {"cube"}),
              HasSubstr(std::to_string(1e2 * result.attempts[0].errors.force).substr(0, 6)));
}

TEST(CellErrors, RecordedAttemptsAreReproducedWithTheirErrors) {
  ScenarioSpec spec = CubeScenario(4);
  spec.cell = AllCellErrors();
  const TrialResult result = TrialRunner(spec, EasyCube()).Run(BinIndex{0});
  ASSERT_GE(result.attempts.size(), 2u);
  SimulatedCell cell(spec, EasyCube());
  const Tools tools = LoadTools(spec.gripper.names);
  const size_t last = result.attempts.size() - 1;
  EXPECT_EQ(HashOf(SceneOfAttempt(result, last, {cell, tools, spec.policy.success})),
            result.attempts[last].hashes[TrialStage::kScene]);
}

// Each stage is exact up to the one where an error enters.
TEST(CellErrors, AttemptErrorsChangeOnlyTheExecution) {
  CellErrorsSpec errors;
  errors.repeatability_mm = 1;
  errors.force_percent = 20;
  const TrialResult exact = RunWith({}), wrong = RunWith(errors);
  for (const TrialStage stage :
       {TrialStage::kScene, TrialStage::kImage, TrialStage::kHypotheses, TrialStage::kGrasp}) {
    EXPECT_EQ(exact.attempts[0].hashes[stage], wrong.attempts[0].hashes[stage]) << StageName(stage);
  }
  EXPECT_NE(exact.attempts[0].hashes[TrialStage::kOutcome],
            wrong.attempts[0].hashes[TrialStage::kOutcome]);
}

// Every drop of so many cubes loses some over the rim.
TEST(SimulatedCell, NamesTheSettingOfABinThatCannotBeFilled) {
  ScenarioSpec spec = CubeScenario(16);
  spec.bin.inner_size_m = {0.06, 0.06, 0.03};
  const auto make = [&] { SimulatedCell(spec, EasyCube()).MakeScene(BinIndex(0)); };
  EXPECT_THAT(ErrorOf(make), testing::StartsWith("objects: trial 0: 10 scenes in a row"));
  spec.cell.size_percent = 1;
  EXPECT_THAT(ErrorOf(make), testing::HasSubstr("or lower cell.size_percent"));
}

}  // namespace
}  // namespace pickbed::tests
