#include "scenes/plugin/plugin_messages.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "scenes/base/cache_file.h"
#include "scenes/base/files.h"
#include "scenes/base/random.h"
#include "scenes/mesh_io/mesh_io.h"
#include "tests/support/temporary_folder.h"

namespace pickbed::tests {
namespace {

namespace fs = std::filesystem;
using testing::ElementsAre;
using testing::HasSubstr;

constexpr double kDistance_m = 0.8;

std::shared_ptr<const ObjectModel> Tetrahedron(const std::string& name) {
  auto model = std::make_shared<ObjectModel>();
  model->name = name;
  model->mesh_O.vertices = {{0, 0, 0}, {0.03, 0, 0}, {0, 0.04, 0}, {0, 0, 0.05}};
  model->mesh_O.triangles = {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}};
  model->diameter_m = Diameter(model->mesh_O);
  model->symmetries_O.discrete_O = {Translation({0, 0, 0.01})};
  model->symmetries_O.continuous_O = {{Eigen::Vector3d::UnitY(), {0.1, 0, 0}}};
  return model;
}

const ObjectSet& Objects() {
  static const ObjectSet objects{Tetrahedron("rod"), Tetrahedron("ring")};
  return objects;
}

MessageValue Received(const MessageWriter& message) {
  std::vector<std::byte> bytes;
  for (const auto& chunk : message.Chunks()) bytes.insert(bytes.end(), chunk.begin(), chunk.end());
  return ReadMessageValue(bytes);
}

// One pose of an answer, with values that a test changes.
struct Answered {
  std::string object = "ring";
  Eigen::Matrix3d R = Eigen::Matrix3d::Identity();
  Eigen::Vector3d t_m{0.01, 0.02, 0.75};
  double score = 0.5;

