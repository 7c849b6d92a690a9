#include "eval/bop/scores.h"

#include <algorithm>
#include <numeric>

namespace pickbed::eval {
namespace {

// Indices by descending value. Equal values keep their order.
std::vector<int> FallingOrder(const std::vector<double>& values) {
  std::vector<int> order(values.size());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) { return values[a] > values[b]; });
  return order;
}

}  // namespace

std::vector<int> HighestScores(const std::vector<double>& scores, size_t count) {
  std::vector<int> order = FallingOrder(scores);
  if (order.size() > count) order.resize(count);
  return order;
}

std::vector<bool> MostVisible(const std::vector<double>& visible, size_t count) {
  std::vector<bool> chosen(visible.size(), false);
  for (const int i : HighestScores(visible, count)) chosen[i] = true;
  return chosen;
}

std::vector<int> MatchGreedily(const ErrorTable& table, const std::vector<bool>& allowed,
                               double threshold) {
  std::vector<int> matches(table.scores.size(), -1);
  std::vector<bool> taken(table.visible.size(), false);
  for (const int estimate : FallingOrder(table.scores)) {
    double best = threshold;
    int instance = -1;
    for (size_t i = 0; i < table.visible.size(); ++i) {
      if (!allowed[i] || taken[i] || !(table.errors[estimate][i] < best)) continue;
      best = table.errors[estimate][i];
      instance = static_cast<int>(i);
    }
    if (instance < 0) continue;
    matches[estimate] = instance;
    taken[instance] = true;
  }
  return matches;
}

Recall RecallOf(const ErrorTable& table, int count, double threshold) {
  ErrorTable kept{table.object_id, {}, table.visible, {}};
  for (const int i : HighestScores(table.scores, count)) {
    kept.scores.push_back(table.scores[i]);
    kept.errors.push_back(table.errors[i]);
  }
  const std::vector<bool> wanted = MostVisible(table.visible, count);
  const std::vector<int> matches = MatchGreedily(kept, wanted, threshold);
  Recall recall;
  recall.wanted = static_cast<int>(std::count(wanted.begin(), wanted.end(), true));
  recall.found = static_cast<int>(
      std::count_if(matches.begin(), matches.end(), [](int instance) { return instance >= 0; }));
  return recall;
}

double AveragePrecision(std::vector<Detection> detections, int wanted) {
  if (wanted == 0) return 0;
  std::stable_sort(detections.begin(), detections.end(),
                   [](const Detection& a, const Detection& b) { return a.score > b.score; });
  std::vector<int> right(detections.size());
  int found = 0;
  for (size_t i = 0; i < detections.size(); ++i) right[i] = found += detections[i].right;
  // From the end: the highest precision at this recall or above.
  std::vector<double> precision(detections.size());
  double best = 0;
  for (size_t i = detections.size(); i-- > 0;) {
    best = std::max(best, static_cast<double>(right[i]) / static_cast<double>(i + 1));
    precision[i] = best;
  }
  constexpr int kLevels = 101;
  double sum = 0;
  size_t i = 0;
  for (int level = 0; level < kLevels; ++level) {
    const double recall = level + 1 == kLevels ? 1 : level * 0.01;
    while (i < right.size() && static_cast<double>(right[i]) / wanted < recall) ++i;
    if (i < right.size()) sum += precision[i];
  }
  return sum / kLevels;
}

std::map<int, double> AveragePrecisions(const std::vector<ErrorTable>& tables, double threshold) {
  std::map<int, std::vector<Detection>> detections;
  std::map<int, int> wanted;
  for (const ErrorTable& table : tables) {
    const std::vector<bool> all(table.visible.size(), true);
    const std::vector<int> matches = MatchGreedily(table, all, threshold);
    for (size_t i = 0; i < matches.size(); ++i) {
      const bool matched = matches[i] >= 0;
      if (matched && table.visible[matches[i]] < kMinVisible) continue;
      detections[table.object_id].push_back({table.scores[i], matched});
    }
    for (const double visible : table.visible) wanted[table.object_id] += visible >= kMinVisible;
  }
  std::map<int, double> precisions;
  for (const auto& [object, count] : wanted) {
    if (count > 0) precisions[object] = AveragePrecision(detections[object], count);
  }
  return precisions;
}

}  // namespace pickbed::eval
