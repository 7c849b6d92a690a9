#include "scenes/scenario/object_pool.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <numeric>

#include "scenes/base/files.h"
#include "scenes/objects/object_catalog.h"
#include "scenes/scenario/load_objects.h"
#include "scenes/scenario/scenario_text.h"
#include "tests/support/error_of.h"
#include "tests/support/temporary_folder.h"

namespace pickbed::tests {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::StartsWith;

std::vector<std::string> NamesOf(const ScenarioSpec& spec) {
  std::vector<std::string> names;
  for (const ObjectSpec& object : spec.objects) names.push_back(object.name);
  return names;
}

class ObjectPool : public ::testing::Test {
 protected:
  ScenarioSpec Expanded(const std::string& yaml) const {
    ScenarioSpec spec = LoadScenario(folder_.Write("pool.yaml", yaml));
    ExpandObjects(spec);
    return spec;
  }
  std::string Error(const std::string& yaml) const {
    return ErrorOf([&] { Expanded(yaml); });
  }

  const TemporaryFolder folder_;
};

TEST_F(ObjectPool, ARangeOfSeedsGivesAShapeOfEachSeed) {
  const ScenarioSpec spec = Expanded(
      "objects:\n  - {name: rod, count: 2}\n  - {name: sampled/cup/outside/8-10, count: 3}\n");
  EXPECT_THAT(NamesOf(spec), ElementsAre("rod", "sampled/cup/outside/8", "sampled/cup/outside/9",
                                         "sampled/cup/outside/10"));
  EXPECT_EQ(spec.objects[0].count, 2);
  EXPECT_EQ(spec.objects[3].count, 3);
  EXPECT_THAT(spec.At("objects.3.name"), HasSubstr("pool.yaml:3")) << "the place of the entry";
}

TEST_F(ObjectPool, APatternGivesTheMeshesThatMatch) {
  for (const char* name : {"m/b1.obj", "m/a1.STL", "m/a1.mtl", "m/a2.png", "m/c.obj"}) {
    folder_.Write(name, "");
  }
  const ScenarioSpec spec =
      Expanded("objects: [{name: part, mesh: 'm/?1.*', unit: mm, density_kgpm3: 900}]\n");
  EXPECT_THAT(NamesOf(spec), ElementsAre("part/a1", "part/b1"));
  EXPECT_EQ(spec.objects[0].mesh, "m/a1.STL");
  EXPECT_EQ(spec.objects[1].unit, "mm");
  EXPECT_EQ(spec.objects[1].density_kgpm3, 900);
}

TEST_F(ObjectPool, MalformedEntriesAreRefusedWithTheirPlace) {
  folder_.Write("m/a.obj", "");
  folder_.Write("m/a.stl", "");
  const auto mesh = [](const std::string& pattern) {
    return "objects:\n  - {name: part, mesh: '" + pattern + "', mass_kg: 1}\n";
  };
  EXPECT_THAT(Error("objects:\n  - {name: sampled/cup/9-3}\n"),
              AllOf(HasSubstr("pool.yaml:2: objects.0.name"), HasSubstr("write FIRST-LAST")));
  EXPECT_THAT(Error("objects: [{name: sampled/cup/1-x}]\n"), HasSubstr("write FIRST-LAST"));
  EXPECT_THAT(Error("objects: [{name: sampled/cup/0-1000}]\n"), HasSubstr("more than 1000 seeds"));
  EXPECT_THAT(Error("objects: [{name: sampled/cup/0-3}, {name: sampled/cup/2}]\n"),
              HasSubstr("gives the object 'sampled/cup/2' twice"));
  EXPECT_THAT(Error(mesh("m/b*.obj")),
              AllOf(HasSubstr("pool.yaml:2: objects.0.mesh"), HasSubstr("check the pattern")));
  EXPECT_THAT(Error(mesh("none/*.obj")), HasSubstr("there is no folder"));
  EXPECT_THAT(Error(mesh("*/a.obj")), HasSubstr("not a folder"));
  EXPECT_THAT(Error(mesh("m/a.*")), HasSubstr("gives the object 'part/a' twice"));
}

TEST_F(ObjectPool, ContradictingSettingsAreRefusedWithTheirPlace) {
  const std::string rods = "objects: [{name: rod, count: 2}]\n";
  EXPECT_THAT(Error(rods + "draw: -1\n"), HasSubstr("pool.yaml:2: draw = -1"));
  EXPECT_THAT(Error(rods + "draw: 1\nfill: 0.5\n"), HasSubstr("pool.yaml:2: draw = 1: fill"));
  EXPECT_THAT(Error(rods + "draw: 1\nocclusion: {enabled: true}\n"), HasSubstr("draw = 1"));
  EXPECT_THAT(Error("objects: [{name: rod, density_kgpm3: 5}]\n"), HasSubstr("density_kgpm3 = 5"));
  EXPECT_THAT(Error("objects: [{name: a, mesh: a.obj, density_kgpm3: 5, mass_kg: 1}]\n"),
              HasSubstr("remove one of them"));
  ScenarioSpec few = Expanded(rods + "draw: 3\n");
  EXPECT_THAT(ErrorOf([&] { LoadObjects(few, ObjectCatalog({AssetsDir() / "objects"})); }),
              HasSubstr("pool.yaml:2: draw = 3: the objects have only 2 instances"));
}

TEST_F(ObjectPool, WordsNameASmallPoolAndCountALargeOne) {
  const std::string yaml = "objects: [{name: rod, count: 2}, {name: sampled/cup/0-9}]\ndraw: 3\n";
  EXPECT_EQ(ObjectsInWords(LoadScenario(folder_.Write("pool.yaml", yaml))),
            "3 of: 2 rod, 1 sampled/cup/0-9");
  EXPECT_EQ(ObjectsInWords(Expanded(yaml)), "3 of 11 objects");
}

// A pool may be larger than the bin; what a bin can draw may not.
TEST_F(ObjectPool, OnlyWhatABinDrawsMustFitIntoIt) {
  const ObjectCatalog catalog({AssetsDir() / "objects"});
  const std::string many =
      "objects: [{name: carton, count: 900}]\nbin: {inner_size_m: [.4, .3, .1]}\n";
  std::vector<std::pair<int, int>> progress;
  const auto on_object = [&](int done, int total) { progress.emplace_back(done, total); };
  const ScenarioSpec five = Expanded(many + "draw: 5\n");
  EXPECT_NO_THROW(LoadObjects(five, catalog, on_object));
  const int total = static_cast<int>(five.objects.size());
  ASSERT_EQ(progress.size(), five.objects.size());
  EXPECT_EQ(progress.front(), std::pair(1, total));
  EXPECT_EQ(progress.back(), std::pair(total, total));
  EXPECT_THAT(ErrorOf([&] { LoadObjects(Expanded(many + "draw: 800\n"), catalog); }),
              HasSubstr("draw = 800: the largest instances"));
}

TEST(CountsInBin, DrawsWithoutRepetitionAndLeavesDistractors) {
  std::vector<ObjectSpec> objects(4);
  objects[0].count = 1;
  objects[1].count = 3;
  objects[2].count = 6;
  objects[3].count = 2;
  objects[3].distractor = true;
  EXPECT_THAT(CountsInBin(objects, 0, 5, BinIndex(0)), ElementsAre(1, 3, 6, 2));
  EXPECT_THAT(CountsInBin(objects, 10, 5, BinIndex(0)), ElementsAre(1, 3, 6, 2)) << "all of them";
  std::vector<int> sums(4);
  constexpr int kBins = 4000;
  for (int bin = 0; bin < kBins; ++bin) {
    const std::vector<int> counts = CountsInBin(objects, 5, 5, BinIndex(bin));
    EXPECT_EQ(counts, CountsInBin(objects, 5, 5, BinIndex(bin)));
    EXPECT_EQ(counts[0] + counts[1] + counts[2], 5);
    EXPECT_EQ(counts[3], 2);
    for (int i = 0; i < 4; ++i) {
      EXPECT_LE(counts[i], objects[i].count);
      sums[i] += counts[i];
    }
  }
  // Each instance is drawn in half of the bins.
  for (int i = 0; i < 3; ++i) EXPECT_NEAR(sums[i] / (0.5 * kBins * objects[i].count), 1, 0.05);
}

}  // namespace
}  // namespace pickbed::tests
