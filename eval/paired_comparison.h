#pragma once

// Two runs on the same scenes, figure by figure: what each reaches, by how much they differ with
// interval and p value, and how many scenes such a difference needs to be shown.

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "eval/paired_tests.h"
#include "eval/summary.h"
#include "eval/trial.h"

namespace pickbed {

struct PairedFigure {
  std::string key;      // "recall_30_50"
  std::string name;     // "recall, 30-50 % visible"
  bool is_rate = true;  // 0..1; else an error, smaller is better
  double before = 0, after = 0;
  // Of after - before; of a median in fewer than six scenes with infinite ends.
  Interval difference_ci95{-1, 1};
  double p_value = 1;
  std::string test = {};      // how p was found: "mcnemar" | "sign_flip"
  int scenes = 0;             // that tell something of it in either run
  int discordant_scenes = 0;  // in which the two runs differ
  // Of rates: to show this difference with power .8 at the level .05.
  std::optional<int> scenes_needed = std::nullopt;
  std::optional<OddsRatio> odds_ratio = std::nullopt;  // where each scene gives one outcome

  double difference() const { return after - before; }
};

struct PairedComparison {
  int scenes = 0;       // shared
  int before_only = 0;  // scenes that only one of the runs has
  int after_only = 0;
  std::vector<PairedFigure> figures;
};

// Pick success, parts cleared, recall of all at least 10 % visible and by visible fraction, targets
// picked by visible fraction, top-ranked poses, median MSSD and rotation on the instances that both
// found (PairedErrorsByScene). Figures of which a run tells nothing are left out. Trials are paired
// by their scene number; pass those of one point each, whose `bands` are the same where their
// scenes are. Throws InputError when no scene is shared.
PairedComparison ComparePaired(std::span<const TrialResult> before,
                               std::span<const TrialResult> after,
                               const std::vector<VisibleBand>& bands = ReportedBands());

// A cluster comparison of any rate, as a row of the table.
PairedFigure PairedRate(const std::string& key, const std::string& name,
                        const std::vector<Cluster>& before, const std::vector<Cluster>& after);

// The part of a run's settings or identity (eval/run.h) that makes its scenes: seed, bin, parts and
// arrangement, with the hashes of meshes where the text has them; of trials on occlusion also the
// camera and all of `occlusion`, which place the blockers. Trials of equal number have the same
// scenes where these are equal, whatever looks at them.
std::string SceneKey(const std::string& settings);

// Throws InputError, naming both runs and the first setting that differs with its group, unless the
// keys agree.
void RequireSameScenes(const std::string& settings_before, const std::string& settings_after,
                       const std::string& name_before, const std::string& name_after);

// For people; JSON with infinite and unknown numbers as null.
std::string PairedTable(const PairedComparison& comparison);
std::string PairedJson(const PairedComparison& comparison);

}  // namespace pickbed
