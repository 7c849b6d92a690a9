#include "eval/sweep/slurm.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "eval/trial/counts_by_bin.h"
#include "scenes/base/files.h"
#include "tests/eval/stub_sweep.h"
#include "tests/support/error_of.h"
#include "tests/support/temporary_folder.h"

// Checks that need no cluster. tests/e2e/slurm.sh starts one.

namespace pickbed::tests {
namespace {

using testing::HasSubstr;
using testing::Not;

SlurmJob SomeJob() {
  SlurmJob job;
  job.program = "/opt/my tools/pickbed";
  job.out = "/shared/it's here";
  job.working_folder = "/home/me";
  job.catalog = "objects";
  return job;
}

TEST(SlurmScript, ContainsOnlyTheOptionsThatAreSet) {
  SlurmJob job = SomeJob();
  job.options.shards = 16;
  job.options.partition = "short";
  job.options.time = "2:00:00";
  job.options.cpus = 4;
  job.options.options = "--account=lab  --qos=low";
  const std::string script = JobScript(job);
  EXPECT_THAT(script, HasSubstr("#SBATCH --partition=short\n"));
  EXPECT_THAT(script, HasSubstr("#SBATCH --time=2:00:00\n"));
  EXPECT_THAT(script, HasSubstr("#SBATCH --cpus-per-task=4\n"));
  EXPECT_THAT(script, HasSubstr("#SBATCH --account=lab\n#SBATCH --qos=low\n"));
  EXPECT_THAT(script, Not(HasSubstr("--mem")));
  EXPECT_THAT(script, HasSubstr("--shard \"$SLURM_ARRAY_TASK_ID/16\" --jobs 4 --resume\n"));
}

TEST(SlurmScript, PassesThePictureOptionsToShards) {
  SlurmJob job = SomeJob();
  job.picture_trials = 7;
  job.failure_picture_trials = 30;
  EXPECT_THAT(JobScript(job), HasSubstr(" --pictures 7 --failure-pictures 30 "));
}

TEST(SlurmScript, QuotesPathsForTheShell) {
  const std::string script = JobScript(SomeJob());
  EXPECT_THAT(script,
              HasSubstr("exec '/opt/my tools/pickbed' sweep "
                        "'/shared/it'\\''s here/sweep.yaml' --out '/shared/it'\\''s here'"));
}

// A line of the script that does not begin with # would be run by the shell.
TEST(SlurmScript, TimesAndSizesMustBeOnes) {
  for (const char* good : {"", "30", "2:00:00", "90:30", "1-12", "3-00:30:00", "UNLIMITED"}) {
    SlurmJob job = SomeJob();
    job.options.time = good;
    EXPECT_NO_THROW(JobScript(job)) << good;
  }
  for (const char* bad : {"2:9223372036854775808:00", "-5", "2h", "1:2:3:4", "1-", ":30"}) {
    SlurmJob job = SomeJob();
    job.options.time = bad;
    EXPECT_THAT(ErrorOf([&] { JobScript(job); }), HasSubstr("slurm.time = ")) << bad;
  }
  SlurmJob job = SomeJob();
  job.options.memory = "4.5Q";
  EXPECT_THAT(ErrorOf([&] { JobScript(job); }), HasSubstr("slurm.mem = 4.5Q"));
  for (const char* good : {"4000", "4G", "512mb"}) {
    job.options.memory = good;
    EXPECT_NO_THROW(JobScript(job)) << good;
  }
}

TEST(SlurmScript, TextsThatBeginAnotherLineAreRefused) {
  for (const char* bad : {"short\ntouch /tmp/x", "a b", "$(id)", "`id`", "a'b", "a;b", "a\rb"}) {
    SlurmJob job = SomeJob();
    job.options.partition = bad;
    EXPECT_THAT(ErrorOf([&] { JobScript(job); }), HasSubstr("slurm.partition has a character"));
    job = SomeJob();
    job.options.time = bad;
    EXPECT_THAT(ErrorOf([&] { JobScript(job); }), HasSubstr("slurm.time"));
    job = SomeJob();
    job.options.memory = bad;
    EXPECT_THAT(ErrorOf([&] { JobScript(job); }), HasSubstr("slurm.mem"));
  }
  SlurmJob job = SomeJob();
  job.options.options = "--qos=low\ntouch";
  EXPECT_THAT(ErrorOf([&] { JobScript(job); }), HasSubstr("slurm.options"));
  job = SomeJob();
  job.out = "/shared/a\nrm -rf x";
  EXPECT_THAT(ErrorOf([&] { JobScript(job); }), HasSubstr("line break"));
}

TEST(Slurm, CountsTrialsOfShards) {
  const TemporaryFolder temporary;
  const Sweep sweep = StubSweep(2, 6);
  SweepOptions options;
  options.out = temporary.path();
  options.make = StubTrials();
  options.shard = {2, 3};
  RunSweep(sweep, options, {});
  const auto states = ShardStates(sweep, options.out, 3);
  ASSERT_EQ(states.size(), 3u);
  for (const ShardState& state : states) EXPECT_EQ(state.total, 4);
  EXPECT_EQ(states[0].done, 0);
  EXPECT_TRUE(states[1].finished());
  const ResultsStore store = ResultsStore::OpenToRead(ShardFolder(options.out, options.shard));
  Cluster stored;
  for (const TrialResult& trial : store.ReadAll()) SuccessOfAttempts()(trial, stored);
  EXPECT_GT(stored.samples, 0);
  EXPECT_EQ(SumOf(states[1].outcomes).samples, stored.samples);
  EXPECT_EQ(SumOf(states[1].outcomes).hits, stored.hits);
  EXPECT_THAT(ErrorOf([&] { ShardStates(StubSweep(2, 7), options.out, 3); }),
              HasSubstr("results of other settings"));
}

TEST(Slurm, MissingSlurmIsReported) {
  const TemporaryFolder temporary;
  const char* path = std::getenv("PATH");
  const std::string before = path == nullptr ? "" : path;
  setenv("PATH", temporary.path().c_str(), 1);
  SlurmJob job = SomeJob();
  job.out = temporary.path();
  const std::string error = ErrorOf([&] { RunOnSlurm(StubSweep(1, 1), job, {}); });
  setenv("PATH", before.c_str(), 1);
  EXPECT_THAT(error, HasSubstr("there is no sbatch"));
}

// Programs of Slurm whose jobs end at once, as on nodes that are lost. `sbatch` notes its
// arguments.
class LostNodes {
 public:
  explicit LostNodes(const std::filesystem::path& folder) : folder_(folder) {
    Write("sbatch", fmt::format("echo \"$2\" >>'{}'; echo 17", (folder / "calls").string()));
    Write("squeue", "exit 0");
    Write("scontrol", "echo JobId=17 JobState=NODE_FAIL Reason=None");
    const char* path = std::getenv("PATH");
    before_ = path == nullptr ? "" : path;
    setenv("PATH", (folder.string() + ":" + before_).c_str(), 1);
  }
  ~LostNodes() { setenv("PATH", before_.c_str(), 1); }
  std::string Calls() const { return ReadFileBytes(folder_ / "calls"); }

