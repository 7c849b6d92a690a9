#include "scenes/scenario/cell_errors.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>

#include "scenes/base/error.h"

namespace pickbed::scenes {
namespace {

// kMaxDeviate times the largest share must stay below 1, so that a factor is positive.
constexpr Range kMillimetres{0, 10000}, kDegrees{0, 45}, kPixels{0, 1000}, kPercent{0, 30};

struct CellErrorRow {
  const char* key;
  double CellErrorsSpec::*value;
  Range range;
  bool is_in_bin;  // a position error, which the size of the bin limits
  const char* help;
};

constexpr CellErrorRow kCellErrorRows[] = {
    {"hand_eye_mm", &CellErrorsSpec::hand_eye_mm, kMillimetres, true,
     "standard deviation of the hand-eye calibration: camera position, each axis, mm; per bin"},
    {"hand_eye_deg", &CellErrorsSpec::hand_eye_deg, kDegrees, false,
     "standard deviation of the hand-eye calibration: camera rotation, degrees; per bin"},
    {"focal_percent", &CellErrorsSpec::focal_percent, kPercent, false,
     "standard deviation of the calibrated focal length, percent; per bin"},
    {"principal_px", &CellErrorsSpec::principal_px, kPixels, false,
     "standard deviation of the calibrated principal point, each axis, px; per bin"},
    {"depth_bias_mm", &CellErrorsSpec::depth_bias_mm, kMillimetres, true,
     "standard deviation of an offset of all depth readings, mm; per bin"},
    {"depth_scale_percent", &CellErrorsSpec::depth_scale_percent, kPercent, false,
     "standard deviation of a scale error of all depth readings, percent; per bin"},
    {"bin_mm", &CellErrorsSpec::bin_mm, kMillimetres, true,
     "standard deviation of the assumed bin position, each axis, mm; per bin"},
    {"bin_deg", &CellErrorsSpec::bin_deg, kDegrees, false,
     "standard deviation of the assumed bin rotation, degrees; per bin"},
    {"repeatability_mm", &CellErrorsSpec::repeatability_mm, kMillimetres, true,
     "standard deviation of the executed grasp position, each axis, mm; per attempt"},
    {"force_percent", &CellErrorsSpec::force_percent, kPercent, false,
     "standard deviation of the gripper's force or vacuum, percent; per attempt"},
    {"friction_percent", &CellErrorsSpec::friction_percent, kPercent, false,
     "standard deviation of the friction of an instance, percent; per instance"},
    {"mass_percent", &CellErrorsSpec::mass_percent, kPercent, false,
     "standard deviation of the mass of an instance, percent; per instance"},
    {"size_percent", &CellErrorsSpec::size_percent, kPercent, false,
     "standard deviation of the size of the instances against CAD, percent; per bin and object"},
};

}  // namespace

void CellErrorsSpec::Visit(SettingsVisitor& v) {
  for (const CellErrorRow& row : kCellErrorRows) {
    v.Real(row.key, this->*row.value, row.range, row.help);
  }
}

bool CellErrorsSpec::off() const {
  return std::all_of(std::begin(kCellErrorRows), std::end(kCellErrorRows),
                     [this](const CellErrorRow& row) { return this->*row.value == 0; });
}

void CellErrorsSpec::Validate(const Eigen::Vector3d& bin_inner_size_m,
                              const std::function<std::string(const std::string& key)>& at) const {
  const double max_mm = 1e3 * bin_inner_size_m.head<2>().minCoeff();
  for (const CellErrorRow& row : kCellErrorRows) {
    CheckInput(!row.is_in_bin || this->*row.value <= max_mm,
               fmt::format("{} = {}: is larger than the bin, which is {:g} mm wide; lower it",
                           at(row.key), this->*row.value, max_mm));
  }
}

std::string CellErrorsInWords(const CellErrorsSpec& spec) {
  std::string words;
  for (const CellErrorRow& row : kCellErrorRows) {
    if (spec.*row.value == 0) continue;
    words += fmt::format("{}{} {:g}", words.empty() ? "" : ", ", row.key, spec.*row.value);
  }
  return words;
}

}  // namespace pickbed::scenes
