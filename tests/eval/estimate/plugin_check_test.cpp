#include "eval/estimate/plugin_check.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>

#include "tests/eval/cube_scenario.h"
#include "tests/support/plugin_scripts.h"

namespace pickbed::tests {
namespace {

using testing::HasSubstr;

class PluginCheckTest : public testing::Test {
 protected:
  // Returns the results by name.
  std::map<std::string, PluginCheckup> Check(const std::string& code,
                                             const std::string& role = kEstimatorRole) {
    PluginCheckJob job;
    job.address = {PythonCommand(folder_, "checked.py", code), "", 5, ""};
    job.role = role;
    job.scenario = {"cubes", CubeScenario(3), EasyCube()};
    job.images = 2;
    std::map<std::string, PluginCheckup> results;
    for (const PluginCheckup& checkup : CheckPlugin(job)) results[checkup.name] = checkup;
    return results;
  }

  TemporaryFolder folder_;
};

std::string Remedy(const PluginCheckup& checkup) {
  return fmt::format("{}: {}\n{}", checkup.ok, checkup.found, fmt::join(checkup.remedy, "\n"));
}

TEST_F(PluginCheckTest, AGoodEstimatorPassesEveryCheck) {
  const auto results = Check(EstimatorCode("    return [pose(score=0.3)]"));
  EXPECT_EQ(results.size(), 11u);
  for (const auto& [name, checkup] : results) EXPECT_TRUE(checkup.ok) << name << Remedy(checkup);
  EXPECT_THAT(results.at("start").found, HasSubstr("'tested', estimator"));
  EXPECT_THAT(results.at("scores").found, HasSubstr("1 of 1 poses have a score below"));
  EXPECT_THAT(results.at("accuracy").found, HasSubstr("0 of 1 poses are right; 0 of 3 visible"));
  EXPECT_THAT(results.at("end").found, HasSubstr("ended with status 0"));
}

TEST_F(PluginCheckTest, EachFaultFailsItsCheck) {
  const auto results =
      Check(EstimatorCode("    if not frame.depth_m.any(): return [1 / 0]\n"
                          "    if frame.color is None: return [pose(score=2)]\n"
                          "    return [pose(score=0.5 + frames / 1000), pose(name='tube')]"));
  EXPECT_THAT(Remedy(results.at("answer")),
              HasSubstr("false: 1 poses in the first image\ngave a wrong pose (number 1): unknown "
                        "object 'tube'"));
  EXPECT_THAT(Remedy(results.at("repeat")), HasSubstr("false: the same image and seed give diff"));
  EXPECT_THAT(Remedy(results.at("blank")), HasSubstr("ZeroDivisionError"));
  EXPECT_THAT(Remedy(results.at("gray")), HasSubstr("score 2 is outside 0 to 1"));
  EXPECT_TRUE(results.at("errors").ok);
}

// Images of a BOP data set have no bin.
TEST_F(PluginCheckTest, AnUnknownBinIsSentUnlessTheProgramNeedsIt) {
  const std::string body = "    frame.X_CB[0, 0]\n    return [pose()]";
  const auto results = Check(EstimatorCode(body));
  EXPECT_TRUE(results.at("answer").ok);
  EXPECT_THAT(Remedy(results.at("no bin")),
              testing::AllOf(HasSubstr("false: reported an error"), HasSubstr("TypeError")));
  EXPECT_FALSE(Check(EstimatorCode(body, "'bin'")).contains("no bin"));
}

TEST_F(PluginCheckTest, AProgramThatIgnoresTheProtocolIsNamed) {
  const auto results = Check(
      "import msgpack, struct, sys, time\n"
      "while True:\n"
      "    head = sys.stdin.buffer.read(4)\n"
      "    if len(head) == 4:\n"
      "        sys.stdin.buffer.read(struct.unpack('>I', head)[0])\n"
      "    else: time.sleep(60)\n"
      "    body = msgpack.packb({'protocol': 1, 'name': 'x', 'roles': ['estimator'], 'poses': "
      "[]})\n"
      "    sys.stdout.buffer.write(struct.pack('>I', len(body)) + body)\n"
      "    sys.stdout.buffer.flush()\n");
  EXPECT_THAT(Remedy(results.at("errors")), HasSubstr("false: an unknown verb is no error"));
  EXPECT_THAT(Remedy(results.at("end")), HasSubstr("false: the program was stopped"));
}

TEST_F(PluginCheckTest, APlannerIsCheckedWithAndWithoutPoses) {
  const auto results = Check(
      "import numpy as np\nimport pickbed_plugin as pb\n@pb.planner\n"
      "def tested(frame, poses):\n"
      "    if poses is None: return [pb.Grasp(np.eye(4), -1, 0.5)]\n"
      "    return [pb.Grasp(np.eye(4), 0.02, p.score, pose=i) for i, p in enumerate(poses)]\n"
      "pb.serve()\n",
      kPlannerRole);
  EXPECT_TRUE(results.at("answer").ok) << Remedy(results.at("answer"));
  EXPECT_THAT(results.at("answer").found, HasSubstr("3 grasps"));
  EXPECT_THAT(Remedy(results.at("unposed")), HasSubstr("width_m is negative"));
}

}  // namespace
}  // namespace pickbed::tests
