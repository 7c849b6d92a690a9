#pragma once

// Completions by rules, without a network. Each rule draws the seen surface back along the pixels'
// rays to a depth. Cells that are known to be empty, or below the floor, are empty.

#include <memory>
#include <string>

#include "perception/completion/shape_completer.h"

namespace pickbed::perception {

enum class CompletionRule {
  // As deep as the widest circle in the silhouette that contains the pixel.
  kLocalThickness,
  // A constant depth.
  kSkirt,
  // Reflected at the plane of the deepest seen point.
  kMirror,
  // Back to the nearest point plus the smaller width of the silhouette.
  kExtrusion
};

// Returns a completer with probabilities 0 and 1.
std::unique_ptr<ShapeCompleter> MakeRuleCompleter(CompletionRule rule,
                                                  const CompletionOptions& options);

}  // namespace pickbed::perception
