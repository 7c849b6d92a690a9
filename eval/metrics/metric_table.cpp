#include "eval/metrics/metric_table.h"

#include <algorithm>
#include <iterator>
#include <limits>
#include <numbers>

namespace pickbed::eval {
namespace {

double MssdOf(const MetricInput& in) {
  return in.known_mssd_m ? *in.known_mssd_m : Mssd(in.model, in.X_est, in.X_true);
}

constexpr unsigned kPublished = kListed | kPredictor | kRecorded | kPlacedColumn;

constexpr MetricRow kMetrics[] = {
    {"mssd", "diameters", "MSSD", "maximum symmetry-aware surface distance in object diameters",
     [](const MetricInput& in) { return MssdOf(in) / in.model.diameter_m; },
     kRecorded | kPlacedColumn | kReported | kCompared},
    {"mssd", "m", "MSSD", "maximum symmetry-aware surface distance", MssdOf, kPublished},
    {"mspd", "px", "MSPD", "maximum symmetry-aware projection distance",
     [](const MetricInput& in) { return Mspd(in.model, in.camera, in.X_est, in.X_true); },
     kPublished & ~kPredictor},
    {"add", "m", "ADD", "mean distance of corresponding model points",
     [](const MetricInput& in) { return Add(in.model, in.X_est, in.X_true); }, kPublished},
    {"adi", "m", "ADI", "mean distance to the closest model point",
     [](const MetricInput& in) { return Adi(in.model, in.X_est, in.X_true); }, kPublished},
    {"rotation", "rad", "rotation error",
     "angle of the rotation error, minimum over the symmetries",
     [](const MetricInput& in) { return RotationError(in.model, in.X_est, in.X_true); },
     kUsualOutputs | kPlacedColumn},
    {"translation", "m", "translation error",
     "distance of the origins, minimum over the symmetries",
     [](const MetricInput& in) { return TranslationError(in.model, in.X_est, in.X_true); },
     kPublished | kReported},
    {kPickRiskMetric, "0..1", "pick risk",
     "predicted probability that the pick fails, from the tolerance map of the object",
     [](const MetricInput& in) { return PickRisk(in.tolerance, in.X_est, in.X_true); },
     kListed | kPredictor},
};

std::vector<MetricRow>& Rows() {
  static std::vector<MetricRow> rows(std::begin(kMetrics), std::end(kMetrics));
  return rows;
}

std::string WithUnit(const std::string& name, const std::string& unit) {
  return unit.empty() ? name : name + "_" + unit;
}

}  // namespace

std::span<const MetricRow> MetricTable() { return Rows(); }

std::vector<MetricRow> MetricsIn(MetricOutput output,
                                 std::initializer_list<std::string_view> first) {
  std::vector<MetricRow> rows;
  std::copy_if(Rows().begin(), Rows().end(), std::back_inserter(rows),
               [&](const MetricRow& row) { return row.IsIn(output); });
  const auto place = [&](const MetricRow& row) {
    return std::find(first.begin(), first.end(), MetricKey(row)) - first.begin();
  };
  std::stable_sort(rows.begin(), rows.end(),
                   [&](const MetricRow& a, const MetricRow& b) { return place(a) < place(b); });
  return rows;
}

std::string MetricKey(const MetricRow& row) { return WithUnit(row.name, row.unit); }

MetricValues RecordedMetrics(const MetricInput& input) {
  MetricValues values;
  for (const MetricRow& row : Rows()) {
    if (row.IsIn(kRecorded)) values.Set(MetricKey(row), row.compute(input));
  }
  return values;
}

MetricValues InfiniteMetrics() {
  MetricValues values;
  for (const MetricRow& row : Rows()) {
    if (row.IsIn(kRecorded)) values.Set(MetricKey(row), std::numeric_limits<double>::infinity());
  }
  return values;
}

ShownUnit ShownUnitOf(const MetricRow& row) {
  const std::string_view unit = row.unit;
  if (unit == "m") return {"mm", 1e3, 1, 2};
  if (unit == "px") return {"px", 1, 1, 2};
  if (unit == "rad") return {"deg", 180, std::numbers::pi, 2};
  return {row.unit};
}

std::string ShownKey(const MetricRow& row) { return WithUnit(row.name, ShownUnitOf(row).name); }

std::string ShownName(const MetricRow& row) {
  const std::string unit = ShownUnitOf(row).name;
  return unit.empty() ? row.title : std::string(row.title) + ", " + unit;
}

ScopedMetric::ScopedMetric(const MetricRow& row) { Rows().push_back(row); }
ScopedMetric::~ScopedMetric() { Rows().pop_back(); }

}  // namespace pickbed::eval