 private:
  void Write(const std::string& name, const std::string& command) const {
    WriteFileAtomically(folder_ / name, "#!/bin/sh\n" + command + "\n");
    std::filesystem::permissions(folder_ / name, std::filesystem::perms::owner_all);
  }
  std::filesystem::path folder_;
  std::string before_;
};

TEST(Slurm, ShardsOfLostNodesAreNamedAndSubmittedAgain) {
  const TemporaryFolder programs, results;
  const LostNodes slurm(programs.path());
  const Sweep sweep = StubSweep(2, 4);
  SlurmJob job = SomeJob();
  job.out = results.path();
  job.options.shards = 2;
  EXPECT_EQ(RunOnSlurm(sweep, job, {}).unfinished,
            (std::vector<std::string>{"shard 1 of 2: NODE_FAIL, 0 of 4 trials done",
                                      "shard 2 of 2: NODE_FAIL, 0 of 4 trials done"}));
  SweepOptions options;
  options.out = results.path();
  options.make = StubTrials();
  options.shard = {1, 2};
  RunSweep(sweep, options, {});
  EXPECT_EQ(RunOnSlurm(sweep, job, {}).unfinished,
            (std::vector<std::string>{"shard 2 of 2: NODE_FAIL, 0 of 4 trials done"}));
  EXPECT_EQ(slurm.Calls(), "--array=1,2\n--array=2\n");
  options.shard = {2, 2};
  RunSweep(sweep, options, {});
  EXPECT_TRUE(RunOnSlurm(sweep, job, {}).unfinished.empty());
  EXPECT_EQ(slurm.Calls(), "--array=1,2\n--array=2\n") << "a finished sweep was submitted";
}

}  // namespace
}  // namespace pickbed::tests
