#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "perception/completion/completion_network.h"
#include "tests/perception/completion_networks/small_networks.h"

namespace pickbed::perception {
namespace {

// The code of a view does not depend on the views that are encoded with it.
TEST(ImplicitNet, AViewHasTheSameProbabilitiesAloneAndInABatch) {
  const CompletionNetwork network(SmallNetwork("implicit"), 4);
  const CompletionBatch all = SphereBatch();
  const std::vector<float> together = network.Probabilities(all);
  CompletionBatch last;
  last.count = 1;
  last.points = all.points;
  last.channels.assign(all.channels.end() - kInputChannels * kInputVolume, all.channels.end());
  last.images.assign(all.images.end() - kImageChannels * kImageArea, all.images.end());
  last.queries.assign(all.queries.end() - all.points * kQueryValues, all.queries.end());
  last.inside.assign(all.inside.end() - all.points, all.inside.end());
  const std::vector<float> alone = network.Probabilities(last);
  for (int i = 0; i < all.points; ++i) {
    ASSERT_NEAR(alone[i], together[together.size() - all.points + i], 1e-5);
  }
}

}  // namespace
}  // namespace pickbed::perception