  MessageValue Message() const {
    MessageWriter message;
    message.BeginMap(1);
    message.Text("poses");
    message.BeginList(1);
    message.BeginMap(4);
    message.Text("object");
    message.Text(object);
    message.Text("R");
    message.BeginList(3);
    for (int row = 0; row < 3; ++row) {
      message.BeginList(3);
      for (int column = 0; column < 3; ++column) message.Real(R(row, column));
    }
    message.Text("t_m");
    message.BeginList(3);
    for (const double x : t_m) message.Real(x);
    message.Text("score");
    message.Real(score);
    return Received(message);
  }
  PluginPose Read() const { return ReadPoses(Message(), Objects(), kDistance_m).at(0); }
  std::string Fault() const {
    std::vector<std::string> faults;
    ReadPoses(Message(), Objects(), kDistance_m, &faults);
    if (faults.empty()) return "no fault";
    EXPECT_THROW(Read(), PluginError);
    return faults.front();
  }
};

TEST(PluginPoses, ARightAnswerIsReadBitByBit) {
  Rng rng(3);
  Answered answer;
  answer.R = rng.Rotation().toRotationMatrix();
  const PluginPose pose = answer.Read();
  EXPECT_EQ(pose.object, ObjectId(1));
  EXPECT_EQ(pose.X_CO.linear(), answer.R);
  EXPECT_EQ(pose.X_CO.translation(), answer.t_m);
  EXPECT_EQ(pose.score, 0.5);
}

// Networks compute in single precision.
TEST(PluginPoses, ARotationWithRoundingErrorsIsCorrected) {
  Rng rng(4);
  Answered answer;
  const Eigen::Matrix3d exact = rng.Rotation().toRotationMatrix();
  answer.R = exact.cast<float>().cast<double>() * 1.0001;
  const Eigen::Matrix3d R = answer.Read().X_CO.linear();
  EXPECT_TRUE((R.transpose() * R).isApprox(Eigen::Matrix3d::Identity(), 1e-14));
  EXPECT_TRUE(R.isApprox(exact, 1e-6));
}

TEST(PluginPoses, EachRuleIsCheckedAndNamed) {
  const double nan = std::nan(""), infinity = std::numeric_limits<double>::infinity();
  Answered wrong;
  wrong.object = "rnig";
  EXPECT_THAT(wrong.Fault(),
              HasSubstr("pose (number 0): unknown object 'rnig'; did you mean 'ring'"));
  wrong = {};
  wrong.R.col(0) *= -1;
  EXPECT_THAT(wrong.Fault(), HasSubstr("R is a reflection"));
  wrong = {};
  wrong.R *= 1.1;
  EXPECT_THAT(wrong.Fault(), HasSubstr("R is no rotation"));
  wrong = {};
  wrong.R.setZero();
  EXPECT_THAT(wrong.Fault(), HasSubstr("R is no rotation"));
  wrong = {};
  wrong.R(1, 1) = nan;
  EXPECT_THAT(wrong.Fault(), HasSubstr("R is not finite"));
  wrong = {};
  wrong.t_m.z() = infinity;
  EXPECT_THAT(wrong.Fault(), HasSubstr("t_m is not finite"));
  wrong = {};
  wrong.score = nan;
  EXPECT_THAT(wrong.Fault(), HasSubstr("score is not finite"));
  wrong = {};
  wrong.score = 12;
  EXPECT_THAT(wrong.Fault(), HasSubstr("score 12 is outside 0 to 1"));
  EXPECT_THAT(wrong.Fault(), HasSubstr("pickbed calibrate"));
}

TEST(PluginPoses, RawScoresHaveAnyScale) {
  Answered answer;
  const auto read = [&] {
    std::vector<std::string> faults;
    const auto poses =
        ReadPoses(answer.Message(), Objects(), kDistance_m, &faults, PluginScores::kAny);
    return faults.empty() ? std::to_string(poses.at(0).score) : faults.front();
  };
  answer.score = -120.5;
  EXPECT_THAT(read(), HasSubstr("-120.5"));
  answer.score = std::numeric_limits<double>::infinity();
  EXPECT_THAT(read(), HasSubstr("score is not finite"));
}

TEST(PluginPoses, MillimetresAreRecognised) {
  Answered wrong;
  wrong.t_m *= 1000;
  EXPECT_THAT(wrong.Fault(), HasSubstr("t_m is in millimetres and must be in metres"));
  wrong.t_m = {0, 0, 1e6};
  EXPECT_THAT(wrong.Fault(), testing::AllOf(HasSubstr("m from the camera"),
                                            testing::Not(HasSubstr("millimetres"))));
  wrong.t_m = {0.5, 0.5, 3};
  EXPECT_EQ(wrong.Fault(), "no fault") << "a bad estimate is no breach of the protocol";
}

MessageValue ManyPoses(size_t count) {
  MessageWriter message;
  message.BeginMap(1);
  message.Text("poses");
  message.BeginList(count);
  for (size_t i = 0; i < count; ++i) message.Nil();
  return Received(message);
}

TEST(PluginPoses, AnswersOfAnotherFormAreNamed) {
  const auto fault = [](const MessageValue& answer) {
    std::vector<std::string> faults;
    ReadPoses(answer, Objects(), kDistance_m, &faults);
    return faults.empty() ? "no fault" : faults.front();
  };
  EXPECT_THAT(fault(ManyPoses(1000000)), HasSubstr("gave 1000000 poses"));
  EXPECT_THAT(fault(ManyPoses(1)), HasSubstr("number 0): is nil and no map with 'object'"));
  EXPECT_EQ(fault(ManyPoses(0)), "no fault");
  MessageWriter empty;
  empty.BeginMap(0);
  EXPECT_THAT(fault(Received(empty)), HasSubstr("has no 'poses'"));
}

// A plug-in would work with another shape than the one that is simulated.
TEST(PluginSetup, ADamagedMeshFileIsReportedAndWrittenAgain) {
  const TemporaryFolder folder;
  const auto mesh_of_setup = [&] {
    MessageWriter message;
    WriteSetup({Objects()}, folder.path(), message);
    return fs::path(Received(message).At("objects").Items("")[0].At("mesh").Text(""));
  };
  const fs::path file = mesh_of_setup();
  const std::string whole = ReadFileBytes(file);
  std::vector<std::string> lines;
  SetCacheListener([&](const std::string& line) { lines.push_back(line); });
  const auto repaired = [&] {
    lines.clear();
    EXPECT_EQ(mesh_of_setup(), file);
    EXPECT_EQ(ReadFileBytes(file), whole);
    ASSERT_FALSE(lines.empty());
    EXPECT_THAT(lines.front(), HasSubstr(file.parent_path().string()));
    EXPECT_THAT(lines.front(), HasSubstr("it is made again"));
    lines.clear();
    mesh_of_setup();
    EXPECT_THAT(lines, testing::IsEmpty()) << "a repaired mesh is sound";
  };
  WriteFileAtomically(file, whole.substr(0, whole.size() / 2));
  repaired();
  fs::remove(file);
  repaired();
  SetCacheListener({});
}

TEST(PluginSetup, ContainsTheMeshAsFileAndAsArrays) {
  const TemporaryFolder folder;
  const Bin bin;
  PluginSetup setup{Objects()};
  setup.intrinsics = {320, 240, 300, 310, 159, 119};
  setup.bin = &bin;
  setup.grippers = {{"jaw", "parallel_jaw", 0.08, 0.1, "stroke_m: 0.08\n"}};
  MessageWriter message;
  WriteSetup(setup, folder.path(), message);
  const MessageValue read = Received(message);
  EXPECT_EQ(read.At("verb").Text(""), "setup");
  EXPECT_THAT(read.At("camera").At("K").Numbers(""),
              ElementsAre(300, 0, 159, 0, 310, 119, 0, 0, 1));
  EXPECT_THAT(read.At("bin").At("inner_size_m").Numbers(""), ElementsAre(0.40, 0.30, 0.15));
  EXPECT_EQ(read.At("grippers").Items("")[0].At("max_opening_m").Real(""), 0.08);
  const MessageValue& object = read.At("objects").Items("").at(0);
  EXPECT_EQ(object.At("name").Text(""), "rod");
  const TriangleMesh& mesh = Objects()[0]->mesh_O;
  EXPECT_EQ(object.At("vertices_m").Numbers("").at(7), mesh.vertices[2].y());
  EXPECT_EQ(object.At("triangles").Numbers("").at(3), mesh.triangles[1].x());
  const TriangleMesh file = LoadMesh(object.At("mesh").Text(""));
  EXPECT_NEAR(Diameter(file), Diameter(mesh), 1e-6);
  EXPECT_THAT(object.At("symmetries").At("discrete").Items("")[0].Numbers("").at(11), 0.01);
  EXPECT_THAT(object.At("symmetries").At("continuous").Items("")[0].At("offset_m").Numbers(""),
              ElementsAre(0.1, 0, 0));
  // A second plug-in finds the file and does not write it again.
  const auto time = std::filesystem::last_write_time(object.At("mesh").Text(""));
  MessageWriter again;
  WriteSetup(setup, folder.path(), again);
  EXPECT_EQ(std::filesystem::last_write_time(object.At("mesh").Text("")), time);
}

TEST(PluginFrame, KnownThingsAreSentAndUnknownOnesAreNil) {
  RgbdFrame frame;
  frame.intrinsics = {3, 2, 100, 100, 1, 0.5};
  frame.depth_m = Image<float>(3, 2, 0.5f);
  frame.depth_m(2, 0) = 0.25f;
  MessageWriter unknown;
  WriteEstimate({frame}, Objects(), unknown);
  const MessageValue first = Received(unknown);
  EXPECT_EQ(first.At("verb").Text(""), "estimate");
  EXPECT_THAT(first.At("depth_m").Numbers(""), ElementsAre(0.5, 0.5, 0.25, 0.5, 0.5, 0.5));
  for (const char* key : {"color", "X_WC", "X_CB", "counts"}) {
    EXPECT_EQ(first.Find(key), nullptr) << key;
  }
  frame.color = Image<Rgb8>(3, 2, Rgb8{1, 2, 3});
  const std::vector<int> counts{4, 5};
  MessageWriter known;
  WriteEstimate({frame, Translation({1, 2, 3}), Translation({4, 5, 6}), counts, 77}, Objects(),
                known);
  const MessageValue second = Received(known);
  EXPECT_EQ(second.At("color").Numbers("").size(), 18u);
  EXPECT_EQ(second.At("color").Numbers("")[4], 2);
  EXPECT_THAT(second.At("X_WC").Numbers(""),
              ElementsAre(1, 0, 0, 1, 0, 1, 0, 2, 0, 0, 1, 3, 0, 0, 0, 1));
  EXPECT_EQ(second.At("X_CB").Numbers("")[3], 4);
  EXPECT_EQ(second.At("counts").At("ring").Integer(""), 5);
  EXPECT_EQ(second.At("seed").Integer(""), 77);
  MessageWriter planned;
  const std::vector<PluginPose> poses{{ObjectId(1), Translation({0, 0, 1}), 0.75}};
  WritePlanGrasps({frame}, Objects(), &poses, planned);
  const MessageValue third = Received(planned);
  const MessageValue& pose = third.At("poses").Items("").at(0);
  EXPECT_EQ(pose.At("object").Text(""), "ring");
  EXPECT_THAT(pose.At("t_m").Numbers(""), ElementsAre(0, 0, 1));
  EXPECT_EQ(pose.At("score").Real(""), 0.75);
}

// One grasp of an answer.
std::string GraspFault(const Pose& X_WG, double width_m, const std::string& gripper, int pose) {
  MessageWriter message;
  message.BeginMap(1);
  message.Text("grasps");
  message.BeginList(1);
  message.BeginMap(5);
  const Eigen::Matrix<double, 4, 4, Eigen::RowMajor> rows = X_WG.matrix();
  const size_t shape[] = {4, 4};
  message.Text("X_WG");
  message.Numbers({rows.data(), 16}, shape);
  message.Text("width_m");
  message.Real(width_m);
  message.Text("score");
  message.Real(1);
  message.Text("gripper");
  message.Text(gripper);
  message.Text("pose");
  message.Integer(pose);
  const std::vector<PluginGripper> grippers{{"jaw", "parallel_jaw", 0.08, 0.1, ""}};
  std::vector<std::string> faults;
  const auto grasps = ReadGrasps(Received(message), grippers, 2, &faults);
  if (!faults.empty()) return faults.front();
  EXPECT_EQ(grasps.at(0).X_WG.matrix(), X_WG.matrix());
  EXPECT_EQ(grasps.at(0).pose, pose);
  return "no fault";
}

TEST(PluginGrasps, EachRuleIsCheckedAndNamed) {
  const Pose down = Translation({0.1, 0, 0.05});
  EXPECT_EQ(GraspFault(down, 0.03, "jaw", 1), "no fault");
  EXPECT_EQ(GraspFault(down, 0.03, "jaw", -1), "no fault");
  EXPECT_THAT(GraspFault(down, 0.03, "jwa", 1), HasSubstr("unknown gripper 'jwa'"));
  EXPECT_THAT(GraspFault(down, 0.03, "jaw", 2), HasSubstr("pose 2 is none of the 2 poses"));
  EXPECT_THAT(GraspFault(down, -0.03, "jaw", 1), HasSubstr("width_m is negative"));
  EXPECT_THAT(GraspFault(down, 30, "jaw", 1), HasSubstr("width_m is in millimetres"));
  EXPECT_THAT(GraspFault(down, 0.09, "jaw", 1),
              HasSubstr("width_m is 0.09, but gripper jaw opens at most 0.08 m"));
  EXPECT_EQ(GraspFault(down, 0.08, "jaw", 1), "no fault");
  EXPECT_THAT(GraspFault(Translation({100, 0, 50}), 0.03, "jaw", 1),
              HasSubstr("positions are in metres"));
  Pose mirrored = down;
  mirrored.linear().col(2) *= -1;
  EXPECT_THAT(GraspFault(mirrored, 0.03, "jaw", 1), HasSubstr("X_WG is a reflection"));
}

}  // namespace
}  // namespace pickbed::tests
