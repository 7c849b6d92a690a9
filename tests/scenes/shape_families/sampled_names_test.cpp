#include "scenes/shape_families/sampled_names.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "scenes/objects/object_catalog.h"
#include "scenes/objects/sampled_object.h"
#include "tests/support/error_of.h"

namespace pickbed::tests {
namespace {

using testing::HasSubstr;

TEST(SampledNames, GiveFamilySplitAndSeed) {
  const SampledShape cup = SampleShapeByName("sampled/cup/12");
  EXPECT_STREQ(cup.family->name, "cup");
  EXPECT_EQ(cup.split, ShapeSplit::kSeen);
  EXPECT_EQ(cup.seed, 12u);
  EXPECT_EQ(SampleShapeByName("sampled/cup/outside/12").split, ShapeSplit::kOutside);
}

TEST(SampledNames, ADomainDrawsFromItsFamilies) {
  std::set<std::string> training, held_out;
  for (int seed = 0; seed < 60; ++seed) {
    const SampledShape seen = SampleShapeOf("machine", "seen", seed);
    EXPECT_FALSE(seen.family->held_out);
    EXPECT_EQ(seen.family->domain, ShapeDomain::kMachine);
    training.insert(seen.family->name);
    const SampledShape unseen = SampleShapeOf("supermarket", "unseen_families", seed);
    EXPECT_TRUE(unseen.family->held_out);
    EXPECT_EQ(unseen.family->domain, ShapeDomain::kSupermarket);
    held_out.insert(unseen.family->name);
  }
  EXPECT_GT(training.size(), 10u);
  EXPECT_EQ(held_out.size(), 3u);
}

TEST(SampledNames, MalformedNamesAreRefused) {
  const auto error = [](const char* name) { return ErrorOf([&] { SampleShapeByName(name); }); };
  EXPECT_THAT(error("sampled/cup"), HasSubstr("is written sampled/FAMILY/SEED"));
  EXPECT_THAT(error("sampled/cup/seen/1/2"), HasSubstr("is written sampled/FAMILY/SEED"));
  EXPECT_THAT(error("sampled/cup/-1"), HasSubstr("the seed '-1' is not a whole number"));
  EXPECT_THAT(error("sampled/cup/"), HasSubstr("the seed '' is not a whole number"));
  EXPECT_THAT(error("sampled/cop/1"), HasSubstr("did you mean 'cup'"));
  EXPECT_THAT(error("sampled/cup/sen/1"), HasSubstr("did you mean 'seen'"));
  EXPECT_THAT(error("sampled/cup/unseen_families/1"), HasSubstr("needs a domain"));
}

TEST(SampledNames, ARangeOfSeedsGivesAllNames) {
  EXPECT_THAT(SampledNamesIn("sampled/machine/unseen_families/9-11"),
              testing::ElementsAre("sampled/machine/unseen_families/9",
                                   "sampled/machine/unseen_families/10",
                                   "sampled/machine/unseen_families/11"));
  EXPECT_THAT(
      SampledNamesIn("sampled/cup/18446744073709551614-18446744073709551615"),
      testing::ElementsAre("sampled/cup/18446744073709551614", "sampled/cup/18446744073709551615"));
  EXPECT_THAT(SampledNamesIn("sampled/cup/3"), testing::ElementsAre("sampled/cup/3"));
  EXPECT_THAT(SampledNamesIn("my-part-0-9"), testing::ElementsAre("my-part-0-9"));
}

TEST(SampledNames, TheCatalogLoadsThem) {
  const auto ring = ObjectCatalog({}).Load("sampled/ring/2");
  EXPECT_EQ(ring->name, "sampled/ring/2");
  const SampledShape shape = SampleShapeByName("sampled/ring/2");
  EXPECT_NEAR(MeshBounds(ring->mesh_O).size().z(), shape.solid.box_O().sizes().z(), 3e-4);
  EXPECT_NEAR(ring->mass.mass_kg / ring->mass.volume_m3, shape.family->density_kgpm3, 1e-6);
  EXPECT_EQ(ring->mesh_hash, ObjectCatalog({}).Load("sampled/ring/2")->mesh_hash);
  EXPECT_EQ(ring->mesh_hash, SampledObject("other name", shape).mesh_hash);
}

}  // namespace
}  // namespace pickbed::tests
