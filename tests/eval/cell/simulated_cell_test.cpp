#include "eval/cell/simulated_cell.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/eval/cube_scenario.h"
#include "tests/support/error_of.h"

namespace pickbed::tests {
namespace {

using testing::HasSubstr;

TEST(SimulatedCell, BinOutsideTheSensorRangeIsRefused) {
  ScenarioSpec spec = CubeScenario(1);
  spec.sensor = "time_of_flight";
  spec.camera.target_m = {0, 0, 0};
  spec.camera.eye_m = {0, -0.3, 0.45};
  EXPECT_NO_THROW(SimulatedCell(spec, EasyCube())) << "0.54 m";
  spec.camera.eye_m = {0, -0.3, 0.39};
  EXPECT_THAT(ErrorOf([&] { SimulatedCell(spec, EasyCube()); }),
              testing::AllOf(HasSubstr("sensor: time_of_flight reads from 0.5 to 4.5 m"),
                             HasSubstr("floor is 0.492 m in front of the camera"),
                             HasSubstr("camera.eye_m")));
  spec.camera.eye_m = {0, -0.3, 4.6};
  EXPECT_THAT(ErrorOf([&] { SimulatedCell(spec, EasyCube()); }), HasSubstr("4.610 m"));
}

}  // namespace
}  // namespace pickbed::tests
