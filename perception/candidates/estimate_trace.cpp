#include "perception/candidates/estimate_trace.h"

#include <algorithm>

namespace pickbed::perception {

int TracePatches(std::span<const int> pixels, const PatchSet& patches, double side_m,
                 EstimateTrace& trace) {
  const int first = static_cast<int>(trace.patches.size());
  for (size_t i = 0; i < patches.size(); ++i) {
    TracedPatch& patch = trace.patches.emplace_back();
    patch.pixel = pixels[i];
    patch.side_m = side_m;
    patch.X_CP = patches.X_CP[i];
    std::ranges::copy(patches.patch(i), patch.values.begin());
  }
  return first;
}

}  // namespace pickbed::perception
