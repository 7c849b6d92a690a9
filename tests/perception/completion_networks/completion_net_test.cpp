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
