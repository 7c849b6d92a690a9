#include "eval/sweep/merge_shards.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

#include "eval/runtime/results_folder.h"
#include "eval/store/merge_rows.h"
#include "eval/store/results_store.h"
#include "eval/store/store_check.h"
#include "scenes/base/error.h"
#include "scenes/scenario/scenario_text.h"

namespace pickbed::eval {
namespace {

// An input store and the offset of its numbers in the merged store.
struct Source {
  std::filesystem::path folder;
  StoreHead head;
  RowShift shift;
};

// Configurations shared by several stores.
struct Group {
  StoreHead head;
  RowShift shift;
  int end_trial = 0;  // one past the last trial, in the numbers of its stores
};

std::string FirstDifference(const std::string& a, const std::string& b) {
  size_t from = 0;
  for (size_t i = 0; i < std::min(a.size(), b.size()) && a[i] == b[i]; ++i) {
    if (a[i] == '\n') from = i + 1;
  }
  const auto line = [from](const std::string& text) {
    return text.substr(from, text.find('\n', from) - from);
  };
  return fmt::format("'{}' and '{}'", line(a), line(b));
}

// Describes the first difference between two heads, in settings known to the user.
std::string Unlike(const StoreHead& a, const StoreHead& b) {
  if (a.configurations.size() != b.configurations.size()) {
    return fmt::format("{} and {} configurations", a.configurations.size(),
                       b.configurations.size());
  }
  for (size_t i = 0; i < a.configurations.size(); ++i) {
    if (a.configurations[i].identity == b.configurations[i].identity) continue;
    return FirstDifference(a.configurations[i].identity, b.configurations[i].identity);
  }
  return FirstDifference(a.identity, b.identity);
}

// Returns the shortest unique path suffixes: "run_a"; or "a/run" and "b/run".
std::vector<std::string> NamesApart(const std::vector<std::filesystem::path>& folders) {
  std::vector<std::filesystem::path> rest, names;
  for (const std::filesystem::path& folder : folders) {
    rest.push_back((std::filesystem::absolute(folder) / ".").lexically_normal().parent_path());
    names.push_back(rest.back().filename());
  }
  for (bool grown = true; grown;) {
    grown = false;
    const std::vector<std::filesystem::path> before = names;
    for (size_t i = 0; i < names.size(); ++i) {
      if (std::count(before.begin(), before.end(), before[i]) < 2) continue;
      if (rest[i] == rest[i].root_path()) continue;
      rest[i] = rest[i].parent_path();
      names[i] = rest[i].filename() / names[i];
      grown = true;
    }
  }
  return {names.begin(), names.end()};
}

// Paths in the settings are relative to the folder of their store.
void Rebase(const std::filesystem::path& from, const std::filesystem::path& to, StoreHead& head) {
  for (StoredConfiguration& configuration : head.configurations) {
    configuration.settings =
        ScenarioText(ScenarioOfText(configuration.settings, from, from.string()), to);
  }
}

void Join(const StoreHead& head, StoreHead& into) {
  for (size_t i = 0; i < head.configurations.size(); ++i) {
    into.configurations[i].trials =
        std::max(into.configurations[i].trials, head.configurations[i].trials);
  }
}

int EndTrial(const StoreHead& head, const std::vector<int>& finished) {
  int end = finished.empty() ? 0 : finished.back() + 1;
  for (const StoredConfiguration& configuration : head.configurations) {
    end = std::max(end, configuration.first_trial + configuration.trials);
  }
  return end;
}

// Reads all values. A fault that is found later, in the merged store, would not name this one.
void RequireSoundTrials(const ResultsStore& store, const std::filesystem::path& folder) {
  const std::string file = (folder / kStoreFile).string();
  const std::vector<SettingsCounts> counts = SettingsCountsOf(store.head(), folder);
  store.ForEach([&](const TrialResult& trial) {
    CheckTrial(trial, counts.at(static_cast<size_t>(trial.configuration)), file);
  });
}

class Plan {
 public:
  Plan(std::filesystem::path out, bool compare) : out_(std::move(out)), compare_(compare) {}

  void Add(const std::filesystem::path& folder) {
    const ResultsStore store = ResultsStore::OpenToRead(folder, StoreChecks::kRows);
    RequireSoundTrials(store, folder);
    Source source{folder, store.head(), {}};
    Rebase(folder, out_, source.head);
    const int end = EndTrial(source.head, store.FinishedTrials());
    auto group = std::find_if(groups_.begin(), groups_.end(), [&](const Group& known) {
      return known.head.identity == source.head.identity;
    });
    if (group == groups_.end()) {
      CheckInput(
          compare_ || groups_.empty(),
          fmt::format("{} and {} have different settings: {}; merge them as a comparison to put "
                      "them side by side",
                      sources_.empty() ? "" : sources_.front().folder.string(), folder.string(),
                      groups_.empty() ? "" : Unlike(groups_.front().head, source.head)));
      group = groups_.insert(groups_.end(), {source.head, {}, 0});
      folders_.push_back(folder);
    }
    Join(source.head, group->head);
    group->end_trial = std::max(group->end_trial, end);
    members_.push_back(group - groups_.begin());
    sources_.push_back(std::move(source));
  }

