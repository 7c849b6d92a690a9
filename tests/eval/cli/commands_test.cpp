#include "eval/cli/commands.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "eval/runtime/progress.h"
#include "tests/support/temporary_folder.h"

namespace pickbed::tests {
namespace {

using testing::HasSubstr;
using testing::StartsWith;

struct Outcome {
  int status = 0;
  std::string out, err;
};

Outcome Pickbed(std::vector<std::string> words) {
  words.insert(words.begin(), "pickbed");
  std::vector<char*> argv;
  for (std::string& word : words) argv.push_back(word.data());
  testing::internal::CaptureStdout();
  testing::internal::CaptureStderr();
  Outcome outcome;
  outcome.status = Dispatch(static_cast<int>(argv.size()), argv.data());
  fflush(stdout);
  outcome.out = testing::internal::GetCapturedStdout();
  outcome.err = testing::internal::GetCapturedStderr();
  return outcome;
}

// A temporary folder with a scenario of one object.
class CommandsTest : public testing::Test {
 protected:
  std::string File(const std::string& name, const std::string& text) const {
    std::ofstream(folder_ / name) << text;
    return (folder_ / name).string();
  }
  std::string Scenario(const std::string& more = "") const {
    return File("one.yaml", "objects: [{name: rod, count: 2}]\n" + more);
  }
  std::string Out() const { return (folder_ / "out").string(); }

