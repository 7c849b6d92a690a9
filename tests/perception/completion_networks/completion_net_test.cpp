#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "perception/completion/completion_file.h"
#include "perception/completion/shape_completer.h"
#include "perception/completion_networks/network_options.h"
#include "scenes/base/error.h"
#include "tests/perception/completion_networks/small_networks.h"

namespace pickbed::perception {
namespace {

using ::testing::HasSubstr;

TEST(CompletionNetTable, EachKindLearnsOneShapeByHeart) {
  const CompletionBatch batch = SphereBatch();
  for (const std::string& kind : CompletionKinds()) {
    // With some seeds the auto-encoder completes hidden cells as empty.
    CompletionNetwork network(SmallNetwork(kind), 2);
    const double first = network.TrainStep(batch, 5e-3);
    double last = first;
    for (int step = 0; step < 80; ++step) last = network.TrainStep(batch, 5e-3);
    EXPECT_LT(last, 0.5 * first) << kind;
    EXPECT_GT(MeanProbability(network, batch, true), MeanProbability(network, batch, false) + 0.3)
        << kind;
  }
}

// Two replicas have the mean loss of their views, and use the gradients and statistics of both.
TEST(CompletionNetwork, ReplicasShareAStep) {
  const auto solid = SphereSolid(0.05f);
  std::vector<CompletionSample> samples;
  for (int seed = 0; seed < 3; ++seed) {
    Rng rng(seed);
    const RandomView drawn = DrawView(*solid, {}, {}, rng);
    samples.push_back(MakeSample(*solid, drawn, 256, rng));
  }
  const TurnedSample a{&samples[0], 0}, b{&samples[1], 0}, c{&samples[2], 0};
  struct Result {
    double loss;
    std::vector<float> weights, statistics;
  };
  const auto step = [](std::vector<TurnedSample> views, int replicas) {
    CompletionNetwork network(SmallNetwork("implicit"), 1);
    const double loss = network.TrainStep(BatchOf(views), 5e-3, replicas);
    return Result{loss, network.Weights(), network.Statistics()};
  };
  const Result ab = step({a, b}, 2), ba = step({b, a}, 2), only_a = step({a}, 1),
               only_b = step({b}, 1);
  EXPECT_NEAR(ab.loss, (only_a.loss + only_b.loss) / 2, 1e-6);
  EXPECT_EQ(ab.weights, ba.weights);
  EXPECT_NE(ab.weights, only_a.weights);
  ASSERT_EQ(ab.statistics.size(), only_a.statistics.size());
  for (size_t i = 0; i < ab.statistics.size(); ++i) {
    EXPECT_NEAR(ab.statistics[i], (only_a.statistics[i] + only_b.statistics[i]) / 2, 1e-6);
  }
  // A replica with more views counts more.
  const Result abc = step({a, b, c}, 2), only_bc = step({b, c}, 1);
  EXPECT_NEAR(abc.loss, (only_a.loss + 2 * only_bc.loss) / 3, 1e-6);
  for (size_t i = 0; i < abc.statistics.size(); ++i) {
    EXPECT_NEAR(abc.statistics[i], (only_a.statistics[i] + 2 * only_bc.statistics[i]) / 3, 1e-6);
  }
  // There are not more replicas than views.
  EXPECT_EQ(step({a, b}, 5).weights, ab.weights);
}

TEST(CompletionNetTable, RefusesAnUnknownKindAndAModelOfAnotherKind) {
  EXPECT_THROW(CompletionNetwork(SmallNetwork("gan")), InputError);
  const auto file = std::filesystem::path(::testing::TempDir()) / "implicit.net";
  CompletionModelInfo info;
  info.network = SmallNetwork("implicit");
  SaveCompletionModel(file, info, CompletionNetwork(info.network, 1));
  CompletionOptions options;
  options.method = "vae";
  options.model = file.string();
  try {
    MakeCompleter(options);
    FAIL();
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("kind implicit, but method vae needs kind vae"));
  }
}

}  // namespace
}  // namespace pickbed::perception
