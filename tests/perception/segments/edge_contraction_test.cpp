#include "perception/segments/edge_contraction.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <stdexcept>

#include "scenes/base/random.h"
#include "tests/support/layer.h"

namespace pickbed::tests {
namespace {

using ::testing::ElementsAre;

TEST(ContractEdges, PositiveEdgesJoinAndNegativeOnesDoNot) {
  EXPECT_THAT(ContractEdges(5, {{0, 1, 1}, {1, 2, 2}, {3, 4, -1}}), ElementsAre(0, 0, 0, 1, 2));
  EXPECT_THAT(ContractEdges(2, {}), ElementsAre(0, 1));
}

TEST(ContractEdges, AWeakBridgeDoesNotJoinTwoGroups) {
  // Two strong groups {0, 1} and {2, 3}. One border joins them weakly, another separates them.
  EXPECT_THAT(ContractEdges(4, {{0, 1, 5}, {2, 3, 5}, {0, 2, 1}, {1, 3, -2}}),
              ElementsAre(0, 0, 1, 1));
  EXPECT_THAT(ContractEdges(4, {{0, 1, 5}, {2, 3, 5}, {0, 2, 1}, {1, 3, -0.5}}),
              ElementsAre(0, 0, 0, 0));
}

TEST(ContractEdges, ParallelEdgesAreAdded) {
  EXPECT_THAT(ContractEdges(2, {{0, 1, 2}, {1, 0, -3}}), ElementsAre(0, 1));
  EXPECT_THAT(ContractEdges(2, {{0, 1, 3}, {1, 0, -2}}), ElementsAre(0, 0));
}

TEST(ContractEdges, TheOrderOfTheEdgesHasNoEffect) {
  Rng rng(3);
  std::vector<WeightedEdge> edges;
  for (int i = 0; i < 200; ++i) {
    const int a = rng.Index(40), b = rng.Index(40);
    if (a != b) edges.push_back({a, b, std::round(rng.Uniform(-8, 8))});
  }
  const std::vector<int> groups = ContractEdges(40, edges);
  std::reverse(edges.begin(), edges.end());
  EXPECT_EQ(ContractEdges(40, edges), groups);
}

TEST(ContractEdges, NoTwoGroupsAttractEachOther) {
  Rng rng(4);
  std::vector<WeightedEdge> edges;
  for (int i = 0; i < 300; ++i) {
    const int a = rng.Index(60), b = rng.Index(60);
    if (a != b) edges.push_back({a, b, rng.Uniform(-1, 1)});
  }
  const std::vector<int> groups = ContractEdges(60, edges);
  const int count = *std::max_element(groups.begin(), groups.end()) + 1;
  ASSERT_GT(count, 1);
  std::vector<double> between(static_cast<size_t>(count) * count, 0);
  for (const WeightedEdge& edge : edges) {
    const auto [low, high] = std::minmax(groups[edge.a], groups[edge.b]);
    if (low != high) between[static_cast<size_t>(low) * count + high] += edge.weight;
  }
  EXPECT_LE(*std::max_element(between.begin(), between.end()), 1e-9);
}

TEST(ContractEdges, RefusesEdgesThatAreNone) {
  EXPECT_THROW(ContractEdges(2, {{0, 2, 1}}), std::logic_error);
  EXPECT_THROW(ContractEdges(2, {{1, 1, 1}}), std::logic_error);
}

}  // namespace
}  // namespace pickbed::tests
