// Measures how well pose errors predict the outcome of picks in another group's simulation (folder
// pick_outcomes of the test data), printed to stdout:
//   outcome_figures OUTCOMES.csv [PREDICTORS.csv ...]
//
// Prints the AUC of each error by object, method and hand, the medians, and their order. The
// predictors.csv of `pickbed tolerance` are of own maps; with them, it prints the order in these
// and its rank correlation with the published one.

#include <fmt/format.h>

#include <cstdlib>
#include <map>

#include "tests/support/pick_outcomes.h"

namespace pickbed::tests {
namespace {

void PrintPairs(const std::vector<ObjectMethodPair>& pairs) {
  fmt::print("{:<14}{:<6}{:<8}{:<10}{:>6}{:>9}", "hand", "set", "object", "method", "poses",
             "picked");
  for (const char* error : kOutcomeErrors) fmt::print("{:>15}", error);
  fmt::print("\n");
  for (const ObjectMethodPair& pair : pairs) {
    fmt::print("{:<14}{:<6}{:<8}{:<10}{:>6}{:>9}", pair.hand, pair.dataset, pair.object,
               pair.method, pair.poses.size(), pair.successes());
    for (size_t i = 0; i < kOutcomeErrors.size(); ++i) {
      fmt::print("{:>15}", pair.has_both() ? fmt::format("{:.3f}", pair.AucOf(i)) : "-");
    }
    fmt::print("\n");
  }
}

// Median AUC by error over tolerance maps, for errors that the outcomes have.
std::map<std::string, double> OwnMedians(const std::vector<std::string>& files) {
  std::map<std::string, ValueClusters> aucs;
  for (const std::string& file : files) {
    std::istringstream lines(ReadFileBytes(file));
    std::string line;
    std::getline(lines, line);
    while (std::getline(lines, line)) {
      std::istringstream cells(line);
      std::string name, auc;
      std::getline(cells, name, ',');
      std::getline(cells, auc, ',');
      const auto column = std::ranges::find_if(
          kOutcomeErrors, [&](const std::string& error) { return error.starts_with(name + "_"); });
      if (column != kOutcomeErrors.end() && !auc.empty()) aucs[*column].push_back({std::stod(auc)});
    }
  }
  std::map<std::string, double> medians;
  for (const auto& [name, values] : aucs) medians[name] = MedianOf(values);
  return medians;
}

// Spearman's rank correlation of two orders of the same names.
double RankCorrelation(const std::vector<std::string>& a, const std::vector<std::string>& b) {
  const double n = static_cast<double>(a.size());
  double sum = 0;
  for (size_t i = 0; i < a.size(); ++i) {
    const auto place = std::ranges::find(b, a[i]) - b.begin();
    sum += (static_cast<double>(i) - place) * (static_cast<double>(i) - place);
  }
  return 1 - 6 * sum / (n * (n * n - 1));
}

void PrintRanking(const std::vector<ObjectMethodPair>& pairs, const std::string& hand,
                  const std::map<std::string, double>& own) {
  const std::vector<RankedError> ranked = RankErrors(pairs, hand);
  const auto both = std::ranges::count_if(
      pairs, [&](const auto& pair) { return pair.hand == hand && pair.has_both(); });
  fmt::print("\n{}: median AUC over {} pairs with both outcomes\n", hand, both);
  std::vector<std::string> order, own_order;
  for (const RankedError& error : ranked) {
    const auto found = own.find(error.error);
    fmt::print("  {:<15}{:.3f}", error.error, error.median_auc);
    if (found != own.end()) {
      fmt::print("   own maps {:.3f}", found->second);
      order.push_back(error.error);
    }
    fmt::print("\n");
  }
  if (order.size() < 2) return;
  own_order = order;
  std::ranges::stable_sort(own_order, std::greater<>(),
                           [&](const std::string& name) { return own.at(name); });
  fmt::print("  rank correlation of {} errors: {:.2f}\n", order.size(),
             RankCorrelation(order, own_order));
}

int Main(const std::vector<std::string>& arguments) {
  if (arguments.empty()) {
    fmt::print(stderr, "usage: outcome_figures OUTCOMES.csv [PREDICTORS.csv ...]\n");
    return EXIT_FAILURE;
  }
  const std::vector<ObjectMethodPair> pairs = ReadPickOutcomes(arguments.front());
  const auto own = OwnMedians({arguments.begin() + 1, arguments.end()});
  PrintPairs(pairs);
  for (const char* hand : {"parallel", "underactuated"}) PrintRanking(pairs, hand, own);
  return EXIT_SUCCESS;
}

}  // namespace
}  // namespace pickbed::tests

int main(int argc, char** argv) { return pickbed::tests::Main({argv + 1, argv + argc}); }
