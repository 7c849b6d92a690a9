#include "scenes/base/error.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <numeric>

#include "scenes/base/message_text.h"

namespace pickbed::scenes {
namespace {

// Edit distance with insertions, deletions, substitutions and swaps of adjacent letters (optimal
// string alignment), which are the usual typing errors.
size_t EditDistance(std::string_view a, std::string_view b) {
  std::vector<size_t> before_last, last(b.size() + 1), row(b.size() + 1);
  std::iota(last.begin(), last.end(), size_t{0});
  for (size_t i = 1; i <= a.size(); ++i) {
    row[0] = i;
    for (size_t j = 1; j <= b.size(); ++j) {
      row[j] = std::min({last[j] + 1, row[j - 1] + 1, last[j - 1] + (a[i - 1] != b[j - 1])});
      if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1]) {
        row[j] = std::min(row[j], before_last[j - 2] + 1);
      }
    }
    before_last = last;
    last.swap(row);
  }
  return last[b.size()];
}

}  // namespace

void CheckInput(bool ok, const std::string& message) {
  if (!ok) throw InputError(message);
}

std::string NearestName(std::string_view word, const std::vector<std::string>& candidates) {
  std::string best;
  size_t best_distance = std::numeric_limits<size_t>::max();
  for (const std::string& candidate : candidates) {
    const size_t distance = EditDistance(word, candidate);
    const bool likely = 3 * distance <= std::max(word.size(), candidate.size());
    if (likely && distance < best_distance) {
      best = candidate;
      best_distance = distance;
    }
  }
  return best;
}

std::string UnknownNameMessage(std::string_view kind, std::string_view word,
                               const std::vector<std::string>& candidates) {
  std::string message = fmt::format("unknown {} '{}'", kind, Printable(std::string(word)));
  const std::string nearest = NearestName(word, candidates);
  if (!nearest.empty()) message += "; did you mean '" + nearest + "'?";
  if (candidates.empty()) return message + "; none is known";
  message += nearest.empty() ? "; known: " : " known: ";
  for (size_t i = 0; i < candidates.size(); ++i) message += (i ? ", " : "") + candidates[i];
  return message;
}

}  // namespace pickbed::scenes