  // Assigns the number ranges of all groups and returns the head of the merged store.
  StoreHead Settle() {
    const std::vector<std::string> names = NamesApart(folders_);
    StoreHead joined;
    RowShift next;
    for (size_t g = 0; g < groups_.size(); ++g) {
      groups_[g].shift = next;
      for (StoredConfiguration configuration : groups_[g].head.configurations) {
        configuration.number += next.configuration;
        configuration.first_trial += next.trial;
        if (groups_.size() > 1) {
          configuration.name =
              names[g] + (configuration.name.empty() ? "" : ":" + configuration.name);
        }
        joined.configurations.push_back(std::move(configuration));
      }
      joined.identity += groups_[g].head.identity;
      CheckInput(groups_[g].end_trial <= kMaxStoredTrials - next.trial,
                 fmt::format("{}: the stores have more than {} trials together; merge fewer",
                             folders_[g].string(), kMaxStoredTrials));
      next.trial += groups_[g].end_trial;
      next.configuration += static_cast<int>(groups_[g].head.configurations.size());
    }
    for (size_t s = 0; s < sources_.size(); ++s) sources_[s].shift = groups_[members_[s]].shift;
    return joined;
  }

  const std::vector<Source>& sources() const { return sources_; }

 private:
  std::filesystem::path out_;
  bool compare_;
  std::vector<Group> groups_;
  std::vector<std::filesystem::path> folders_;  // first folder of each group
  std::vector<Source> sources_;
  std::vector<size_t> members_;  // group index of each source
};

// Returns the file of the store, or an upgraded copy if the store has an earlier version.
std::filesystem::path FileOfThisVersion(const Source& source,
                                        const std::filesystem::path& scratch) {
  const std::filesystem::path file = source.folder / kStoreFile;
  if (IsOfThisVersion(Database(file, Database::Mode::kExisting))) return file;
  std::filesystem::create_directories(scratch);
  std::filesystem::copy_file(file, scratch / kStoreFile,
                             std::filesystem::copy_options::overwrite_existing);
  ResultsStore(scratch, source.head);
  return scratch / kStoreFile;
}

int JoinAll(const std::vector<Source>& sources, const std::filesystem::path& file) {
  const Database db(file, Database::Mode::kExisting);
  // The file is moved to its place only when it is complete, so losing a partial file is harmless.
  db.Execute("PRAGMA main.synchronous = OFF");
  int doubled = 0;
  for (const Source& source : sources) {
    const std::filesystem::path scratch = file.parent_path() / "earlier_version";
    doubled += JoinRows(db, FileOfThisVersion(source, scratch), source.shift);
    std::filesystem::remove_all(scratch);
  }
  return doubled;
}

// Flushes the file to disk, because it is about to replace another one.
void WriteThrough(const std::filesystem::path& path) {
  const int file = open(path.c_str(), O_RDONLY);
  const bool written = file >= 0 && fsync(file) == 0;
  if (file >= 0) close(file);
  CheckInput(written, fmt::format("{}: {}", path.string(), strerror(errno)));
}

// Temporary folder, removed even if the merge fails, because a full disk needs the space.
class ScratchFolder {
 public:
  explicit ScratchFolder(std::filesystem::path path) : path_(std::move(path)) {
    std::filesystem::remove_all(path_);  // left by a killed merge
  }
  ~ScratchFolder() {
    std::error_code error;
    std::filesystem::remove_all(path_, error);
  }
  ScratchFolder(const ScratchFolder&) = delete;
  ScratchFolder& operator=(const ScratchFolder&) = delete;
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

void MergeInto(const std::filesystem::path& out, const Plan& plan, const StoreHead& head,
               MergeReport& report) {
  const ScratchFolder scratch(out / "merging");
  { const ResultsStore store(scratch.path(), head); }
  report.doubled = JoinAll(plan.sources(), scratch.path() / kStoreFile);
  // Keep the trials of an earlier merge; its shards may no longer exist.
  if (std::filesystem::exists(out / kStoreFile)) {
    JoinAll({{out, head, {}}}, scratch.path() / kStoreFile);
  }
  WriteThrough(scratch.path() / kStoreFile);
  std::filesystem::rename(scratch.path() / kStoreFile, out / kStoreFile);
}

}  // namespace

MergeReport MergeStores(const std::vector<std::filesystem::path>& folders,
                        const std::filesystem::path& out, const MergeOptions& options) {
  const FolderLock lock(out);
  Plan plan(out, options.compare);
  for (const std::filesystem::path& folder : folders) plan.Add(folder);
  const StoreHead head = plan.Settle();
  if (const auto stored = StoredSettings(out)) {
    CheckInput(
        *stored == head.identity,
        fmt::format("{} already has results of other settings; choose another results folder",
                    out.string()));
  }
  MergeReport report;
  MergeInto(out, plan, head, report);
  report.configurations = WriteSweepFiles(out);
  int wanted = 0;
  for (const ConfigurationSummary& configuration : report.configurations) {
    const int there =
        configuration.summary.trials + static_cast<int>(configuration.summary.crashed.size());
    const bool ended_early = configuration.summary.stop && configuration.summary.stop->reached;
    wanted += ended_early ? there : configuration.configuration.trials;
    report.trials += there;
  }
  report.missing = wanted - report.trials;
  return report;
}

}  // namespace pickbed::eval
