#include "scenes/scenario/occlusion_spec.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "scenes/scenario/scenario_spec.h"
#include "tests/support/error_of.h"
#include "tests/support/temporary_folder.h"

namespace pickbed::tests {
namespace {

using ::testing::HasSubstr;

TEST(OcclusionSpec, FractionBelongsToTheBandThatHoldsItByTheMargin) {
  OcclusionSpec spec;
  spec.margin = 0.01;
  spec.bands = {{0, 0.2}, {0.2, 0.4}, {0.6, 1}};
  const struct {
    double fraction;
    int band;
  } cases[] = {{0, 0},    {0.189, 0},  {0.195, -1}, {0.205, -1}, {0.211, 1}, {0.389, 1},
               {0.5, -1}, {0.605, -1}, {0.611, 2},  {0.995, 2},  {1, 2}};
  for (const auto& c : cases) EXPECT_EQ(spec.BandOf(c.fraction), c.band) << c.fraction;
}

// Without a margin, adjacent bands leave no gap and do not overlap.
TEST(OcclusionSpec, AdjacentBandsCoverTheirRangeOnce) {
  OcclusionSpec spec;
  spec.margin = 0;
  for (int step = 0; step <= 1000; ++step) {
    const double fraction = step / 1000.0;
    int holders = 0;
    for (const VisibleBand& band : spec.bands) holders += band.Holds(fraction);
    EXPECT_EQ(holders, fraction >= 0.1 ? 1 : 0) << fraction;
  }
}

TEST(OcclusionSpec, InvalidBandsAreRefusedWithAReason) {
  const auto error_of = [](std::vector<VisibleBand> bands) {
    OcclusionSpec spec;
    spec.bands = std::move(bands);
    return ErrorOf([&] { spec.Validate([](const std::string& key) { return "here." + key; }); });
  };
  EXPECT_EQ(error_of({{0.1, 0.3}, {0.3, 1}}), "no error");
  EXPECT_THAT(error_of({}), HasSubstr("here.bands: is empty"));
  EXPECT_THAT(error_of({{0.5, 0.3}}), HasSubstr("here.bands.0.max = 0.3"));
  EXPECT_THAT(error_of({{0.5, 0.505}}), HasSubstr("margin of 0.005"));
  EXPECT_THAT(error_of({{0.1, 0.3}, {0.2, 0.5}}),
              HasSubstr("here.bands.1.min = 0.2: must not be under bands.0.max = 0.3"));
  EXPECT_THAT(error_of({{0.5, 0.7}, {0.1, 0.3}}), HasSubstr("from the least visible on"));
}

TEST(OcclusionSpec, ScenarioErrorHoldsTheLineOfTheBand) {
  const TemporaryFolder folder;
  const std::filesystem::path file = folder.Write("bands.yaml",
                                                  "objects:\n"
                                                  "  - {name: rod, count: 5}\n"
                                                  "occlusion:\n"
                                                  "  enabled: true\n"
                                                  "  bands:\n"
                                                  "    - {min: 0.4, max: 0.8}\n"
                                                  "    - {min: 0.7, max: 1}\n");
  EXPECT_THAT(ErrorOf([&] { LoadScenario(file); }),
              HasSubstr("bands.yaml:7: occlusion.bands.1.min = 0.7"));
  EXPECT_EQ(ErrorOf([&] { LoadScenario(file, {"occlusion.enabled=false"}); }), "no error");
  EXPECT_EQ(ErrorOf([&] { LoadScenario(file, {"occlusion.bands.1.min=0.8"}); }), "no error");
}

}  // namespace
}  // namespace pickbed::tests
