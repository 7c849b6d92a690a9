#pragma once

// Overview image of occlusion trials: one row per target, one column per band.

#include <filesystem>
#include <string>
#include <vector>

#include "eval/summary/occlusion_curve.h"
#include "eval/trial/observer.h"

namespace pickbed::eval {

// Returns a picture of the target of an attempt, with the outline of its visible region. `picture`
// shows the scene of the attempt. Valid from TrialStage::kGrasp on, until the pick changes the
// scene.
Image<Rgb8> BandTile(const AttemptState& attempt, const sim::Picture& picture);
std::string BandTileName(int band);  // such as "band_0.png"

// Writes `sheet` from the tiles trial_*/band_*.png in its folder, the least visible band on the
// left. Does nothing if there are no tiles. Throws InputError if an image cannot be read or
// written.
void WriteSeriesSheet(const std::filesystem::path& sheet, const std::vector<BandStatistics>& bands);

}  // namespace pickbed::eval
