#include "eval/cli/image/estimate_arguments.h"

#include <fmt/format.h>

#include <algorithm>

#include "eval/summary/result_files.h"
#include "scenes/base/error.h"

namespace pickbed::eval {

std::vector<ComparedEstimator> NamedEstimators(const ScenarioRequest& arguments,
                                               const std::vector<std::string>& labels,
                                               const EstimatorSpec& base) {
  const std::vector<ComparedEstimator> rows =
      ParseEstimators(labels.empty() ? std::vector{base.name} : labels, base);
  for (const std::string& setting : arguments.settings) {
    const bool taken = std::any_of(rows.begin(), rows.end(), [&](const ComparedEstimator& row) {
      return row.spec.model == base.model;
    });
    CheckInput(
        taken || !setting.starts_with("estimator.model="),
        fmt::format("--set {}: this model belongs to '{}', which --estimator does not name; write "
                    "--estimator NAME={} with the estimator that the model was trained for",
                    setting, base.name, base.model));
  }
  return rows;
}

EstimatorSpec ExplainedEstimator(const ScenarioRequest& arguments,
                                 const std::vector<std::string>& labels,
                                 const EstimatorSpec& spec) {
  CheckInput(labels.size() < 2, "--explain shows the stages of one estimator; name only one");
  const EstimatorSpec chosen = NamedEstimators(arguments, labels, spec).front().spec;
  RequireExplains(chosen.name);
  return chosen;
}

void SayWhereExplained(const ExplanationPage& page) {
  if (SayIfUnwritten(page.unwritten)) {
    fmt::print("page with pictures of the stages: {}{}\n", page.file.string(),
               page.replaced ? "; it replaces an earlier page of this image" : "");
  } else {
    fmt::print("pictures of the stages in {}\n",
               (page.file.parent_path() / kPicturesFolder).string());
  }
}

ScenarioSpec ImageSettings(const ScenarioRequest& arguments, double min_score) {
  ScenarioSpec spec;
  spec.estimator.min_score = min_score;
  for (const std::string& setting : arguments.settings) {
    ApplySetting(setting, [&](SettingsVisitor& v) { spec.Visit(v); });
  }
  spec.roi.Validate("setting roi");
  return spec;
}

}  // namespace pickbed::eval
