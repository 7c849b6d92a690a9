#pragma once

// The occlusion series of a trial: targets, and where none of them will do scenes, are tried one
// after the other until one target has been seen in all bands.

#include <vector>

#include "sim/occluded_scene.h"
#include "sim/scene_maker.h"

namespace pickbed {

// One band of the settings in one trial.
struct BandAccount {
  bool filled = false;  // by the series that was chosen
  int given_up = 0;     // targets that were left because this was the first band that stayed empty
  BlockerCounts blockers;  // of all targets tried
  friend bool operator==(const BandAccount&, const BandAccount&) = default;
};

struct MadeSeries {
  CertifiedScene start;    // the scene without blockers, with the refused ones of all scenes tried
  OcclusionSeries series;  // the first that fills all bands, else the first that fills most
  std::vector<BandAccount> bands;
  int targets_tried = 0;
};

// Scenes come from the streams "drop", "drop/scene_1", ..., series from "occlude/SCENE/TARGET" of
// (request.seed, request.trial). Targets are instances of objects that are `wanted`, in random
// order. Where no scene passes or no band can be filled the series is empty, since another trial
// may have one. Throws InputError when no trial can: nothing that is wanted is dropped.
MadeSeries MakeOcclusionSeries(SceneRenderer& renderer, const SceneRequest& request,
                               const std::vector<int>& wanted, const OcclusionSetup& setup);

}  // namespace pickbed
