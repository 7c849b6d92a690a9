#pragma once

// HTML page about a training of the completion network: curves, and completions of held-out views.

#include <filesystem>
#include <string>

#include "eval/layer.h"
#include "eval/metrics/result_columns.h"
#include "perception/completion/completion_training.h"

namespace pickbed::eval {

inline constexpr char kCompletionCurvesFile[] = "completion_curves.csv";

struct CompletionTrainingPage {
  std::filesystem::path model_file;
  const CompletionJob& job;
  const CompletionTrainingOptions& options;
  const CompletionReport& report;
  std::string settings;  // effective settings as YAML
};

// Writes index.html, completion_curves.csv, and a picture for each held-out split to `folder`,
// which is created. Returns an empty string, or the reason why the page is missing (WritePage in
// eval/page/html.h). Throws InputError if a file cannot be written.
[[nodiscard]] std::string WriteCompletionTrainingPage(const std::filesystem::path& folder,
                                                      const CompletionTrainingPage& page);

// Columns of completion_curves.csv.
ResultColumns CompletionCurvesColumns();

}  // namespace pickbed::eval
