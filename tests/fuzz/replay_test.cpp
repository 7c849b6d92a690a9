// Replays the inputs that failed once (tests/fuzz/failed/TARGET/*), the broken ones that were
// accepted once (tests/fuzz/refused/TARGET/*), and some mutations of each target.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "scenes/base/error.h"
#include "scenes/base/files.h"
#include "tests/fuzz/campaign.h"
#include "tests/fuzz/mutator.h"
#include "tests/support/temporary_folder.h"

namespace pickbed::tests {
namespace {

bool IsFine(const FuzzCase& result) {
  return result.result == FuzzResult::kAccepted || result.result == FuzzResult::kRefused;
}

class FuzzTargetTest : public testing::TestWithParam<const FuzzTarget*> {};

TEST_P(FuzzTargetTest, AcceptsItsSeeds) {
  const TemporaryFolder temporary;
  for (const std::string& seed : GetParam()->seeds()) {
    if (!GetParam()->accepts_seeds) break;
    const FuzzCase result = RunFuzzCase(*GetParam(), temporary.path(), seed);
    EXPECT_EQ(result.result, FuzzResult::kAccepted) << result.message;
  }
}

// Runs the inputs of tests/fuzz/FOLDER/TARGET.
void Replay(const FuzzTarget& target, const char* folder,
            const std::function<void(const std::string&, const FuzzCase&)>& check) {
  const TemporaryFolder temporary;
  const std::filesystem::path inputs =
      std::filesystem::path(PICKBED_SOURCE_DIR) / "tests" / "fuzz" / folder / target.name;
  std::error_code none;
  for (const auto& file : std::filesystem::directory_iterator(inputs, none)) {
    check(file.path().string(), RunFuzzCase(target, temporary.path(), ReadFileBytes(file.path())));
  }
}

TEST_P(FuzzTargetTest, RefusesInputsThatFailedOnce) {
  Replay(*GetParam(), "failed", [](const std::string& file, const FuzzCase& result) {
    EXPECT_TRUE(IsFine(result)) << file << ": " << FuzzResultName(result.result) << ": "
                                << result.message;
  });
}

TEST_P(FuzzTargetTest, RefusesBrokenInputsThatWereAcceptedOnce) {
  Replay(*GetParam(), "refused", [](const std::string& file, const FuzzCase& result) {
    EXPECT_EQ(result.result, FuzzResult::kRefused) << file << ": " << result.message;
  });
}

TEST_P(FuzzTargetTest, SurvivesMutations) {
  RunCampaign(*GetParam(), GetParam()->replays, 1,
              [&](int number, const FuzzCase& result, const std::string& bytes) {
                EXPECT_TRUE(IsFine(result))
                    << "case " << number << " of " << bytes.size()
                    << " bytes: " << FuzzResultName(result.result) << ": " << result.message;
              });
}

std::vector<const FuzzTarget*> All() {
  std::vector<const FuzzTarget*> targets;
  for (const FuzzTarget& target : FuzzTargets()) targets.push_back(&target);
  return targets;
}

INSTANTIATE_TEST_SUITE_P(All, FuzzTargetTest, testing::ValuesIn(All()),
                         [](const testing::TestParamInfo<const FuzzTarget*>& info) {
                           return info.param->name;
                         });

// The campaign must notice each kind of failure.
TEST(Campaign, NoticesCrashesHangsAndErrors) {
  const TemporaryFolder temporary;
  const auto result_of = [&](auto run) {
    const FuzzTarget target{"planted", [run](const auto&, const auto&) { run(); }, {}};
    return RunFuzzCase(target, temporary.path(), "").result;
  };
  EXPECT_EQ(result_of([] {}), FuzzResult::kAccepted);
  EXPECT_EQ(result_of([] { std::abort(); }), FuzzResult::kCrash);
  EXPECT_EQ(result_of([] { throw std::out_of_range("map::at"); }), FuzzResult::kOtherError);
  EXPECT_EQ(result_of([] { throw InputError("no file here"); }), FuzzResult::kNameless);
  const std::string file = (temporary.path() / "a.yaml").string();
  EXPECT_EQ(result_of([&] { throw InputError(file + ": bad"); }), FuzzResult::kRefused);
  EXPECT_EQ(result_of([&] { throw InputError(file + ":\nbad"); }), FuzzResult::kSeveralLines);
}

TEST(Mutated, SameSeedGivesSameBytesAndMostDiffer) {
  const std::vector<std::string> seeds{"a: 1\nb: 2.5\n", "c: [1, 2, 3]\n"};
  int changed = 0;
  for (uint64_t i = 0; i < 200; ++i) {
    Rng a = Rng::Derive(7, i, "x"), b = Rng::Derive(7, i, "x");
    const std::string bytes = Mutated(seeds, a);
    EXPECT_EQ(bytes, Mutated(seeds, b));
    changed += bytes != seeds[0] && bytes != seeds[1];
  }
  EXPECT_GT(changed, 150);
}

}  // namespace
}  // namespace pickbed::tests
