#include <fmt/format.h>
#include <fmt/ranges.h>

#include <set>
#include <sstream>
#include <string>

#include "eval/cli/arguments.h"
#include "eval/cli/commands.h"
#include "eval/cli/run_progress.h"
#include "eval/runtime/process.h"
#include "eval/sweep/merge_shards.h"
#include "eval/sweep/slurm.h"
#include "eval/sweep/sweep_spec.h"

namespace pickbed::eval {
namespace {

struct SweepArguments {
  std::string file, out, shard, catalog = "objects";
  std::vector<std::string> settings;
  std::optional<int> trials;
  SweepOptions options;
  bool json = false, slurm = false;
  std::optional<int> shards, cpus;
  std::optional<std::string> partition, time, memory;
  std::vector<std::string> sbatch_options;
};

void AddSlurmArguments(CLI::App& app, SweepArguments& a) {
  auto* slurm = app.add_flag(
      "--slurm", a.slurm, "submit the shards to Slurm, show their progress and merge the results");
  app.add_option("--shards", a.shards, "number of shards, one per task of the job array [8]")
      ->check(CLI::Range(1, 10000))
      ->needs(slurm);
  app.add_option("--partition", a.partition, "partition of the cluster; default: the cluster's")
      ->needs(slurm);
  app.add_option("--time", a.time, "time limit of a shard, for example 2:00:00")->needs(slurm);
  app.add_option("--mem", a.memory, "memory of a shard, for example 4G")->needs(slurm);
  app.add_option("--cpus", a.cpus, "number of worker processes of a shard [1]")
      ->check(CLI::Range(1, 1024))
      ->needs(slurm);
  app.add_option(
         "--sbatch-option", a.sbatch_options,
         "further option of sbatch, for example --sbatch-option=--account=lab; may be repeated")
      ->allow_extra_args(false)
      ->needs(slurm);
}

bool ParseSweepArguments(int argc, char** argv, SweepArguments& a) {
  CLI::App app("Runs a scenario with every combination of a grid of settings.", "pickbed sweep");
  a.options.picture_trials = 0;
  app.add_option("SWEEP", a.file,
                 "sweep file with scenario, trials, set and grid, or the name of an included one: "
                 "occlusion, calibration")
      ->required();
  app.add_option("--set", a.settings,
                 "change a setting of all configurations: KEY=VALUE; may be repeated")
      ->allow_extra_args(false);
  app.add_option("--trials", a.trials,
                 "number of bins per configuration; replaces the value of the sweep file")
      ->check(CLI::Range(1, 1000000));
  app.add_option("--catalog", a.catalog, "folder with your own objects")->capture_default_str();
  AddOutArgument(app, a.out, "", "name of the sweep file");
  const CLI::Option* jobs = AddJobsArgument(app, a.options.jobs);
  const auto* shard = app.add_option(
      "--shard", a.shard, "run only shard I of N, written I/N; pickbed merge merges the shards");
  app.add_flag("--resume", a.options.resume, "continue an interrupted sweep");
  app.add_flag("--retry-crashed", a.options.retry_crashed,
               "with --resume: repeat the trials whose worker process crashed");
  app.add_option("--pictures", a.options.picture_trials,
                 "number of bins of each configuration with pictures of each attempt; 0 = none")
      ->check(CLI::Range(0, 1000000))
      ->capture_default_str();
  AddFailurePicturesArgument(app, a.options.failure_picture_trials);
  app.add_flag("--json", a.json, "print the summary as JSON on stdout, and nothing else");
  AddSlurmArguments(app, a);
  app.footer(
      "Example: pickbed sweep sensors.yaml --jobs 2\n"
      "         pickbed sweep sensors.yaml --slurm --shards 16 --partition short");
  const bool goes_on = ParseArguments(app, argc, argv);
  CheckInput(
      !a.slurm || jobs->count() == 0,
      "--jobs sets the workers on this machine; with --slurm, --cpus sets the workers of a shard");
  CheckInput(!a.slurm || shard->count() == 0,
             "--shard runs one shard on this machine and --slurm submits all of them; remove one "
             "of the two options");
  return goes_on;
}

// Returns the file itself, or the included sweep of that name.
std::filesystem::path SweepFile(const std::string& file_or_name) {
  const std::filesystem::path included = PresetsDir() / "sweeps" / (file_or_name + ".yaml");
  const bool is_name = !std::filesystem::exists(file_or_name) && std::filesystem::exists(included);
  return is_name ? included : std::filesystem::path(file_or_name);
}

// Returns the settings of the file, modified by the command line.
SweepSpec SpecOf(const SweepArguments& a) {
  SweepSpec spec = LoadSweepSpec(SweepFile(a.file));
  if (a.trials) spec.trials = a.trials;
  for (const std::string& setting : a.settings) SetForAll(setting, spec);
  SlurmOptions& slurm = spec.slurm;
  slurm.shards = a.shards.value_or(slurm.shards);
  slurm.cpus = a.cpus.value_or(slurm.cpus);
  slurm.partition = a.partition.value_or(slurm.partition);
  slurm.time = a.time.value_or(slurm.time);
  slurm.memory = a.memory.value_or(slurm.memory);
  for (const std::string& option : a.sbatch_options) {
    slurm.options += (slurm.options.empty() ? "" : " ") + option;
  }
  return spec;
}

void Print(const SweepArguments& a, const std::vector<ConfigurationSummary>& configurations,
           const std::filesystem::path& out) {
  if (a.json) {
    fmt::print("{}", SweepJson(configurations));
  } else {
    fmt::print("{}\nresults in {}\n", SweepTable(configurations), out.string());
  }
}

// Returns the lines of UnfitTools() for all configurations, each once.
std::string UnfitToolsOf(const Sweep& sweep) {
  std::set<std::string> lines;
  for (const Configuration& configuration : sweep.configurations) {
    std::istringstream text(UnfitTools(configuration.spec, configuration.objects));
    for (std::string line; std::getline(text, line);) lines.insert(line + "\n");
  }
  return fmt::format("{}", fmt::join(lines, ""));
}

SweepReport RunWithProgress(const Sweep& sweep, const SweepOptions& options,
                            const std::string& scenario) {
  ProgressLine progress;
  try {
    return RunSweep(sweep, options, ShowOn(progress, Interrupted));
  } catch (const InputError& error) {
    InputError hinted = error;
    for (const Configuration& configuration : sweep.configurations) {
      hinted = WithTrainingHint(hinted, scenario, configuration.spec);
    }
    throw hinted;
  }
}

SlurmReport FollowSlurm(const Sweep& sweep, const SlurmJob& job) {
  ProgressLine progress;
  std::string queue;
  SlurmListener listener;
  listener.on_message = [&](const std::string& line) { queue = line; };
  listener.on_state = [&](const RunState& state) {
    ProgressState shown = ProgressOf(state);
    shown.note = queue + (shown.note.empty() ? "" : ", " + shown.note);
    progress.Show(shown);
  };
  listener.stop = Interrupted;
  return RunOnSlurm(sweep, job, listener);
}

int SweepOnSlurm(const SweepArguments& a, const SweepSpec& spec, const std::filesystem::path& out) {
  SlurmJob job;
  job.options = spec.slurm;
  job.program = std::filesystem::read_symlink("/proc/self/exe");
  job.out = out;
  job.working_folder = std::filesystem::current_path();
  job.catalog = a.catalog;
  job.retry_crashed = a.options.retry_crashed;
  job.picture_trials = a.options.picture_trials;
  job.failure_picture_trials = a.options.failure_picture_trials;
  const Sweep sweep = MakeSweep(spec, out, a.catalog);
  const SlurmReport report = FollowSlurm(sweep, job);
  if (report.stopped) {
    fmt::print(
        stderr,
        "pickbed: job {0} continues; repeat the same command to follow it, scancel {0} ends it\n",
        report.job_id);
    return kExitInterrupted;
  }
  std::vector<std::filesystem::path> shards;
  for (const ShardState& shard : ShardStates(sweep, out, spec.slurm.shards)) {
    if (shard.done > 0) shards.push_back(ShardFolder(out, shard.shard));
  }
  CheckInput(!shards.empty(),
             fmt::format("job {} ended without a finished trial, see {}: {}", report.job_id,
                         (out / kSlurmFolder).string(), fmt::join(report.unfinished, "; ")));
  const MergeReport merged = MergeStores(shards, out);
  Print(a, merged.configurations, OutFolder(a.out, spec.name));
  CheckInput(report.unfinished.empty(),
             fmt::format("job {} left shards unfinished ({}); finished trials are kept, repeat the "
                         "same command to submit the rest",
                         report.job_id, fmt::join(report.unfinished, "; ")));
  return 0;
}

}  // namespace

int SweepCommand(int argc, char** argv) {
  SweepArguments a;
  if (!ParseSweepArguments(argc, argv, a)) return 0;
  CatchInterrupts();
  const SweepSpec spec = SpecOf(a);
  SweepOptions& options = a.options;
  options.out = std::filesystem::absolute(OutFolder(a.out, spec.name));
  TrialOptions trial_options;
  trial_options.log_dir = options.out / kLogsFolder;
  options.make = PickingTrials(trial_options);
  if (!a.shard.empty()) options.shard = ParseShard(a.shard);
  if (a.slurm) return SweepOnSlurm(a, spec, options.out);

  const Sweep sweep = MakeSweep(spec, options.out, a.catalog);
  fmt::print(stderr, "{}", UnfitToolsOf(sweep));
  const SweepReport report = RunWithProgress(sweep, options, spec.scenario);
  if (!report.configurations.empty()) {
    Print(a, report.configurations, OutFolder(a.out, spec.name));
  }
  if (report.interrupted) {
    fmt::print(stderr,
               "pickbed: stopped after {} of {} trials; repeat the same command with --resume to "
               "continue\n",
               report.finished, report.total);
    return kExitInterrupted;
  }
  RequireNoCrash(report.crashed);
  return 0;
}

int MergeCommand(int argc, char** argv) {
  CLI::App app("Merges the results of shards, or puts runs with different settings side by side.",
               "pickbed merge");
  std::vector<std::string> folders;
  std::string out;
  MergeOptions options;
  app.add_option("RUN", folders, "results folders: OUT/shards/*, or runs and sweeps")->required();
  app.add_option("--out", out, "folder for the merged results")->required();
  app.add_flag("--compare", options.compare,
               "accept different settings: the configurations of all runs are listed side by side");
  app.footer("Example: pickbed merge results/s/shards/* --out results/s");
  if (!ParseArguments(app, argc, argv)) return 0;
  const MergeReport report =
      MergeStores({folders.begin(), folders.end()}, std::filesystem::path(out), options);
  fmt::print("{}\n{} trials{}{} in {}\n", SweepTable(report.configurations), report.trials,
             report.missing > 0 ? fmt::format(", {} are missing", report.missing) : "",
             report.doubled > 0 ? fmt::format(", {} were in several stores", report.doubled) : "",
             out);
  return 0;
}

}  // namespace pickbed::eval
