#include <fmt/format.h>
#include <pybind11/stl.h>

#include <cmath>
#include <string>

#include "eval/python/arrays.h"
#include "eval/python/docstring.h"
#include "eval/python/module.h"
#include "eval/stats/statistics.h"
#include "scenes/base/error.h"

namespace pickbed::eval {
namespace {

namespace py = pybind11;

void RequireConfidence(double confidence) {
  CheckInput(confidence > 0 && confidence < 1,
             fmt::format("confidence = {}: must be between 0 and 1", confidence));
}

// Returns None for an unknown interval.
py::object PairOf(const Interval& interval) {
  if (!interval.is_known()) return py::none();
  return py::make_tuple(interval.low, interval.high);
}

// Returns the docstring with what Python returns and takes.
std::string WithResult(const char* doc, const char* argument = "") {
  return fmt::format("{}\n\n{}Returns (low, high), or None if nothing is known.", doc, argument);
}
constexpr char kUnits[] = "Each unit is a pair (hits, samples). ";

using Counts = std::vector<std::pair<int, int>>;

std::vector<Cluster> ClustersFrom(const Counts& counts, const std::string& name) {
  std::vector<Cluster> clusters;
  for (const auto& [hits, samples] : counts) {
    CheckInput(hits >= 0 && hits <= samples,
               fmt::format("{} has {} hits of {} samples", name, hits, samples));
    clusters.push_back({hits, samples});
  }
  return clusters;
}

ValueClusters ValuesFrom(const ValueClusters& values) {
  for (const auto& cluster : values) {
    for (const double value : cluster) CheckInput(!std::isnan(value), "values has NaN");
  }
  return values;
}

}  // namespace

void AddIntervals(py::module_& module) {
  module.attr("MIN_BINS_OF_INTERVAL") = kMinBinsOfInterval;
  module.def(
      "wilson_interval",
      [](int successes, int attempts, double confidence) {
        RequireConfidence(confidence);
        ClustersFrom({{successes, attempts}}, "the rate");
        return PairOf(WilsonInterval(successes, attempts, confidence));
      },
      py::arg("successes"), py::arg("attempts"), py::arg("confidence") = 0.95,
      WithResult(Doc("WilsonInterval")).c_str());
  module.def(
      "cluster_interval",
      [](const Counts& clusters, double confidence) {
        RequireConfidence(confidence);
        return PairOf(ClusterInterval(ClustersFrom(clusters, "clusters"), confidence));
      },
      py::arg("clusters"), py::arg("confidence") = 0.95,
      WithResult(Doc("ClusterInterval"), kUnits).c_str());
  module.def(
      "paired_interval",
      [](const Counts& before, const Counts& after, double confidence) {
        RequireConfidence(confidence);
        CheckInput(before.size() == after.size(),
                   fmt::format("before has {} units and after has {}; they must be the same units",
                               before.size(), after.size()));
        return PairOf(PairedInterval(ClustersFrom(before, "before"), ClustersFrom(after, "after"),
                                     confidence));
      },
      py::arg("before"), py::arg("after"), py::arg("confidence") = 0.95,
      WithResult(Doc("PairedInterval"), kUnits).c_str());
  module.def(
      "median_interval",
      [](const ValueClusters& values, double confidence) {
        RequireConfidence(confidence);
        return PairOf(MedianInterval(ValuesFrom(values), confidence));
      },
      py::arg("values"), py::arg("confidence") = 0.95,
      WithResult(Doc("MedianInterval"), "`values` has one list for each unit. ").c_str());
}

}  // namespace pickbed::eval
