#include "eval/sweep/merge_shards.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "eval/store/results_store.h"
#include "eval/store/sqlite.h"
#include "scenes/base/error.h"
#include "scenes/base/files.h"
#include "tests/eval/stub_sweep.h"
#include "tests/support/error_of.h"
#include "tests/support/temporary_folder.h"

namespace pickbed::tests {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

class MergeTest : public testing::Test {
 protected:
  // Makes a store with the given trials of a sweep.
  std::filesystem::path Store(const std::string& name, const Sweep& sweep,
                              const std::vector<int>& trials) const {
    SweepOptions options;
    options.out = folder_ / name;
    options.make = StubTrials();
    options.only_trials = trials;
    RunSweep(sweep, options, {});
    return options.out;
  }
  const TemporaryFolder temporary_;
  const std::filesystem::path folder_ = temporary_.path();
};

TEST_F(MergeTest, MergedTrialsAreBitIdentical) {
  const Sweep sweep = StubSweep(2, 4);
  const auto a = Store("a", sweep, {0, 5, 7}), b = Store("b", sweep, {1, 2});
  const MergeReport report = MergeStores({a, b}, folder_ / "out");
  EXPECT_EQ(report.trials, 5);
  EXPECT_EQ(report.missing, 3);
  EXPECT_EQ(report.doubled, 0);
  const ResultsStore joined = ResultsStore::OpenToRead(folder_ / "out");
  EXPECT_THAT(joined.FinishedTrials(), ElementsAre(0, 1, 2, 5, 7));
  for (const auto& source : {a, b}) {
    const ResultsStore store = ResultsStore::OpenToRead(source);
    for (const TrialResult& trial : store.ReadAll()) {
      ExpectSameTrial(joined.Read(trial.trial, trial.trial + 1).at(0), trial);
    }
  }
  EXPECT_EQ(joined.head().identity, ResultsStore::OpenToRead(a).head().identity);
}

TEST_F(MergeTest, EqualDuplicatesCountOnceUnequalOnesAreRefused) {
  const Sweep sweep = StubSweep(1, 4);
  const auto a = Store("a", sweep, {0, 1}), b = Store("b", sweep, {1, 2});
  const MergeReport report = MergeStores({a, b}, folder_ / "out");
  EXPECT_EQ(report.trials, 3);
  EXPECT_EQ(report.doubled, 1);
  {
    ResultsStore forged(folder_ / "forged", ResultsStore::OpenToRead(a).head());
    TrialResult other = ResultsStore::OpenToRead(b).Read(1, 2).at(0);
    other.attempts[0].hypotheses[0].score += 1e-12;
    forged.Write(other);
  }
  const std::string error = ErrorOf([&] {
    MergeStores({a, folder_ / "forged"}, folder_ / "other");
  });
  EXPECT_THAT(error, HasSubstr("trial 1 is in another store with different hypotheses"));
  EXPECT_FALSE(std::filesystem::exists(folder_ / "other/results.sqlite"));
  EXPECT_FALSE(std::filesystem::exists(folder_ / "other/merging")) << "an unfinished store is left";
}

TEST_F(MergeTest, RepeatedMergeChangesNothingAndNewTrialsAreAdded) {
  const Sweep sweep = StubSweep(2, 3);
  const auto a = Store("a", sweep, {0, 1, 2, 3}), b = Store("b", sweep, {4, 5});
  MergeStores({a}, folder_ / "out");
  MergeStores({a}, folder_ / "out");
  const MergeReport report = MergeStores({b}, folder_ / "out");
  EXPECT_EQ(report.trials, 6) << "trials of earlier merges are kept";
  MergeStores({a, b}, folder_ / "at_once");
  EXPECT_EQ(ReadFileBytes(folder_ / "out/attempts.csv"),
            ReadFileBytes(folder_ / "at_once/attempts.csv"));
}

TEST_F(MergeTest, DifferentSettingsRequireCompare) {
  Sweep one = StubSweep(1, 3);
  one.yaml.clear();  // a single run has no sweep text
  one.configurations[0].name.clear();
  Sweep other = one;
  other.configurations[0].spec.seed = 99;
  other.configurations[0].identity = "seed: 99\n";
  const auto a = Store("run_a", one, {0, 1, 2}), b = Store("run_b", other, {0, 2});
  const std::string error = ErrorOf([&] { MergeStores({a, b}, folder_ / "out"); });
  EXPECT_THAT(error, HasSubstr("'seed: 5' and 'seed: 99'"));
  EXPECT_THAT(error, HasSubstr("merge them as a comparison"));
  const MergeReport report = MergeStores({a, b}, folder_ / "out", {.compare = true});
  ASSERT_EQ(report.configurations.size(), 2u);
  EXPECT_EQ(report.configurations[0].configuration.name, "run_a");
  EXPECT_EQ(report.configurations[1].configuration.name, "run_b");
  const ResultsStore joined = ResultsStore::OpenToRead(folder_ / "out");
  EXPECT_THAT(joined.FinishedTrials(), ElementsAre(0, 1, 2, 3, 5));
  const TrialResult last = joined.Read(5, 6).at(0);
  EXPECT_EQ(last.configuration, 1);
  EXPECT_EQ(last.bin_index, 2) << "trials are paired by it";
  EXPECT_EQ(joined.head().configurations[1].first_trial, 3);
  EXPECT_EQ(joined.head().configurations[1].seed, 99u);
}

TEST_F(MergeTest, ComparedRunsWithEqualNamesAreDistinguished) {
  std::vector<std::filesystem::path> folders;
  for (const char* name : {"x/a/run", "x/b/run", "y/b/run", "other"}) {
    Sweep run = StubSweep(1, 1);
    run.yaml.clear();
    run.configurations[0].name.clear();
    run.configurations[0].identity = fmt::format("seed: {}\n", folders.size());
    folders.push_back(Store(name, run, {0}));
  }
  std::vector<std::string> names;
  for (const ConfigurationSummary& point :
       MergeStores(folders, folder_ / "out", {.compare = true}).configurations) {
    names.push_back(point.configuration.name);
  }
  EXPECT_THAT(names, ElementsAre("a/run", "x/b/run", "y/b/run", "other"));
}

TEST_F(MergeTest, MoreTrialsThanNumbersAreRefused) {
  const auto a = Store("a", StubSweep(1, 2), {0}), b = Store("b", StubSweep(1, 3), {0});
  Database(b / kStoreFile, Database::Mode::kExisting)
      .Execute("UPDATE configurations SET trials = 1000000000");
  const std::string error = ErrorOf([&] {
    MergeStores({a, b}, folder_ / "out", {.compare = true});
  });
  EXPECT_THAT(error, HasSubstr("b: the stores have more than 1000000000 trials together"));
}

TEST_F(MergeTest, DamagedInputIsNamedAndNotTheCopy) {
  const Sweep sweep = StubSweep(1, 4);
  const auto a = Store("a", sweep, {0, 1}), b = Store("b", sweep, {2});
  std::string bytes = ReadFileBytes(b / kStoreFile);
  for (size_t at = 8192; at < bytes.size(); at += 7) bytes[at] = '?';
  WriteFileAtomically(b / kStoreFile, bytes);
  const std::string error = ErrorOf([&] { MergeStores({a, b}, folder_ / "out"); });
  EXPECT_THAT(error, HasSubstr((b / kStoreFile).string()));
  EXPECT_EQ(error.find("/out/"), std::string::npos) << error;
  EXPECT_EQ(error.find('\n'), std::string::npos) << error;
}

// Faults that only the reading of all values finds.
TEST_F(MergeTest, DamagedValuesAreNamedWithTheirStoreAndLeaveNoCopy) {
  for (const char* const edit :
       {"UPDATE trials SET instances_cleared = 1000", "UPDATE attempts SET band = 77",
        "UPDATE hypotheses SET score = 1e999", "UPDATE attempts SET chosen_hypothesis = 9999"}) {
    const auto a = Store("a", StubSweep(1, 2), {0, 1});
    const auto damaged = folder_ / "damaged";
    std::filesystem::copy(a, damaged);
    Database(damaged / kStoreFile, Database::Mode::kExisting).Execute(edit);
    const std::string error = ErrorOf([&] { MergeStores({damaged}, folder_ / "out"); });
    EXPECT_THAT(error, HasSubstr((damaged / kStoreFile).string())) << edit;
    EXPECT_THAT(error, HasSubstr("restore the file from a copy")) << edit;
    EXPECT_FALSE(std::filesystem::exists(folder_ / "out" / kStoreFile)) << edit;
    EXPECT_NO_THROW(MergeStores({a}, folder_ / "out")) << edit;
    for (const char* const name : {"a", "damaged", "out"}) {
      std::filesystem::remove_all(folder_ / name);
    }
  }
}

TEST_F(MergeTest, ObjectsThatTheSettingsDoNotHaveAreRefused) {
  for (const char* const table : {"hypotheses", "instances", "instance_outcomes"}) {
    const auto a = Store(table, StubSweep(1, 2), {0, 1});
    Database(a / kStoreFile, Database::Mode::kExisting)
        .Execute(fmt::format("UPDATE {} SET object = 99 WHERE rowid = 1", table));
    EXPECT_THAT(
        ErrorOf([&] { MergeStores({a}, folder_ / "out"); }),
        HasSubstr(fmt::format("table '{}', trial 0: the settings have no object 99", table)));
    std::filesystem::remove_all(folder_ / "out");
  }
}

TEST_F(MergeTest, FolderWithOtherResultsIsLeftUnchanged) {
  const auto a = Store("a", StubSweep(1, 2), {0}), b = Store("b", StubSweep(2, 2), {0});
  const std::string before = ReadFileBytes(b / "attempts.csv");
  EXPECT_THAT(ErrorOf([&] { MergeStores({a}, b); }), HasSubstr("other settings"));
  EXPECT_EQ(ReadFileBytes(b / "attempts.csv"), before);
  EXPECT_THAT(ErrorOf([&] { MergeStores({folder_ / "nothing"}, folder_ / "out"); }),
              HasSubstr("results.sqlite"));
}

}  // namespace
}  // namespace pickbed::tests
