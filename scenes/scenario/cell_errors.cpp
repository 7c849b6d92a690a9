#include "scenes/scenario/cell_errors.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>

#include "scenes/base/error.h"
#include "scenes/base/math.h"

namespace pickbed::scenes {
namespace {

// kMaxDeviate times the largest share must stay below 1, so that a factor is positive.
constexpr Range kMillimetres{0, 10000}, kDegrees{0, 45}, kPixels{0, 1000}, kPercent{0, 30};

// How far one unit of an error displaces what the cell sees or grasps. The bin limits it.
enum class Displaces {
  kNothing,
  kMillimetre,    // by the value
  kAtDistance,    // degrees: by their sine times the distance of the camera
  kShareOfDepth,  // percent: by this share of the distance
  kPixel,         // by a pixel at this distance
};

struct CellErrorRow {
  const char* key;
  double CellErrorsSpec::*value;
  Range range;
  Displaces displaces;
  const char* help;
};

constexpr CellErrorRow kCellErrorRows[] = {
    {"hand_eye_mm", &CellErrorsSpec::hand_eye_mm, kMillimetres, Displaces::kMillimetre,
     "standard deviation of the hand-eye calibration: camera position, each axis, mm; per bin"},
    {"hand_eye_deg", &CellErrorsSpec::hand_eye_deg, kDegrees, Displaces::kAtDistance,
     "standard deviation of the hand-eye calibration: camera rotation, degrees; per bin"},
    {"focal_percent", &CellErrorsSpec::focal_percent, kPercent, Displaces::kNothing,
     "standard deviation of the calibrated focal length, percent; per bin"},
    {"principal_px", &CellErrorsSpec::principal_px, kPixels, Displaces::kPixel,
     "standard deviation of the calibrated principal point, each axis, px; per bin"},
    {"depth_bias_mm", &CellErrorsSpec::depth_bias_mm, kMillimetres, Displaces::kMillimetre,
     "standard deviation of an offset of all depth readings, mm; per bin"},
    {"depth_scale_percent", &CellErrorsSpec::depth_scale_percent, kPercent,
     Displaces::kShareOfDepth,
     "standard deviation of a scale error of all depth readings, percent; per bin"},
    {"bin_mm", &CellErrorsSpec::bin_mm, kMillimetres, Displaces::kMillimetre,
     "standard deviation of the assumed bin position, each axis, mm; per bin"},
    {"bin_deg", &CellErrorsSpec::bin_deg, kDegrees, Displaces::kNothing,
     "standard deviation of the assumed bin rotation, degrees; per bin"},
    {"repeatability_mm", &CellErrorsSpec::repeatability_mm, kMillimetres, Displaces::kMillimetre,
     "standard deviation of the executed grasp position, each axis, mm; per attempt"},
    {"force_percent", &CellErrorsSpec::force_percent, kPercent, Displaces::kNothing,
     "standard deviation of the gripper's force or vacuum, percent; per attempt"},
    {"friction_percent", &CellErrorsSpec::friction_percent, kPercent, Displaces::kNothing,
     "standard deviation of the friction of an instance, percent; per instance"},
    {"mass_percent", &CellErrorsSpec::mass_percent, kPercent, Displaces::kNothing,
     "standard deviation of the mass of an instance, percent; per instance"},
    {"size_percent", &CellErrorsSpec::size_percent, kPercent, Displaces::kNothing,
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

void CellErrorsSpec::Validate(const Eigen::Vector3d& bin_inner_size_m, double distance_m,
                              double focal_px,
                              const std::function<std::string(const std::string& key)>& at) const {
  const double distance_mm = 1e3 * distance_m;
  const double max_mm = 1e3 * bin_inner_size_m.head<2>().minCoeff();
  for (const CellErrorRow& row : kCellErrorRows) {
    const double value = this->*row.value;
    double moved_mm = 0;
    switch (row.displaces) {
      case Displaces::kNothing:
        break;
      case Displaces::kMillimetre:
        moved_mm = value;
        break;
      case Displaces::kAtDistance:
        moved_mm = distance_mm * std::sin(Radians(value));
        break;
      case Displaces::kShareOfDepth:
        moved_mm = distance_mm * value / 100;
        break;
      case Displaces::kPixel:
        moved_mm = distance_mm * value / focal_px;
        break;
    }
    CheckInput(moved_mm <= max_mm,
               row.displaces == Displaces::kMillimetre
                   ? fmt::format("{} = {}: is larger than the bin, which is {:g} mm wide; lower it",
                                 at(row.key), value, max_mm)
                   : fmt::format("{} = {}: displaces what the camera sees by {:.0f} mm, which is "
                                 "more than the bin's width of {:g} mm; lower it",
                                 at(row.key), value, moved_mm, max_mm));
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
