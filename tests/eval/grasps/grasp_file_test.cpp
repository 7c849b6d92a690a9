#include "eval/grasps/grasp_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <numbers>

#include "eval/grasps/gripper_frame.h"
#include "eval/grasps/isaac_grasp.h"
#include "grasp/grippers/suction_cup.h"
#include "scenes/base/files.h"
#include "tests/grasp/grasp_scenes.h"
#include "tests/support/error_of.h"
#include "tests/support/temporary_folder.h"

namespace pickbed::tests {
namespace {

using testing::AllOf;
using testing::HasSubstr;

// A file as other programs write it, after the documentation of Isaac Sim.
constexpr char kPandaFile[] = R"(format: isaac_grasp
format_version: 1.0

object_frame: /World/mug
gripper_frame: /World/panda_hand

grasps:
  grasp_0:
    confidence: 0.75
    position: [0, 0, 0.1634]
    orientation: {w: 0.0, xyz: [1.0, 0.0, 0.0]}
    cspace_position:
      panda_finger_joint1: 0.00943
    pregrasp_cspace_position:
      panda_finger_joint1: 0.04
  "side":
    position: [-0.2, 0, 0]
    orientation: {w: 0.70710678, xyz: [0, 0.70710678, 0]}
)";

std::shared_ptr<const ObjectModel> Box() { return BoxObject({0.04, 0.03, 0.12}, 0.1, 0.5); }

std::vector<GraspCandidate> RandomCandidates(int count) {
  Rng rng(5);
  std::vector<GraspCandidate> candidates(count);
  for (GraspCandidate& candidate : candidates) {
    candidate.X_OG = MakePose(rng.Rotation().toRotationMatrix(), 0.1 * rng.UnitVector());
    candidate.width_m = 0.03 * rng.Uniform();
    candidate.robust = rng.Uniform();
  }
  return candidates;
}

TEST(GraspFile, TheFrameOfThePandaIsConverted) {
  const GraspFile file = ReadIsaacGrasps(kPandaFile, "mug.yaml");
  ASSERT_EQ(file.grasps.size(), 2u);
  EXPECT_EQ(file.grasps[0].confidence, 0.75);
  EXPECT_EQ(file.grasps[1].name, "side");
  EXPECT_EQ(file.grasps[1].confidence, 1);
  EXPECT_FALSE(file.grasps[0].width_m) << "its joint has another meaning";
  const auto candidates = CandidatesOf(file, *Box(), SmallJaw(), LoadGripperFrame("panda_hand"));
  // The hand is 163.4 mm above the center of the box and points down: the tips are 60 mm above it.
  EXPECT_TRUE(candidates[0].X_OG.translation().isApprox(Eigen::Vector3d(0, 0, 0.06), 1e-9));
  EXPECT_TRUE(candidates[0].X_OG.linear().col(2).isApprox(-Eigen::Vector3d::UnitZ(), 1e-9));
  EXPECT_NEAR(std::abs(candidates[0].X_OG.linear().col(0).y()), 1, 1e-9) << "it closes along y";
  // The second hand points along x, with its tips 96.6 mm from the center.
  EXPECT_TRUE(candidates[1].X_OG.translation().isApprox(Eigen::Vector3d(-0.0966, 0, 0), 1e-6));
  EXPECT_TRUE(candidates[1].X_OG.linear().col(2).isApprox(Eigen::Vector3d::UnitX(), 1e-6));
}

TEST(GraspFile, WidthAndDepthAreMeasuredOnTheMesh) {
  GraspFile file = ReadIsaacGrasps(kPandaFile, "mug.yaml");
  file.grasps[0].X_OF.translation().z() -= 0.02;  // the tips are 20 mm below the top of the box
  const auto candidates = CandidatesOf(file, *Box(), SmallJaw(), LoadGripperFrame("panda_hand"));
  EXPECT_NEAR(candidates[0].width_m, 0.03, 1e-9);
  EXPECT_NEAR(candidates[0].depth_m, 0.01, 0.004);
  EXPECT_EQ(candidates[1].width_m, 0) << "nothing is between the fingers";
}

TEST(GraspFile, CandidatesSurviveBothFormatsAndEachFrame) {
  const TemporaryFolder folder;
  const auto written = RandomCandidates(7);
  const ParallelJaw jaw = SmallJaw();
  for (const char* name : {"tips.yaml", "panda_hand.yml", "tips.csv"}) {
    const std::filesystem::path file = folder.path() / name;
    const GripperFrame frame = LoadGripperFrame(file.stem());
    WriteGraspFile(file, *Box(), jaw, frame, written);
    const GraspFile read = ReadGraspFile(file);
    RequireGraspsOf(read, *Box(), jaw, frame);
    const auto candidates = CandidatesOf(read, *Box(), jaw, frame);
    ASSERT_EQ(candidates.size(), written.size());
    for (size_t i = 0; i < written.size(); ++i) {
      EXPECT_TRUE(candidates[i].X_OG.isApprox(written[i].X_OG, 1e-12)) << name;
      EXPECT_NEAR(candidates[i].width_m, written[i].width_m, 1e-15) << name;
      EXPECT_EQ(candidates[i].robust, written[i].robust) << name;
    }
  }
  EXPECT_TRUE(std::filesystem::exists(folder.path() / (Box()->name + ".obj")));
  EXPECT_THAT(ErrorOf([&] {
                WriteGraspFile(folder.path() / "a.csv", *Box(), jaw, LoadGripperFrame("panda_hand"),
                               written);
              }),
              HasSubstr("another frame"));
}

TEST(GraspFile, ASuctionCupHasNoJoints) {
  const std::string text = IsaacGraspText("box.obj", SuctionCup(), {}, RandomCandidates(1));
  EXPECT_THAT(text, HasSubstr("cspace_position: {}"));
  EXPECT_FALSE(ReadIsaacGrasps(text, "cup.yaml").grasps.at(0).width_m);
}

// A confidence can be a product of many chances.
TEST(GraspFile, OnlyAConfidenceMayBeTiny) {
  const auto with = [](const std::string& was, const std::string& is) {
    std::string text = kPandaFile;
    return text.replace(text.find(was), was.size(), is);
  };
  const std::string tiny = with("confidence: 0.75", "confidence: 1e-120");
  EXPECT_EQ(ReadIsaacGrasps(tiny, "mug.yaml").grasps.at(0).confidence, 1e-120);
  EXPECT_THAT(
      ErrorOf([&] { ReadIsaacGrasps(with("[0, 0, 0.1634]", "[0, 0, 1e-120]"), "mug.yaml"); }),
      HasSubstr("position = 1e-120: is too small"));
}

// Each fault is one line with the file and the place.
TEST(GraspFile, DamagedYamlIsNamed) {
  const auto error_of = [](const std::string& was, const std::string& is) {
    std::string text = kPandaFile;
    const size_t at = text.find(was);
    EXPECT_NE(at, std::string::npos) << was;
    text.replace(at, was.size(), is);
    const std::string error = ErrorOf([&] { ReadIsaacGrasps(text, "mug.yaml"); });
    EXPECT_TRUE(error.starts_with("mug.yaml")) << error;
    EXPECT_EQ(error.find('\n'), std::string::npos) << error;
    return error;
  };
  EXPECT_THAT(error_of("isaac_grasp", "other"), HasSubstr("format = 'other'"));
  EXPECT_THAT(error_of("format_version: 1.0", "format_version: '2.0'"),
              HasSubstr("format_version = '2.0': this pickbed reads 1.0"));
  EXPECT_THAT(error_of("[0, 0, 0.1634]", "[0, .nan, 0.1634]"),
              AllOf(HasSubstr("mug.yaml:10"), HasSubstr("position = .nan: must be a finite")));
  EXPECT_THAT(error_of("[0, 0, 0.1634]", "[0, 0.1634]"), HasSubstr("list of three numbers"));
  EXPECT_THAT(error_of("w: 0.0", "w: 0.5"), HasSubstr("must be a unit quaternion, but its length"));
  EXPECT_THAT(error_of("{w: 0.0, xyz", "{xyz"), HasSubstr("must have w and xyz"));
  EXPECT_THAT(error_of("    position: [0, 0, 0.1634]\n", ""),
              HasSubstr("grasp 'grasp_0' has no position"));
  EXPECT_THAT(error_of("confidence: 0.75", "confidence: high"), HasSubstr("confidence = high"));
  EXPECT_THAT(error_of("object_frame: /World/mug", "approach_axis: 3"),
              HasSubstr("approach_axis = 3: must be 0 (x), 1 (y) or 2 (z)"));
  EXPECT_THAT(error_of("panda_finger_joint1: 0.00943", "panda_finger_joint1: .inf"),
              HasSubstr("cspace_position.panda_finger_joint1"));
  EXPECT_THAT(error_of("panda_finger_joint1: 0.04", "panda_finger_joint1: wide"),
              HasSubstr("pregrasp_cspace_position.panda_finger_joint1"));
  EXPECT_THAT(error_of("    cspace_position:", "    cspace_posi4ion:"),
              HasSubstr("has the unknown key 'cspace_posi4ion'; did you mean cspace_position?"));
  const std::string text = kPandaFile;
  EXPECT_THAT(ErrorOf([&] { ReadIsaacGrasps(text.substr(0, text.find("grasps:")), "mug.yaml"); }),
              HasSubstr("has no grasps"));
  EXPECT_THAT(ErrorOf([&] { ReadIsaacGrasps(text.substr(0, text.find("  grasp_0")), "mug.yaml"); }),
              HasSubstr("has no grasps"));
  EXPECT_THAT(ErrorOf([&] { ReadIsaacGrasps(text.substr(0, text.find(", xyz")), "mug.yaml"); }),
              HasSubstr("not valid YAML"));
}

TEST(GraspFile, DamagedCsvIsNamed) {
  const TemporaryFolder folder;
  WriteGraspFile(folder.path() / "grasps.csv", *Box(), SmallJaw(), {}, RandomCandidates(2));
  const std::string whole = ReadFileBytes(folder.path() / "grasps.csv");
  const auto error_of = [&](const std::string& text) {
    return ErrorOf([&] { ReadGraspFile(folder.Write("damaged.csv", text)); });
  };
  EXPECT_THAT(error_of(whole.substr(0, whole.find('\n') + 1)), HasSubstr("has no grasps"));
  EXPECT_THAT(error_of(""), HasSubstr("has no grasps"));
  EXPECT_THAT(error_of(whole.substr(0, whole.size() - 30)), HasSubstr("damaged.csv:3: has"));
  EXPECT_THAT(error_of(whole.substr(0, whole.rfind('.') + 1)), HasSubstr("so it is cut short"));
  const std::string last = whole.substr(whole.rfind(',') + 1);
  for (const char* confidence : {"1.5\n", "-0.1\n"}) {
    EXPECT_THAT(error_of(whole.substr(0, whole.size() - last.size()) + confidence),
                HasSubstr("damaged.csv:3: grasp 'grasp_1' has the confidence "));
  }
  std::string without_epsilon = whole;
  const size_t last_comma = whole.rfind(','), comma_before = whole.rfind(',', last_comma - 1);
  without_epsilon.erase(comma_before + 1, last_comma - comma_before - 1);
  EXPECT_EQ(error_of(without_epsilon), "no error") << "this column is not used";
  std::string scripted = whole;
  EXPECT_THAT(error_of(scripted.insert(whole.rfind(','), "<script>")),
              HasSubstr("damaged.csv:3: epsilon = '0<script>'"));
  std::string renamed = whole;
  EXPECT_THAT(error_of(renamed.replace(renamed.find("x_m"), 3, "y_x")), HasSubstr("no column x_m"));
  std::string damaged = whole;
  const size_t first = damaged.find('\n') + 1;
  EXPECT_THAT(error_of(damaged.replace(first, damaged.find(',', first) - first, "nan")),
              HasSubstr("r00 = 'nan': must be a finite number"));
  damaged = whole;
  EXPECT_THAT(error_of(damaged.replace(first, damaged.find(',', first) - first, "0.123")),
              HasSubstr("r00 to r22 are no rotation"));
  damaged = whole;
  EXPECT_THAT(error_of(damaged.insert(first, 1, '\xa5')), HasSubstr("damaged.csv:2: "));
  EXPECT_THAT(error_of(damaged), HasSubstr("is not UTF-8; save the file as UTF-8"));
  EXPECT_THAT(error_of("\xa5" + whole), HasSubstr("damaged.csv:1: "));
  EXPECT_THAT(ErrorOf([&] { ReadGraspFile(folder.Write("grasps.txt", whole)); }),
              HasSubstr("ends in .yaml (isaac_grasp) or .csv"));
  EXPECT_THAT(ErrorOf([&] { ReadGraspFile(folder.path() / "none.csv"); }), HasSubstr("none.csv"));
}

TEST(GraspFile, OtherObjectsAndHandsAreNamed) {
  GraspFile file = ReadIsaacGrasps(kPandaFile, "mug.yaml");
  const ParallelJaw jaw = SmallJaw();
  const auto error_of = [&](bool names_matter = true) {
    return ErrorOf([&] { RequireGraspsOf(file, *Box(), jaw, {}, names_matter); });
  };
  EXPECT_NO_THROW(RequireGraspsOf(file, *Box(), jaw, {})) << "it names none";
  file.object_file = "objects/mug.obj";
  EXPECT_THAT(error_of(), HasSubstr("is for the object objects/mug.obj"));
  file.object_file = "objects/" + Box()->name + "/mesh.obj";
  file.gripper_file = "bots/onrobot_rg6.usd";
  EXPECT_THAT(error_of(), HasSubstr("is for the gripper bots/onrobot_rg6.usd, not test jaw"));
  file.approach_axis = 0;
  EXPECT_THAT(error_of(false), HasSubstr("approaches along x, but the gripper frame along z"));
}

// The scale of the mesh would change the meaning of the positions.
TEST(GraspFile, GraspsOfAScaledMeshAreRefused) {
  const auto with_scale = [](const std::string& scale) {
    return "object_scale: " + scale + "\n" + kPandaFile;
  };
  EXPECT_EQ(ReadIsaacGrasps(with_scale("1.0"), "mug.yaml").grasps.size(), 2u);
  EXPECT_EQ(ReadIsaacGrasps(with_scale("[1, 1, 1]"), "mug.yaml").grasps.size(), 2u);
  for (const char* scale : {"0.5", "[1, 1, 2]", "0.001", "large"}) {
    EXPECT_THAT(ErrorOf([&] { ReadIsaacGrasps(with_scale(scale), "mug.yaml"); }),
                HasSubstr("mug.yaml:1: object_scale"))
        << scale;
  }
  EXPECT_THAT(ErrorOf([&] { ReadIsaacGrasps(with_scale("0.5"), "mug.yaml"); }),
              HasSubstr("object_scale = 0.5: must be 1"));
}

TEST(GraspFile, AGraspWiderThanTheOpeningIsNamedWithItsLine) {
  const ParallelJaw jaw = SmallJaw();
  const std::string joints = "    cspace_position: {left_finger: 0.3, right_finger: 0.3}\n";
  GraspFile file = ReadIsaacGrasps(kPandaFile + joints, "mug.yaml");
  EXPECT_THAT(
      ErrorOf([&] { RequireGraspsOf(file, *Box(), jaw, {}); }),
      AllOf(HasSubstr("mug.yaml:17: grasp 'side' is 0.6 m wide, but gripper test jaw opens"),
            HasSubstr(fmt::format("at most {:.4g} m", jaw.MaxOpening_m()))));
  file.grasps[1].width_m = jaw.MaxOpening_m();
  EXPECT_NO_THROW(RequireGraspsOf(file, *Box(), jaw, {}));
  EXPECT_NO_THROW(
      RequireGraspsOf(ReadIsaacGrasps(kPandaFile + joints, "mug.yaml"), *Box(), SuctionCup(), {}))
      << "it has no fingers";
  const TemporaryFolder folder;
  auto candidates = RandomCandidates(3);
  candidates[1].width_m = 0.6;
  WriteGraspFile(folder.path() / "wide.csv", *Box(), jaw, {}, candidates);
  EXPECT_THAT(
      ErrorOf([&] { RequireGraspsOf(ReadGraspFile(folder.path() / "wide.csv"), *Box(), jaw, {}); }),
      HasSubstr("wide.csv:3: grasp 'grasp_1' is 0.6 m wide"));
}

TEST(GraspFile, AByteOrderMarkIsSkipped) {
  const TemporaryFolder folder;
  WriteGraspFile(folder.path() / "grasps.csv", *Box(), SmallJaw(), {}, RandomCandidates(2));
  const std::string text = ReadFileBytes(folder.path() / "grasps.csv");
  EXPECT_EQ(ReadGraspFile(folder.Write("marked.csv", kByteOrderMark + text)).grasps.size(), 2u);
  EXPECT_EQ(ReadGraspFile(folder.Write("marked.yaml", std::string(kByteOrderMark) + kPandaFile))
                .grasps.size(),
            2u);
}

TEST(GraspFile, PositionsInMillimetresAreNamed) {
  GraspFile file = ReadIsaacGrasps(kPandaFile, "mug.yaml");
  file.grasps[1].X_OF.translation() *= 1000;
  EXPECT_THAT(ErrorOf([&] { RequireGraspsOf(file, *Box(), SmallJaw(), {}); }),
              HasSubstr("grasp 'side' is 200 m from the object; positions are in metres"));
}

TEST(GripperFrame, IsReadFromAFileAndChecked) {
  const TemporaryFolder folder;
  const auto file = folder.Write("hand.yaml", "approach: x\nclosing: -y\ntip_m: [0.1, 0, 0.02]\n");
  const Pose X_FG = LoadGripperFrame(file.string()).X_FG();
  EXPECT_EQ(X_FG.linear().col(2), Eigen::Vector3d::UnitX());
  EXPECT_EQ(X_FG.linear().col(0), -Eigen::Vector3d::UnitY());
  EXPECT_EQ(X_FG.linear().determinant(), 1);
  EXPECT_EQ(X_FG.translation(), Eigen::Vector3d(0.1, 0, 0.02));
  EXPECT_TRUE(LoadGripperFrame("tips").X_FG().matrix().isIdentity());
  EXPECT_THAT(ErrorOf([] { LoadGripperFrame("panda"); }), HasSubstr("panda_hand"));
  const auto parallel = folder.Write("wrong.yaml", "approach: x\nclosing: -x\n");
  EXPECT_THAT(ErrorOf([&] { LoadGripperFrame(parallel.string()); }),
              AllOf(HasSubstr("wrong.yaml"), HasSubstr("must be another axis")));
}

}  // namespace
}  // namespace pickbed::tests
