#include "sim/sensor/sensor_profile.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>

#include "scenes/base/error.h"
#include "scenes/base/files.h"
#include "scenes/objects/object_catalog.h"
#include "tests/support/temporary_folder.h"

namespace pickbed::tests {
namespace {

using testing::AllOf;
using testing::HasSubstr;

// Methods that were tuned on less noise than this fail on real cameras.
TEST(SensorProfile, StructuredLightHasAtLeastThisNoise) {
  const SensorProfile p = LoadSensorProfile("structured_light");
  EXPECT_EQ(p.name, "structured_light");
  EXPECT_GE(AxialSigma_m(p, 1, 0), 0.001);
  EXPECT_GE(p.lateral_sigma_px, 0.4);
  EXPECT_GE(p.edge_dropout, 0.45);
  EXPECT_LE(p.edge_step_m, 0.012);
  EXPECT_GE(p.random_dropout, 0.004);
  EXPECT_GE(p.quantization_m, 0.0005);
}

TEST(SensorProfile, EveryShippedProfileLoadsAndNamesItsSource) {
  const std::vector<std::string> names = SensorProfileNames();
  EXPECT_THAT(names, testing::IsSupersetOf({"ideal", "structured_light", "kinect_v1",
                                            "active_stereo", "time_of_flight"}));
  for (const std::string& name : names) {
    EXPECT_EQ(LoadSensorProfile(name).name, name);
    EXPECT_EQ(ChangesNothing(LoadSensorProfile(name)), name == "ideal");
    std::ifstream file(AssetsDir() / "sensors" / (name + ".yaml"));
    const std::string text{std::istreambuf_iterator<char>(file), {}};
    EXPECT_THAT(text, name == "ideal" ? HasSubstr("No source") : HasSubstr("# From ")) << name;
  }
}

// The published fits, at depths and slants inside the fitted range.
TEST(SensorProfile, SigmasMatchThePublishedFits) {
  constexpr double kHalfPi = 1.5707963267948966;
  const SensorProfile kinect_2 = LoadSensorProfile("time_of_flight");
  const SensorProfile kinect_1 = LoadSensorProfile("kinect_v1");
  const SensorProfile light = LoadSensorProfile("structured_light");
  for (const double z : {0.7, 1.0, 2.0, 3.5}) {
    for (const double a : {0.0, 0.3, 0.8, 1.1}) {
      const double ratio = a / (kHalfPi - a);
      EXPECT_NEAR(AxialSigma_m(kinect_2, z, a),
                  1e-3 * (1.5 - 0.5 * z + 0.3 * z * z + 0.1 * z * std::sqrt(z) * ratio * ratio),
                  1e-9);
      EXPECT_NEAR(AxialSigma_m(kinect_1, z, a),
                  1e-3 * (1.2 + 1.9 * (z - 0.4) * (z - 0.4) + 0.1 / std::sqrt(z) * ratio * ratio),
                  1e-9);
      EXPECT_NEAR(LateralSigma_px(kinect_1, a, 580), 0.8 + 0.035 * ratio, 1e-9);
      EXPECT_NEAR(LateralSigma_px(kinect_1, a, 1160), 1.6 + 0.07 * ratio, 1e-9);
      EXPECT_NEAR(AxialSigma_m(light, z, a) - AxialSigma_m(light, z, 0),
                  1e-4 / std::sqrt(z) * ratio * ratio, 1e-9);
      EXPECT_NEAR(LateralSigma_px(light, a, 1067), 0.4 + 0.035 * ratio, 1e-9);
    }
  }
  EXPECT_EQ(AxialSigma_m(light, 1, kHalfPi), AxialSigma_m(light, 1, kSteepestSlant_rad));
}

TEST(SensorProfile, ReadingStepFollowsTheDisparityStep) {
  // z and the next reading: f b / (f b / z - step).
  const SensorProfile p = LoadSensorProfile("active_stereo");
  const double fb = 424 * 0.05, z = 2;
  EXPECT_NEAR(ReadingStep_m(p, z, 999), fb / (fb / z - 1.0 / 32) - z, 0.01 * 0.006);
  SensorProfile metres;
  metres.quantization_m = 0.002;
  EXPECT_EQ(ReadingStep_m(metres, z, 999), 0.002);
}

TEST(SensorProfile, InvalidInputIsRefusedWithAReason) {
  const TemporaryFolder folder;
  const std::string path = (folder.path() / "bad_sensor.yaml").string();
  const auto message_of = [](const std::string& name_or_path) -> std::string {
    try {
      LoadSensorProfile(name_or_path);
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  };
  const auto refusal = [&](const std::string& yaml) {
    std::ofstream(path) << yaml << "\n";
    const std::string message = message_of(path);
    EXPECT_THAT(message, AllOf(HasSubstr("bad_sensor.yaml"), testing::Not(HasSubstr("\n"))));
    return message;
  };
  EXPECT_THAT(message_of("structured_ligth"), HasSubstr("did you mean 'structured_light'"));
  EXPECT_THAT(message_of((folder.path() / "none.yaml").string()), HasSubstr("none.yaml"));
  EXPECT_THAT(refusal("min_range_m: 2\nmax_range_m: 1"), HasSubstr("min_range_m 2 must be less"));
  EXPECT_THAT(refusal("axial_sigma: 1"), HasSubstr("axial_sigma"));
  EXPECT_THAT(refusal("axial_slant_power: 0.3"), HasSubstr("axial_slant_power 0.3"));
  EXPECT_THAT(refusal("axial_linear_m: -0.001\naxial_floor_m: 0.002"), HasSubstr("axial_linear_m"));
  EXPECT_THAT(refusal("axial_linear_m: -0.002\naxial_floor_m: 0.0009\naxial_sigma_m: 0.001"),
              HasSubstr("at 1 m negative"));
  EXPECT_THAT(refusal("disparity_step_px: 0.1"), HasSubstr("needs baseline_m"));
  EXPECT_THAT(refusal("disparity_step_px: 0.1\nbaseline_m: 0.1\nsensor_x_m: 0.1"),
              HasSubstr("the same as sensor_x_m"));
  EXPECT_THAT(refusal("lateral_focal_px: 1e-30"), HasSubstr("lateral_focal_px 1e-30 must be"));
  EXPECT_THAT(refusal("disparity_focal_px: 0.5"), HasSubstr("disparity_focal_px 0.5 must be"));
  EXPECT_THAT(refusal("dark_luma: 0.5\nshiny_luma: 0.4"), HasSubstr("dark_luma 0.5"));
  for (const char* key :
       {"axial_floor_m",      "axial_sigma_m",     "axial_slant_m", "lateral_sigma_px",
        "lateral_slant_px",   "lateral_focal_px",  "edge_dropout",  "random_dropout",
        "grazing_dropout",    "grazing_start_rad", "dark_dropout",  "dark_luma",
        "shiny_dropout",      "shiny_luma",        "flying_share",  "disparity_step_px",
        "disparity_focal_px", "quantization_m",    "edge_step_m",   "min_range_m",
        "max_range_m",        "correlation_px",    "window_px"}) {
    for (const char* value : {"-1", ".nan", ".inf", "much"}) {
      EXPECT_THAT(refusal(std::string(key) + ": " + value), HasSubstr(key));
    }
  }
  EXPECT_THAT(refusal("baseline_m: 2"), HasSubstr("baseline_m"));
  EXPECT_THAT(refusal("sensor_x_m: -2"), HasSubstr("sensor_x_m"));
}

// Only within the last number a cut leaves a file that is complete.
TEST(SensorProfile, AFileThatIsCutIsRefused) {
  const TemporaryFolder folder;
  const std::string path = (folder.path() / "cut.yaml").string();
  for (const std::string& name : SensorProfileNames()) {
    const std::string text = ReadFileText(AssetsDir() / "sensors" / (name + ".yaml"));
    const size_t value = text.rfind(": ") + 2;
    for (size_t size = 0; size <= value; ++size) {
      std::ofstream(path) << text.substr(0, size);
      EXPECT_THROW(LoadSensorProfile(path), InputError) << name << " of " << size << " bytes";
    }
    std::ofstream(path) << text.substr(0, text.rfind('\n'));  // without a last line break
    EXPECT_NO_THROW(LoadSensorProfile(path)) << name;
  }
}

TEST(SensorProfile, AMissingKeyIsNamed) {
  const TemporaryFolder folder;
  const std::string path = (folder.path() / "part.yaml").string();
  const std::string ranges = "min_range_m: 0.2\nmax_range_m: 2\n";
  const std::pair<std::string, std::string> cases[] = {
      {"name: part\n" + ranges + "edge_dropout: 0.1\n", "quantization_m"},
      {"# a sensor name: part\n" + ranges + "quantization_m: 0.001\n", "name"}};
  for (const auto& [content, key] : cases) {
    std::ofstream(path) << content;
    try {
      LoadSensorProfile(path);
      ADD_FAILURE() << key;
    } catch (const InputError& error) {
      EXPECT_THAT(error.what(), AllOf(HasSubstr("part.yaml: " + key + " is missing"),
                                      testing::Not(HasSubstr("\n"))));
    }
  }
}

}  // namespace
}  // namespace pickbed::tests
