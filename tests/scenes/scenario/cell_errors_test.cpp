#include "scenes/scenario/cell_errors.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "scenes/scenario/scenario_spec.h"
#include "tests/support/error_of.h"
#include "tests/support/temporary_folder.h"

namespace pickbed::tests {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

constexpr const char* kCellKeys[] = {
    "hand_eye_mm",         "hand_eye_deg", "focal_percent", "principal_px",     "depth_bias_mm",
    "depth_scale_percent", "bin_mm",       "bin_deg",       "repeatability_mm", "force_percent",
    "friction_percent",    "mass_percent", "size_percent"};

// A scenario with these lines in its group `cell`, from line 4 on.
std::string ErrorOfCell(const std::string& lines) {
  const TemporaryFolder folder;
  const std::filesystem::path file = folder.Write("cell.yaml",
                                                  "bin: {inner_size_m: [0.4, 0.3, 0.1]}\n"
                                                  "objects: [{name: rod, count: 5}]\n"
                                                  "cell:\n" +
                                                      lines);
  return ErrorOf([&] { LoadScenario(file); });
}

TEST(CellErrorsSpec, EveryErrorIsOffByDefaultAndAKeyOfAScenario) {
  ScenarioSpec spec;
  EXPECT_TRUE(spec.cell.off());
  EXPECT_EQ(CellErrorsInWords(spec.cell), "");
  for (const char* key : kCellKeys) {
    ScenarioSpec one;
    ApplySetting(fmt::format("cell.{}=1.5", key), [&](SettingsVisitor& v) { one.Visit(v); });
    EXPECT_FALSE(one.cell.off()) << key;
    EXPECT_EQ(CellErrorsInWords(one.cell), fmt::format("{} 1.5", key));
  }
}

TEST(CellErrorsSpec, NegativeErrorIsRefusedWithItsPlace) {
  for (const char* key : kCellKeys) {
    EXPECT_THAT(ErrorOfCell(fmt::format("  {}: -0.5\n", key)),
                AllOf(HasSubstr(fmt::format("cell.yaml:4: cell.{} = -0.5", key)), HasSubstr("0")))
        << key;
  }
}

TEST(CellErrorsSpec, ErrorLargerThanTheBinIsRefusedWithItsPlace) {
  for (const std::string key : {"hand_eye_mm", "depth_bias_mm", "bin_mm", "repeatability_mm"}) {
    EXPECT_EQ(ErrorOfCell("  " + key + ": 300\n"), "no error") << key;
    const std::string error = ErrorOfCell("  " + key + ": 301\n");
    EXPECT_THAT(error, HasSubstr("cell.yaml:4: cell." + key + " = 301: is larger than the bin"));
    EXPECT_THAT(error, HasSubstr("300 mm wide"));
    EXPECT_EQ(error.find('\n'), std::string::npos) << "one line";
  }
}

// The camera is about 0.9 m away, and the bin is 300 mm wide.
TEST(CellErrorsSpec, ErrorThatDisplacesThePartsByMoreThanTheBinIsRefused) {
  const auto accepts = [](const std::string& key, int value) {
    EXPECT_EQ(ErrorOfCell(fmt::format("  {}: {}\n", key, value)), "no error") << key;
  };
  const auto refuses = [](const std::string& key, int value) {
    EXPECT_THAT(ErrorOfCell(fmt::format("  {}: {}\n", key, value)),
                AllOf(HasSubstr(fmt::format("cell.yaml:4: cell.{} = {}: displaces", key, value)),
                      HasSubstr("300 mm; lower it")));
  };
  accepts("hand_eye_deg", 10);
  refuses("hand_eye_deg", 25);
  accepts("principal_px", 50);
  refuses("principal_px", 800);
}

// Factors of force, friction, mass and size must stay positive at the largest deviate.
TEST(CellErrorsSpec, PercentagesLeaveEveryFactorPositive) {
  for (const std::string key : {"force_percent", "friction_percent", "mass_percent", "size_percent",
                                "focal_percent", "depth_scale_percent"}) {
    EXPECT_EQ(ErrorOfCell("  " + key + ": 30\n"), "no error") << key;
    EXPECT_NE(ErrorOfCell("  " + key + ": 34\n"), "no error") << key;
  }
  EXPECT_LT(CellErrorsSpec::kMaxDeviate * 0.30, 1);
}

TEST(CellErrorsSpec, UnknownKeyNamesTheNearestOne) {
  EXPECT_THAT(ErrorOfCell("  hand_eye_m: 1\n"), HasSubstr("did you mean 'hand_eye_mm'?"));
}

}  // namespace
}  // namespace pickbed::tests
