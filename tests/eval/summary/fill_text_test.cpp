#include "eval/summary/fill_text.h"

#include <gmock/gmock.h>

#include "tests/support/layer.h"

namespace pickbed::tests {
namespace {

using testing::HasSubstr;

ObjectSet OneLitre() {
  auto model = std::make_shared<ObjectModel>();
  model->mass.volume_m3 = 1e-3;
  return {model};
}

ScenarioSpec Spec(int count, double height_m) {
  ScenarioSpec spec;
  spec.objects.resize(1);
  spec.objects[0].name = "block";
  spec.objects[0].count = count;
  spec.bin.inner_size_m = {0.5, 0.4, height_m};
  return spec;
}

TEST(FillText, SaysTheShareOfTheBinsVolume) {
  EXPECT_EQ(FillText(Spec(5, 0.1), OneLitre()),
            "A bin of 20 l gets 5 objects of 5 l in all: 25.0 % of its volume.");
  EXPECT_THAT(FillText(Spec(1, 0.1), OneLitre()), HasSubstr("1 object of 1 l"));
}

TEST(FillText, ATableHasNoVolume) {
  EXPECT_EQ(FillText(Spec(5, 0), OneLitre()),
            "A table without walls gets 5 objects of 5 l in all.");
}

TEST(FillText, AFillLevelReplacesTheCounts) {
  ScenarioSpec spec = Spec(5, 0.1);
  spec.fill = 0.5;
  EXPECT_EQ(FillText(spec, OneLitre()), "A bin of 20 l gets block, filled to 50 % of its height.");
}

}  // namespace
}  // namespace pickbed::tests
