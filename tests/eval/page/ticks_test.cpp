#include "eval/page/ticks.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/layer.h"

namespace pickbed::tests {
namespace {

using testing::DoubleEq;
using testing::ElementsAre;
using testing::Pointwise;

TEST(Ticks, RoundValuesInsideTheRange) {
  EXPECT_THAT(RoundTicks(0, 1),
              Pointwise(testing::DoubleNear(1e-12), std::vector<double>{0, 0.2, 0.4, 0.6, 0.8, 1}));
  EXPECT_THAT(RoundTicks(130, 1480), ElementsAre(500, 1000));
  EXPECT_THAT(RoundTicks(-7, 3), ElementsAre(-6, -4, -2, 0, 2));
  EXPECT_THAT(RoundTicks(0, 0.0031),
              Pointwise(testing::DoubleNear(1e-15), std::vector<double>{0, 0.001, 0.002, 0.003}));
}

TEST(Ticks, EmptyAxisHasOneTickAtItsStart) {
  EXPECT_THAT(RoundTicks(2, 2), ElementsAre(DoubleEq(2)));
}

}  // namespace
}  // namespace pickbed::tests
