#include "eval/few_bins.h"

#include <fmt/format.h>

namespace pickbed {

std::string FewBinsText(int bins) {
  if (bins >= kFewBins) return "";
  return fmt::format("{} {} few: the intervals are wide and rough; take {} or more.", bins,
                     bins == 1 ? "bin is" : "bins are", kFewBins);
}

}  // namespace pickbed
