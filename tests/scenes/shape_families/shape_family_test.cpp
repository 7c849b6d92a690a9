#include "scenes/shape_families/shape_family.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <set>

#include "scenes/base/random.h"
#include "tests/support/error_of.h"

namespace pickbed::tests {
namespace {

using Eigen::Vector3f;
using testing::HasSubstr;

constexpr ShapeSplit kAllSplits[] = {ShapeSplit::kSeen, ShapeSplit::kUnseenSizes,
                                     ShapeSplit::kOutside};
constexpr int kSeeds = 12;

std::string NameOf(const SampledShape& shape) {
  return std::string(shape.family->name) + " " + ShapeSplitName(shape.split) + " " +
         std::to_string(shape.seed);
}

// Calls `check` with samples of all families and splits.
void ForEachSample(int seeds, const std::function<void(const SampledShape&)>& check) {
  for (const ShapeFamilyRow& row : ShapeFamilyTable()) {
    for (const ShapeSplit split : kAllSplits) {
      for (int seed = 0; seed < seeds; ++seed) {
        const SampledShape shape = SampleShape(row, split, seed);
        SCOPED_TRACE(NameOf(shape));
        check(shape);
      }
    }
  }
}

Vector3f RandomPoint(const Eigen::AlignedBox3f& box, float factor, Rng& rng) {
  Vector3f p;
  for (int k = 0; k < 3; ++k) {
    p[k] = static_cast<float>(rng.Uniform(-0.5, 0.5)) * factor * box.sizes()[k];
  }
  return p;
}

TEST(ShapeFamily, TwoDomainsHaveTrainingAndHeldOutFamilies) {
  EXPECT_GE(ShapeFamilyTable().size(), 30u);
  std::set<std::string> names, held_out;
  for (const ShapeFamilyRow& row : ShapeFamilyTable()) {
    EXPECT_TRUE(names.insert(row.name).second) << row.name << " twice";
    if (row.held_out) held_out.insert(row.name);
  }
  EXPECT_EQ(held_out, (std::set<std::string>{"toothpaste_tube", "tetra_pack", "mug", "pipe_tee",
                                             "rod_with_eyes", "u_clip", "gear"}));
  for (const ShapeDomain domain : {ShapeDomain::kMachine, ShapeDomain::kSupermarket}) {
    EXPECT_GE(ShapeFamiliesOf(domain, false).size(), 12u);
    EXPECT_GE(ShapeFamiliesOf(domain, true).size(), 3u);
  }
}

TEST(ShapeFamily, SizesAreWithinTheLimits) {
  ForEachSample(kSeeds, [](const SampledShape& shape) {
    const float size_mm = 1e3f * shape.solid.box_O().sizes().maxCoeff();
    const bool outside = shape.split == ShapeSplit::kOutside;
    EXPECT_GE(size_mm, outside ? 12 : 19) << NameOf(shape);
    EXPECT_LE(size_mm, outside ? 270 : 221) << NameOf(shape);
    EXPECT_GE(shape.solid.min_wall_m(), 0.8e-3f) << NameOf(shape);
  });
}

// An 80 mm jaw opens less than that; thin parts and rims count by their walls.
TEST(ShapeFamily, MostShapesFitBetweenTheJaws) {
  int all = 0, held = 0;
  ForEachSample(kSeeds, [&](const SampledShape& shape) {
    ++all;
    held += shape.solid.box_O().sizes().minCoeff() < 0.075f || shape.family->hollow;
  });
  EXPECT_GT(held, 0.95 * all);
}

// Parameters as shares of their range.
TEST(ShapeFamily, SplitsAreDisjoint) {
  const auto is_held_out = [](double share) {
    const double in_period = std::fmod(share, 0.3);  // intervals begin at 0.15, 0.45 and 0.75
    return in_period > 0.15 && in_period < 0.25 && share > 0.1 && share < 0.9;
  };
  ForEachSample(kSeeds, [&](const SampledShape& shape) {
    int outside = 0;
    for (size_t i = 0; i < shape.values.size(); ++i) {
      const ShapeParameter& p = shape.family->parameters[i];
      const double share = (shape.values[i] - p.low) / (p.high - p.low);
      if (share < 0 || share > 1) {
        ++outside;
      } else if (p.whole && p.high - p.low >= 2) {
        const bool held_out = static_cast<int>(shape.values[i] - p.low) % 3 == 1;
        EXPECT_EQ(held_out, shape.split == ShapeSplit::kUnseenSizes) << NameOf(shape) << p.name;
      } else if (!p.whole) {
        EXPECT_EQ(is_held_out(share), shape.split == ShapeSplit::kUnseenSizes)
            << NameOf(shape) << " " << p.name << " share " << share;
      }
    }
    EXPECT_EQ(outside > 0, shape.split == ShapeSplit::kOutside) << NameOf(shape);
  });
}

TEST(ShapeFamily, SameSeedGivesTheSameShape) {
  for (const ShapeFamilyRow& row : ShapeFamilyTable()) {
    const SampledShape a = SampleShape(row, ShapeSplit::kSeen, 5);
    EXPECT_EQ(a.solid.hash(), SampleShape(row, ShapeSplit::kSeen, 5).solid.hash()) << row.name;
    EXPECT_NE(a.solid.hash(), SampleShape(row, ShapeSplit::kSeen, 6).solid.hash()) << row.name;
  }
}

// Sphere tracing and the box search rely on the bound.
TEST(ShapeFamily, DistancesAreBounds) {
  Rng rng(1);
  ForEachSample(4, [&](const SampledShape& shape) {
    std::vector<Vector3f> points;
    std::vector<float> steps;
    for (int i = 0; i < 400; ++i) {
      steps.push_back(static_cast<float>(rng.Uniform(5e-4, 2e-2)));
      points.push_back(RandomPoint(shape.solid.box_O(), 1.3f, rng));
      points.push_back(points.back() + steps.back() * rng.UnitVector().cast<float>());
    }
    std::vector<float> distances(points.size());
    shape.solid.SignedDistances_m(points, distances);
    for (size_t i = 0; i < steps.size(); ++i) {
      EXPECT_LE(std::abs(distances[2 * i] - distances[2 * i + 1]), 1.002f * steps[i] + 1e-6f)
          << NameOf(shape);
    }
  });
}

TEST(ShapeFamily, NothingIsOutsideTheBox) {
  Rng rng(2);
  ForEachSample(kSeeds, [&](const SampledShape& shape) {
    const Eigen::AlignedBox3f& box = shape.solid.box_O();
    for (int i = 0; i < 200; ++i) {
      const Vector3f p = RandomPoint(box, 1.2f, rng);
      if (box.exteriorDistance(p) > 2e-4f) {
        EXPECT_FALSE(shape.solid.Contains(p)) << NameOf(shape) << " at " << p.transpose();
      }
    }
  });
}

TEST(ShapeFamily, HollowShapesAreHollow) {
  // The center of the box is in the bore or the cavity.
  const std::set<std::string> around_center = {"tube", "pipe",     "pipe_tee", "flange", "ring",
                                               "nut",  "spacer",   "gear",     "pulley", "o_ring",
                                               "cup",  "open_jar", "tray",     "channel"};
  int checked = 0;
  ForEachSample(kSeeds, [&](const SampledShape& shape) {
    if (!around_center.contains(shape.family->name)) return;
    EXPECT_FALSE(shape.solid.Contains(Vector3f::Zero())) << NameOf(shape);
    EXPECT_TRUE(shape.family->hollow);
    ++checked;
  });
  EXPECT_EQ(checked, 14 * 3 * kSeeds);
}

// The axis of a pipe is free beyond both of its ends.
TEST(ShapeFamily, PipesHaveOpenEnds) {
  for (const char* name : {"tube", "pipe"}) {
    const SampledShape shape = SampleShape(FindShapeFamily(name), ShapeSplit::kSeen, 1);
    const float end = 0.6f * shape.solid.box_O().sizes().z();
    for (float z = -end; z <= end; z += 1e-3f) {
      EXPECT_FALSE(shape.solid.Contains({0, 0, z})) << name << " at " << z;
    }
  }
}

TEST(ShapeFamily, CupsAreClosedBelow) {
  const SampledShape cup = SampleShape(FindShapeFamily("cup"), ShapeSplit::kSeen, 1);
  const float half = 0.5f * cup.solid.box_O().sizes().z();
  EXPECT_TRUE(cup.solid.Contains({0, 0, 1e-3f - half}));
  EXPECT_FALSE(cup.solid.Contains({0, 0, half - 1e-3f}));
}

TEST(ShapeFamily, UnknownNamesGiveTheNearest) {
  EXPECT_THAT(ErrorOf([] { FindShapeFamily("cupp"); }),
              HasSubstr("unknown shape family 'cupp'; did you mean 'cup'"));
  EXPECT_THAT(ErrorOf([] { ShapeSplitFromName("unseen"); }), HasSubstr("unknown split 'unseen'"));
  EXPECT_THAT(ErrorOf([] { ShapeDomainFromName("machines"); }),
              HasSubstr("did you mean 'machine'"));
}

}  // namespace
}  // namespace pickbed::tests
