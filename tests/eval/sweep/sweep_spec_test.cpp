#include "eval/sweep/sweep_spec.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "scenes/base/error.h"
#include "tests/support/error_of.h"
#include "tests/support/temporary_folder.h"

namespace pickbed::tests {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;

class SweepSpecTest : public testing::Test {
 protected:
  SweepSpec Load(const std::string& yaml) const {
    return LoadSweepSpec(temporary_.Write("sweep.yaml", yaml));
  }
  Sweep Make(const std::string& yaml) const {
    return MakeSweep(Load(yaml), temporary_.path() / "out", "objects");
  }
  std::vector<std::string> Names(const std::string& yaml) const {
    std::vector<std::string> names;
    for (const GridValue& point : GridConfigurations(Load(yaml))) names.push_back(point.name);
    return names;
  }
  const TemporaryFolder temporary_;
};

TEST_F(SweepSpecTest, GridIsTheProductWithTheFirstKeySlowest) {
  EXPECT_THAT(Names("scenario: demo\n"
                    "grid:\n"
                    "  sensor: [ideal, time_of_flight]\n"
                    "  seed: 7..9\n"),
              ElementsAre("sensor=ideal,seed=7", "sensor=ideal,seed=8", "sensor=ideal,seed=9",
                          "sensor=time_of_flight,seed=7", "sensor=time_of_flight,seed=8",
                          "sensor=time_of_flight,seed=9"));
}

TEST_F(SweepSpecTest, PresetsLoadAndTheirWrittenFormReadsBack) {
  for (const auto& entry : std::filesystem::directory_iterator(std::string(PICKBED_SOURCE_DIR) +
                                                               "/scenes/presets/sweeps")) {
    const SweepSpec spec = LoadSweepSpec(entry.path());
    const Sweep sweep = MakeSweep(spec, temporary_.path() / "out", "objects");
    EXPECT_GT(sweep.configurations.size(), 1u) << entry.path();
    const std::string text = SweepText(spec, temporary_.path());
    EXPECT_EQ(SweepText(Load(text), temporary_.path()), text) << entry.path();
  }
}

TEST_F(SweepSpecTest, EachErrorOfTheCellIsAnAxis) {
  for (const std::string key :
       {"hand_eye_mm", "hand_eye_deg", "focal_percent", "principal_px", "depth_bias_mm",
        "depth_scale_percent", "bin_mm", "bin_deg", "repeatability_mm", "force_percent",
        "friction_percent", "mass_percent", "size_percent"}) {
    const Sweep sweep = Make("scenario: demo\nset: {estimator.name: oracle}\ngrid:\n  cell." + key +
                             ": [0, 0.5]\n");
    ASSERT_EQ(sweep.configurations.size(), 2u) << key;
    EXPECT_TRUE(sweep.configurations[0].spec.cell.off()) << key;
    EXPECT_EQ(CellErrorsInWords(sweep.configurations[1].spec.cell), key + " 0.5");
    EXPECT_NE(sweep.configurations[0].identity, sweep.configurations[1].identity) << key;
  }
}

TEST_F(SweepSpecTest, RefusesMoreTrialsThanNumbersForThem) {
  EXPECT_THAT(ErrorOf([&] { Make("scenario: demo\ntrials: 1000000\ngrid: {seed: 1..2148}\n"); }),
              HasSubstr("sweep sweep: 1000000 trials of each of 2148 configurations are too many; "
                        "give at most 999759 trials"));
}

TEST_F(SweepSpecTest, OneAxisCanSetSeveralKeys) {
  EXPECT_THAT(Names("scenario: demo\n"
                    "grid:\n"
                    "  method:\n"
                    "    - {estimator.name: ppf, estimator.mode: verified}\n"
                    "    - {estimator: {name: oracle, noise_mm: 2}}\n"),
              ElementsAre("estimator.name=ppf,estimator.mode=verified",
                          "estimator={name: oracle, noise_mm: 2}"));
}

TEST_F(SweepSpecTest, ValuesMayHaveLabels) {
  const std::string yaml =
      "scenario: demo\n"
      "grid:\n"
      "  seed: [1, 2]\n"
      "  method:\n"
      "    exact: {estimator: {name: oracle, noise_mm: 0}}\n"
      "    rough: {estimator.name: oracle, estimator.noise_mm: 9}\n";
  EXPECT_THAT(Names(yaml), ElementsAre("seed=1,method=exact", "seed=1,method=rough",
                                       "seed=2,method=exact", "seed=2,method=rough"));
  const Sweep sweep = Make(yaml);
  EXPECT_EQ(sweep.configurations[1].spec.estimator.noise_mm, 9);
  EXPECT_EQ(sweep.configurations[2].spec.estimator.name, "oracle");
  EXPECT_EQ(sweep.configurations[2].spec.seed, 2u);
  EXPECT_THAT(sweep.yaml, HasSubstr("method: {exact: {estimator: {name: oracle"));
}

// The later axis would win, although the name of the configuration shows both values.
TEST_F(SweepSpecTest, KeySetByTwoAxesIsRefusedWithItsLine) {
  const auto error = [&](const std::string& grid) {
    return ErrorOf([&] { Load("scenario: demo\ngrid:\n" + grid); });
  };
  EXPECT_THAT(error("  sensor: [ideal]\n  pair:\n    - {sensor: ideal, refiner: none}\n"),
              HasSubstr("sweep.yaml:5: sensor=ideal: sensor also sets sensor"));
  EXPECT_THAT(error("  method:\n    exact: {estimator.name: oracle}\n  estimator.name: [ppf]\n"),
              HasSubstr("sweep.yaml:5: estimator.name=ppf: method also sets estimator.name"));
  EXPECT_THAT(error("  method:\n    exact: {estimator: {name: oracle}}\n  estimator.name: [ppf]\n"),
              HasSubstr("method also sets estimator"));
  EXPECT_THAT(error("  estimator.name: [ppf]\n  method:\n    exact: {estimator: {name: oracle}}\n"),
              HasSubstr("sweep.yaml:5: estimator={name: oracle}: estimator.name also sets"));
  EXPECT_EQ(Names("scenario: demo\ngrid:\n  estimator.name: [oracle]\n"
                  "  estimator.noise_mm: [1, 2]\n")
                .size(),
            2u);
}

TEST_F(SweepSpecTest, CommandLineCannotSetAKeyOfTheGrid) {
  SweepSpec spec = Load(
      "scenario: demo\nset: {gripper: cup_30mm}\ngrid:\n  method:\n    exact: {sensor: ideal}\n");
  SetForAll("gripper=jaw_8cm", spec);
  ASSERT_EQ(spec.set.size(), 1u) << "it replaces the value of the file";
  EXPECT_EQ(spec.set[0].assignment, "gripper=jaw_8cm");
  EXPECT_THAT(
      ErrorOf([&] { SetForAll("sensor=time_of_flight", spec); }),
      testing::AllOf(HasSubstr("setting sensor=time_of_flight: the grid also sets sensor ("),
                     HasSubstr("sweep.yaml:5")));
}

TEST_F(SweepSpecTest, ConfigurationsHaveTheirSettingsAndTrials) {
  const Sweep sweep = Make(
      "scenario: demo\n"
      "trials: 4\n"
      "set: {gripper: cup_30mm, estimator.name: oracle}\n"
      "grid:\n"
      "  objects.0.count: [2, 3]\n"
      "  sensor: [ideal]\n");
  ASSERT_EQ(sweep.configurations.size(), 2u);
  for (int i = 0; i < 2; ++i) {
    const Configuration& point = sweep.configurations[i];
    EXPECT_EQ(point.number, i);
    EXPECT_EQ(point.first_trial, 4 * i);
    EXPECT_EQ(point.trials, 4);
    EXPECT_EQ(point.spec.objects[0].count, 2 + i);
    EXPECT_EQ(point.spec.gripper, "cup_30mm");
    EXPECT_EQ(point.spec.sensor, "ideal");
    EXPECT_EQ(point.spec.estimator.name, "oracle");
    EXPECT_EQ(point.objects.size(), point.spec.objects.size());
  }
  EXPECT_NE(sweep.configurations[0].identity, sweep.configurations[1].identity);
}

TEST_F(SweepSpecTest, WrittenTextGivesTheSameSweep) {
  temporary_.Write("own.yaml", "objects: [{name: rod, count: 3}]\n");
  const std::string yaml =
      "scenario: own.yaml\n"
      "trials: 2\n"
      "set: {estimator.name: oracle, camera.eye_m: [0, 0, 0.8]}\n"
      "grid:\n  seed: 1..2\n  pair:\n    - sensor: ideal\n      refiner: none\n"
      "    - {sensor: active_stereo}\n"
      "slurm: {shards: 3, options: '--account=lab --qos=low'}\n";
  const std::filesystem::path out = temporary_.path() / "results" / "here";
  const Sweep first = MakeSweep(Load(yaml), out, "objects");
  const auto written = temporary_.Write("results/here/sweep.yaml", first.yaml);
  const SweepSpec again = LoadSweepSpec(written);
  const Sweep second = MakeSweep(again, out, "objects");
  EXPECT_EQ(second.yaml, first.yaml);
  EXPECT_EQ(again.slurm.shards, 3);
  EXPECT_EQ(again.slurm.options, "--account=lab --qos=low");
  ASSERT_EQ(second.configurations.size(), 4u);
  for (int i = 0; i < 4; ++i) {
    EXPECT_EQ(second.configurations[i].name, first.configurations[i].name);
    EXPECT_EQ(second.configurations[i].identity, first.configurations[i].identity);
  }
}

TEST_F(SweepSpecTest, ARangeEndsAtTheLargestNumber) {
  const SweepSpec spec =
      Load("scenario: demo\ngrid:\n  seed: 9223372036854775806..9223372036854775807\n");
  ASSERT_EQ(spec.grid.size(), 1u);
  ASSERT_EQ(spec.grid[0].values.size(), 2u);
  EXPECT_EQ(spec.grid[0].values[0].name, "seed=9223372036854775806");
  EXPECT_EQ(spec.grid[0].values[1].name, "seed=9223372036854775807");
}

struct BadSweep {
  const char* name;
  const char* yaml;
  const char* place;  // file and line of the fault
  const char* what;
};

class BadSweepTest : public SweepSpecTest, public testing::WithParamInterface<BadSweep> {};

TEST_P(BadSweepTest, IsRefusedInOneLineWithItsPlace) {
  const std::string error = ErrorOf([&] { Make(GetParam().yaml); });
  EXPECT_THAT(error, HasSubstr(GetParam().what));
  EXPECT_THAT(error, HasSubstr(GetParam().place));
  EXPECT_THAT(error, Not(HasSubstr("\n")));
}

INSTANTIATE_TEST_SUITE_P(
    SweepSpec, BadSweepTest,
    testing::Values(
        BadSweep{"EmptyGrid", "scenario: demo\ngrid: {}\n", "sweep.yaml:2", "the grid is empty"},
        BadSweep{"NoGrid", "scenario: demo\n", "sweep.yaml", "has no grid"},
        BadSweep{"EmptyList", "scenario: demo\ngrid:\n  sensor: []\n", "sweep.yaml:3",
                 "the list is empty"},
        BadSweep{"NoList", "scenario: demo\ngrid:\n  sensor: ideal\n", "sweep.yaml:3",
                 "must be a list of values"},
        BadSweep{"LabelWithoutSettings", "scenario: demo\ngrid:\n  method:\n    ppf: ppf\n",
                 "sweep.yaml:4", "a label needs settings"},
        BadSweep{"NoLabels", "scenario: demo\ngrid:\n  method: {}\n", "sweep.yaml:3",
                 "has no value"},
        BadSweep{"LabelTwice",
                 "scenario: demo\ngrid:\n  method:\n    a: {seed: 1}\n    a: {seed: 2}\n",
                 "sweep.yaml:5", "is given twice"},
        BadSweep{"KeyUnderALabel", "scenario: demo\ngrid:\n  method:\n    a: {sed: 1}\n",
                 "sweep.yaml:4", "did you mean 'seed'"},
        BadSweep{"UnknownKey", "scenario: demo\ngrid:\n  seed: [1]\n  estimatr.name: [ppf]\n",
                 "sweep.yaml:4", "did you mean 'estimator'"},
        BadSweep{"WrongValue", "scenario: demo\ngrid:\n  refiner: [none, icp]\n", "sweep.yaml:3",
                 "icp"},
        BadSweep{"OutOfRange", "scenario: demo\nset: {gripper: jaw_8cm}\ngrid:\n  seed: [1, -4]\n",
                 "sweep.yaml:4", "whole number"},
        BadSweep{"UnknownEstimator", "scenario: demo\ngrid:\n  estimator.name: [pff]\n",
                 "sweep.yaml:3", "did you mean 'ppf'"},
        BadSweep{"UnknownSensor", "scenario: demo\ngrid:\n  seed: [1]\n  sensor: [idael]\n",
                 "sweep.yaml:4", "did you mean 'ideal'"},
        BadSweep{"UnknownTopKey", "scenario: demo\ngird: {seed: [1]}\n", "sweep.yaml:2",
                 "did you mean 'grid'"},
        BadSweep{"UnknownScenario", "scenario: dmeo\ngrid: {seed: [1]}\n", "sweep.yaml:1",
                 "did you mean 'demo'"},
        BadSweep{"ValueTwice", "scenario: demo\ngrid:\n  seed: [1, 2, 1]\n", "sweep.yaml:3",
                 "is in the grid twice"},
        BadSweep{"KeyTwice", "scenario: demo\ngrid:\n  seed: [1]\n  seed: [2]\n", "sweep.yaml:4",
                 "is given twice"},
        BadSweep{"BackwardRange", "scenario: demo\ngrid:\n  seed: 9..3\n", "sweep.yaml:3",
                 "ascending"},
        BadSweep{"WidestRange",
                 "scenario: demo\ngrid:\n  seed: -9223372036854775808..9223372036854775807\n",
                 "sweep.yaml:3", "has more than"},
        BadSweep{"RangeBeyond64Bits",
                 "scenario: demo\ngrid:\n  seed: 18446744073709551610..18446744073709551612\n",
                 "sweep.yaml:3", "must be a list of values"},
        BadSweep{"WithinItself", "scenario: demo\ngrid: {seed: [1]}\nset: &a [*a]\n", "sweep.yaml",
                 "refers to itself"},
        BadSweep{"TrialsBeyond32Bits", "scenario: demo\ntrials: -2147483649\ngrid: {seed: [1]}\n",
                 "sweep.yaml:2", "must be a whole number from 1 to 1000000"},
        BadSweep{"TooManyTrials", "scenario: demo\ntrials: 2147483647\ngrid: {seed: [1]}\n",
                 "sweep.yaml:2", "must be a whole number from 1 to 1000000"},
        BadSweep{"Trials", "scenario: demo\ntrials: none\ngrid: {seed: [1]}\n", "sweep.yaml:2",
                 "whole number"},
        BadSweep{"UnknownSlurmKey", "scenario: demo\ngrid: {seed: [1]}\nslurm:\n  queue: x\n",
                 "sweep.yaml:4", "partition"},
        BadSweep{"NoYaml", "scenario: [demo\n", "sweep.yaml", "not valid YAML"}),
    [](const auto& info) { return info.param.name; });

TEST_F(SweepSpecTest, LongNamesAndManyKeysAreRefusedInOneLine) {
  EXPECT_THAT(
      ErrorOf([&] { Make("scenario: " + std::string(5000, 'x') + "\ngrid: {seed: [1]}\n"); }),
      testing::AllOf(HasSubstr("sweep.yaml:1"), Not(HasSubstr("\n"))));
  std::string many = "scenario: demo\ngrid:\n";
  for (int i = 0; i < 20000; ++i) many += fmt::format("  objects.{}.count: [1]\n", i);
  EXPECT_THAT(ErrorOf([&] { Make(many); }),
              testing::AllOf(HasSubstr("sweep.yaml"), Not(HasSubstr("\n"))));
}

}  // namespace
}  // namespace pickbed::tests
