#pragma once

// Writes an HTML page that shows how an estimator processed one image, with a picture of each
// stage.

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "eval/explain/truth.h"
#include "scenes/base/ids.h"
#include "scenes/labelled_view.h"
#include "scenes/scenario/scenario_spec.h"

namespace pickbed::eval {

// Returns the file name of the page of an image, for example explain_trial_3.html.
std::string ExplainPageName(const std::string& image);
// Returns the name of an image of a scenario (trial_3) or of a dataset (image_48_12).
std::string TrialImageName(int trial);
std::string DatasetImageName(int scene, int image);

// Input of the page: one image, the trace of its estimate, and optionally the ground truth.
struct Explained {
  std::string title;
  std::string image;  // its name, for the files
  const RgbdFrame& frame;
  const ObjectSet& objects;
  const EstimateTrace& trace;
  const std::vector<PoseHypothesis>& hypotheses;   // reported poses, highest score first
  std::optional<std::vector<TrueInstance>> truth;  // without it, no pose is called right or wrong
  LabelledViewSource& views;                       // renders the codebook entries
  double working_distance_m = 0.85;
  std::optional<ImageBox> region = {};  // shown part of the frame; default: its foreground
};

// A page that was written.
struct ExplanationPage {
  std::filesystem::path file;
  bool replaced = false;  // a page of the same image was in the folder
  std::string
      unwritten;  // reason why the page is missing (WritePage in eval/page/html.h), or empty
};

// Writes explain_IMAGE.html and pictures/IMAGE/*.png into `folder`. Throws InputError if a file
// cannot be written.
[[nodiscard]] ExplanationPage WriteExplanation(const Explained& explained,
                                               const std::filesystem::path& folder);

// Throws InputError for an estimator that does not record a trace.
void RequireExplains(const std::string& estimator);

// Explains the first image of a bin. Image and random numbers are the same as in an estimator
// comparison. Throws InputError for an estimator without a trace.
[[nodiscard]] ExplanationPage ExplainTrial(
    const ScenarioSpec& spec, const ObjectSet& objects, const std::string& title,
    BinIndex bin_index, const std::filesystem::path& folder,
    const std::function<void(std::string_view what, double share)>& on_progress);

}  // namespace pickbed::eval
