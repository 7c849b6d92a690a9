#pragma once

// One image of an estimator, stage by stage: a page with a picture of each.

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "eval/explain_truth.h"
#include "scenes/labelled_view.h"
#include "scenes/scenario_spec.h"

namespace pickbed {

struct Explained {
  std::string title;
  const RgbdFrame& frame;
  const ObjectSet& objects;
  const EstimateTrace& trace;
  const std::vector<PoseHypothesis>& hypotheses;  // the answer, highest score first
  std::optional<std::vector<TruePart>> truth;     // nothing is called right or wrong without it
  LabelledViewSource& views;                      // of the code book's entries
  double working_distance_m = 0.85;
};

// explain.html and pictures/*.png in `folder`. Throws InputError when they cannot be written.
void WriteExplanation(const Explained& explained, const std::filesystem::path& folder);

// Throws InputError for an estimator that does not tell how it came to its answer.
void RequireExplains(const std::string& estimator);

// The first look of a trial, as estimate and comparison see it.
void ExplainTrial(const ScenarioSpec& spec, const ObjectSet& objects, const std::string& title,
                  int trial, const std::filesystem::path& folder,
                  const std::function<void(std::string_view what, double share)>& on_progress);

}  // namespace pickbed
