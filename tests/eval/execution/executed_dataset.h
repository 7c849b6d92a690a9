#pragma once

// A small data set with stored scenes, and its true poses, for tests of executed results.

#include <string>
#include <vector>

#include "eval/execution/execution.h"
#include "scenes/base/files.h"
#include "tests/eval/bop_small_dataset.h"
#include "tests/support/temporary_folder.h"

namespace pickbed::tests {

class ExecutedDataset {
 public:
  ExecutedDataset(int scenes, int views) { MakeSmall(root(), scenes, views); }

  std::filesystem::path root() const { return folder_.path() / "data"; }
  std::vector<DatasetEstimate> Truth() const { return TrueEstimates(root(), "test"); }
  // Writes a results file and returns its path.
  std::filesystem::path Write(const std::string& name,
                              const std::vector<DatasetEstimate>& estimates) const {
    return folder_.Write("results/" + name, WriteEstimates(estimates));
  }
  ExecutionOptions Options(const std::string& out,
                           const std::vector<std::filesystem::path>& results) const {
    ExecutionOptions options;
    options.dataset = root();
    options.out = folder_.path() / out;
    options.results = results;
    return options;
  }
  std::string Bytes(const std::string& file) const { return ReadFileBytes(folder_.path() / file); }

 private:
  TemporaryFolder folder_;
};

inline ExecutionReport Execute(const ExecutionOptions& options,
                               const ExecutionListener& listener = {}) {
  return ExecuteResults(SmallScenario(), EasyCube(), options, listener);
}

}  // namespace pickbed::tests
