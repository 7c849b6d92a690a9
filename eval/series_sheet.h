#pragma once

// Pictures of occlusion trials: one row a target, one column a band.

#include <filesystem>
#include <string>
#include <vector>

#include "eval/occlusion_curve.h"
#include "eval/trial_observer.h"

namespace pickbed {

// What the camera sees about the target of a look, with the outline of what is in view of it; from
// TrialStage::kGrasp on, until the pick has changed the scene.
Image<Rgb8> BandTile(const LookState& look);
std::string BandTileName(int band);  // "band_0.png"

// PICTURES/occlusion.png from the tiles PICTURES/trial_*/band_*.png, the least visible on the left;
// nothing when there are none. Throws InputError when a picture cannot be read or written.
void WriteSeriesSheet(const std::filesystem::path& pictures, const std::vector<BandFigures>& bands);

}  // namespace pickbed
