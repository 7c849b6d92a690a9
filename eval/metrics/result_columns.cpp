#include "eval/metrics/result_columns.h"

#include <algorithm>
#include <array>
#include <string_view>

namespace pickbed::eval {
namespace {

struct NamedUnit {
  std::string_view suffix, unit;
};
// Longer suffixes first.
constexpr std::array<NamedUnit, 21> kUnits{{
    {"_diameters", "diameters"},
    {"_seconds", "s"},
    {"_kgpm3", "kg/m3"},
    {"_radps", "rad/s"},
    {"_kgm2", "kg m2"},
    {"_npm", "N/m"},
    {"_mps", "m/s"},
    {"_mib", "MiB"},
    {"_deg", "deg"},
    {"_rad", "rad"},
    {"_pm", "1/m"},
    {"_nm", "N m"},
    {"_mm", "mm"},
    {"_px", "px"},
    {"_kg", "kg"},
    {"_m3", "m3"},
    {"_m", "m"},
    {"_s", "s"},
    {"_n", "N"},
    {"_j", "J"},
    {"_pa", "Pa"},
}};

}  // namespace

std::string UnitInName(const std::string& name) {
  if (name == "seconds") return "s";
  const auto unit = std::find_if(kUnits.begin(), kUnits.end(), [&](const NamedUnit& known) {
    return name.ends_with(known.suffix);
  });
  return unit == kUnits.end() ? "" : std::string(unit->unit);
}

std::string UnitOf(const ResultColumn& column) {
  return column.unit.empty() ? UnitInName(column.name) : column.unit;
}

std::string HeaderLine(const ResultColumns& columns) {
  std::string line;
  for (const ResultColumn& column : columns) line += (line.empty() ? "" : ",") + column.name;
  return line + "\n";
}

void AddColumns(const ResultColumns& more, ResultColumns& columns) {
  columns.insert(columns.end(), more.begin(), more.end());
}

}  // namespace pickbed::eval