  const TemporaryFolder temporary_;
  const std::filesystem::path folder_ = temporary_.path();
};

// Expects exit status 1, nothing on stdout, and one line on stderr that names the fault.
void ExpectRefused(const std::vector<std::string>& words, const std::string& named) {
  const Outcome outcome = Pickbed(words);
  SCOPED_TRACE(testing::PrintToString(words));
  EXPECT_EQ(outcome.status, 1);
  EXPECT_EQ(outcome.out, "");
  EXPECT_THAT(outcome.err, StartsWith("pickbed: "));
  EXPECT_THAT(outcome.err, HasSubstr(named));
  EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << outcome.err;
}

TEST_F(CommandsTest, HelpOfEveryCommandHasAnExampleAndExitsZero) {
  EXPECT_EQ(Pickbed({"--help"}).status, 0);
  for (const CommandRow& row : CommandTable()) {
    EXPECT_THAT(Pickbed({"--help"}).out, HasSubstr(row.name));
    const Outcome outcome = Pickbed({row.name, "--help"});
    EXPECT_EQ(outcome.status, 0) << row.name;
    EXPECT_THAT(outcome.out, HasSubstr(std::string("pickbed ") + row.name));
    EXPECT_THAT(outcome.out, HasSubstr("Example: "));
  }
}

TEST_F(CommandsTest, WithoutACommandTheFirstCommandsAreShownFirst) {
  const Outcome outcome = Pickbed({});
  EXPECT_EQ(outcome.status, 1);
  EXPECT_EQ(outcome.err, "");
  size_t at = outcome.out.find("First commands:");
  for (const char* name : {"run", "report", "compare", "sweep", "estimate", "doctor"}) {
    const size_t next = outcome.out.find(std::string("\n  ") + name + " ", at);
    ASSERT_NE(next, std::string::npos) << name;
    at = next;
  }
  EXPECT_EQ(outcome.out.find("\n\nMore commands:"), outcome.out.find('\n', at + 1));
}

TEST_F(CommandsTest, MistypedCommandsAndOptionsAreNamed) {
  ExpectRefused({"rnu"}, "did you mean 'run'");
  ExpectRefused({"run"}, "SCENARIO");
  ExpectRefused({"run", Scenario(), "--job", "2"}, "--job");
  ExpectRefused({"run", Scenario(), "--jobs", "0"}, "--jobs");
  ExpectRefused({"run", Scenario(), "--jobs", "two"}, "--jobs");
  ExpectRefused({"run", Scenario(), "--trials", "0"}, "--trials");
  ExpectRefused({"drop", Scenario(), "--trial", "-1"}, "--trial");
  ExpectRefused({"list", "griper"}, "did you mean 'grippers'");
}

TEST_F(CommandsTest, MistypedSubcommandsAreNamed) {
  ExpectRefused({"object", "ad", "x.stl"},
                "unknown subcommand 'ad'; did you mean 'add'? known: add, sample, families");
  ExpectRefused({"object"}, "subcommand is required");
}

TEST_F(CommandsTest, NumbersThatAreNotFiniteAreRefused) {
  const std::string mesh = File("a.obj", "v 0 0 0\n");
  ExpectRefused({"object", "add", mesh, "--name", "a", "--friction", "nan"},
                "--friction nan: must be a number");
  ExpectRefused({"score", "--bop", Out(), mesh, "--vsd-delta", "nan"}, "--vsd-delta: 'nan'");
  ExpectRefused({"train", "rod", "--minutes", "nan"}, "--minutes: 'nan' is no number from 0");
  ExpectRefused({"train", "rod", "--minutes", "inf"}, "--minutes: 'inf' is no number from 0");
}

TEST_F(CommandsTest, NumbersBelowALimitAreRefusedWithAShortRange) {
  ExpectRefused({"train", "rod", "--minutes", "-1"}, "--minutes: '-1' is no number from 0; see ");
  ExpectRefused({"train", "completion", "--minutes", "-1"}, "'-1' is no number from 0; see ");
  ExpectRefused({"score", "--bop", Out(), "a.csv", "--vsd-delta", "0"},
                "--vsd-delta: '0' is no number above 0; see ");
  ExpectRefused({"drop", Scenario(), "--trial", "-1"}, "--trial: '-1' is no number from 0; see ");
}

TEST_F(CommandsTest, InvalidExplainOptionsAreRefused) {
  const std::vector<std::string> estimate{"estimate", Scenario(), "--out", Out()};
  const auto with = [&](std::vector<std::string> more) {
    more.insert(more.begin(), estimate.begin(), estimate.end());
    return more;
  };
  ExpectRefused(with({"--explain", "first"}), "--explain first");
  ExpectRefused(with({"--explain=-1"}), "--explain -1");
  ExpectRefused(with({"--explain", "1/2"}), "number of a trial");
  ExpectRefused(with({"--explain"}), "--explain");
  ExpectRefused(with({"--explain", "0", "--trials", "3"}), "--trials");
  ExpectRefused(with({"--explain", "0", "--estimator", "descriptor,ppf"}), "one estimator");
  ExpectRefused(with({"--explain", "0", "--estimator", "ppf"}), "'ppf'");
  ExpectRefused(with({"--explain", "0", "--estimator", "oracle"}), "descriptor");
  EXPECT_FALSE(std::filesystem::exists(Out())) << "a refused command left a folder";
}

TEST_F(CommandsTest, BadScenariosAreRefusedByEveryCommandThatReadsOne) {
  const std::string missing = (folder_ / "none.yaml").string();
  const std::string empty = File("empty.yaml", "objects: []\n");
  for (const char* command : {"run", "drop", "render", "estimate"}) {
    ExpectRefused({command, missing}, "none.yaml");
    ExpectRefused({command, folder_.string()}, "is a folder");
    ExpectRefused({command, empty}, "objects");
    ExpectRefused({command, File("broken.yaml", "objects: [")}, "broken.yaml");
    ExpectRefused({command, Scenario(), "--set", "objects.0.count=0"}, "count");
    ExpectRefused({command, Scenario(), "--set", "objects.0.count=-3"}, "count");
    ExpectRefused({command, Scenario(), "--set", "objects.0.name=rodd"}, "rod");
    ExpectRefused({command, Scenario(), "--set", "sedd=3"}, "did you mean 'seed'");
    ExpectRefused({command, Scenario(), "--set", "appearance.glos=[0, 1]"}, "did you mean 'gloss'");
    ExpectRefused({command, Scenario(), "--set", "appearance.gloss=[1, 0]"}, "appearance.gloss");
    ExpectRefused({command, Scenario(), "--set", "seed"}, "seed");
    ExpectRefused({command, Scenario(), "--set", "camera.eye_m=[0.203, 0, 0.1]"}, "wall");
    ExpectRefused({command, Scenario(), "--set", "camera.target_m=[0, 0, 5]"}, "looks away");
    ExpectRefused({command, Scenario(), "--set", "camera.eye_m=[0, 0, -1]"},
                  "under the bin's floor");
  }
}

TEST_F(CommandsTest, UnknownNamesAreRefusedWithASuggestion) {
  ExpectRefused({"run", Scenario(), "--out", Out(), "--set", "estimator.name=oracel"}, "oracle");
  ExpectRefused({"run", Scenario(), "--out", Out(), "--set", "gripper=jaw_8"}, "jaw_8cm");
  ExpectRefused({"run", Scenario(), "--out", Out(), "--set", "sensor=structured_lite"},
                "structured_light");
  ExpectRefused({"train", "rodd"}, "rod");
  ExpectRefused({"train"}, "no objects to train for");
  EXPECT_FALSE(std::filesystem::exists(Out())) << "a refused run leaves no folder";
}

TEST_F(CommandsTest, FormerNamesOfOptionsAreAcceptedWithOneLine) {
  const std::string missing = (folder_ / "missing.yaml").string();
  const Outcome former = Pickbed({"run", missing, "--lost-pictures", "3"});
  EXPECT_THAT(former.err,
              StartsWith("pickbed: '--lost-pictures' is deprecated, write '--failure-pictures'\n"));
  EXPECT_THAT(former.err, HasSubstr("missing.yaml")) << "the option was not accepted";
  ExpectRefused({"run", missing, "--lost-pictures", "-1"}, "--lost-pictures");
  EXPECT_THAT(Pickbed({"run", "--help"}).out, testing::Not(HasSubstr("--lost-pictures")));
}

// An object that only the scenario knows is not found by its name.
TEST_F(CommandsTest, AnUntrainedMeshOfTheScenarioIsTrainedFromTheScenario) {
  File("box.obj",
       "v 0 0 0\nv 0.04 0 0\nv 0 0.03 0\nv 0 0 0.02\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n");
  const std::string scenario = File(
      "mesh.yaml", "objects: [{name: mine, count: 1, mass_kg: 0.1, mesh: box.obj}]\ntrials: 1\n");
  ExpectRefused({"run", scenario, "--out", Out(), "--jobs", "1"},
                "`pickbed train --scenario " + scenario + "`");
  ExpectRefused({"estimate", scenario, "--out", Out()},
                "`pickbed train --scenario " + scenario + "`");
  const std::string sweep =
      File("sweep.yaml", "scenario: mesh.yaml\ngrid: {sensor: [ideal, time_of_flight]}\n");
  ExpectRefused({"sweep", sweep, "--out", Out(), "--jobs", "1"},
                "`pickbed train --scenario " + scenario + "`");
}

TEST_F(CommandsTest, UnusableMeshesAreRefused) {
  const auto with_mesh = [&](const std::string& mesh) {
    return File("mesh.yaml",
                "objects: [{name: mine, count: 1, mass_kg: 0.1, mesh: " + mesh + "}]\n");
  };
  ExpectRefused({"drop", with_mesh("none.obj")}, "none.obj");
  File("nan.obj", "v nan 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n");
  ExpectRefused({"drop", with_mesh("nan.obj")}, "nan.obj");
  File("faceless.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\n");
  ExpectRefused({"drop", with_mesh("faceless.obj")}, "faceless.obj");
  File("huge.obj", "v 0 0 0\nv 9 0 0\nv 0 9 0\nv 0 0 9\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n");
  ExpectRefused({"drop", with_mesh("huge.obj")}, "larger than the bin");
}

// The command writes an image and prints the number of visible instances.
TEST_F(CommandsTest, RenderPrintsTheNumberOfVisibleInstances) {
  const Outcome whole = Pickbed({"render", Scenario(), "--out", Out()});
  EXPECT_EQ(whole.status, 0) << whole.err;
  EXPECT_THAT(whole.out, HasSubstr("2 of 2 instances are visible"));
  // From beside the bin, a wall occludes them.
  const Outcome hidden =
      Pickbed({"render", Scenario(), "--out", Out(), "--set", "camera.eye_m=[0.6, 0, 0.06]"});
  EXPECT_EQ(hidden.status, 0) << hidden.err;
  EXPECT_THAT(hidden.out, HasSubstr("0 of 2 instances are visible"));
}

TEST_F(CommandsTest, UnusableBopFilesAreRefused) {
  const std::string none = (folder_ / "none").string();
  const std::string empty = (folder_ / "empty").string();
  std::filesystem::create_directories(empty);
  const std::string header = "scene_id,im_id,obj_id,score,R,t,time\n";
  const std::string good = File("good.csv", header);
  ExpectRefused({"dataset", "check", none}, none);
  ExpectRefused({"score", "--bop", none, good}, none);
  ExpectRefused({"score", "--bop", empty, good}, "has no scene folder");
  ExpectRefused({"score", "--bop", empty, none}, none);
  ExpectRefused({"score", "--bop", empty, File("a.csv", "scene,image\n")}, "a.csv:1");
  ExpectRefused({"score", "--bop", empty, File("b.csv", header + "1,0,1,0.5\n")}, "b.csv:2");
  ExpectRefused(
      {"score", "--bop", empty, File("c.csv", header + "1,0,1,nan,1 0 0 0 1 0 0 0 1,0 0 500,-1\n")},
      "c.csv:2: score 'nan'");
  ExpectRefused(
      {"score", "--bop", empty, File("d.csv", header + "1,0,1,1,2 0 0 0 1 0 0 0 1,0 0 500,-1\n")},
      "d.csv:2: R is no rotation");
  ExpectRefused({"estimate", "--bop", none, "--out", Out()}, none);
  ExpectRefused({"execute", "--dataset", empty, good, "--out", Out()}, "no stored scenes");
  ExpectRefused({"execute", "--dataset", none, "--oracle", "--out", Out()}, none);
  ExpectRefused({"dataset", "truth", empty, "--out", Out()}, "has no scene folder");
  EXPECT_FALSE(std::filesystem::exists(Out())) << "a refused command leaves no folder";
}

TEST_F(CommandsTest, UnusableOutputFoldersAreRefused) {
  const std::string under_a_file = File("file", "no folder") + "/out";
  for (const char* command : {"run", "drop", "render", "estimate"}) {
    std::vector<std::string> words{command, Scenario(), "--out", under_a_file};
    if (command == std::string("run"))
      words.insert(words.end(), {"--set", "estimator.name=oracle"});
    ExpectRefused(words, "--out");
  }
}

TEST_F(CommandsTest, SensorShowDrawsAProfileAndRefusesABadOne) {
  const std::string picture = (folder_ / "new" / "tof.png").string();
  const Outcome outcome = Pickbed({"sensor", "show", "time_of_flight", "--out", picture});
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_THAT(outcome.out, HasSubstr(picture));
  EXPECT_GT(std::filesystem::file_size(picture), 20000u);
  ExpectRefused({"sensor"}, "ACTION");
  ExpectRefused({"sensor", "show"}, "SENSOR");
  ExpectRefused({"sensor", "draw", "ideal"}, "draw");
  ExpectRefused({"sensor", "show", "time_of_fligth"}, "did you mean 'time_of_flight'");
  ExpectRefused({"sensor", "show", File("bad.yaml", "edge_dropout: 2\n")}, "edge_dropout");
}

TEST_F(CommandsTest, ListNamesAllChoices) {
  const Outcome all = Pickbed({"list"});
  EXPECT_EQ(all.status, 0);
  for (const char* name :
       {"demo", "rod", "oracle", "pcl_icp", "jaw_8cm", "structured_light", "mssd"}) {
    EXPECT_THAT(all.out, HasSubstr(name));
  }
  EXPECT_THAT(Pickbed({"list", "settings"}).out, HasSubstr("max_failures_in_row"));
  EXPECT_THAT(Pickbed({"list", "settings"}).out, HasSubstr("background_cell_px"));
  EXPECT_THAT(Pickbed({"list", "grippers"}).out, testing::Not(HasSubstr("oracle")));
}

TEST(FormatDuration, UsesClockNotation) {
  EXPECT_EQ(FormatDuration(0), "0:00");
  EXPECT_EQ(FormatDuration(65.4), "1:05");
  EXPECT_EQ(FormatDuration(3599.7), "1:00:00");
  EXPECT_EQ(FormatDuration(7384), "2:03:04");
  EXPECT_EQ(FormatDuration(-1), "?");
  EXPECT_EQ(FormatDuration(1.0 / 0.0), "?");
}

}  // namespace
}  // namespace pickbed::tests
