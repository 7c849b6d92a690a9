#include "sim/sensor/sensor_profile.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <string_view>
#include <utility>

#include "scenes/base/error.h"
#include "scenes/objects/object_catalog.h"

namespace pickbed::sim {
namespace {

namespace fs = std::filesystem;

constexpr double kRightAngle_rad = std::numbers::pi / 2;

fs::path ProfilePath(const std::string& name_or_path) {
  if (fs::path(name_or_path).extension() == ".yaml") return name_or_path;
  const std::vector<std::string> names = SensorProfileNames();
  CheckInput(std::find(names.begin(), names.end(), name_or_path) != names.end(),
             UnknownNameMessage("sensor", name_or_path, names));
  return AssetsDir() / "sensors" / (name_or_path + ".yaml");
}

// Returns a / (pi/2 - a) of slant a.
double SlantRatio(double slant_rad) {
  const double a = std::min(slant_rad, kSteepestSlant_rad);
  return a / (kRightAngle_rad - a);
}

double FrontalSigma_m(const SensorProfile& p, double z_m) {
  return p.axial_floor_m + (p.axial_linear_m + p.axial_sigma_m * z_m) * z_m;
}

// Returns the depth within the range at which a frontal surface has the least noise.
double MinNoiseDepth_m(const SensorProfile& p) {
  if (p.axial_sigma_m == 0) return p.axial_linear_m < 0 ? p.max_range_m : p.min_range_m;
  return std::clamp(-p.axial_linear_m / (2 * p.axial_sigma_m), p.min_range_m, p.max_range_m);
}

void CheckProfile(const SensorProfile& p, const std::string& file) {
  CheckInput(p.min_range_m < p.max_range_m,
             fmt::format("{}: min_range_m {} must be less than max_range_m {}", file, p.min_range_m,
                         p.max_range_m));
  const double z_m = MinNoiseDepth_m(p);
  CheckInput(FrontalSigma_m(p, z_m) >= 0,
             fmt::format("{}: axial_linear_m {} makes the noise at {:.3g} m negative; raise it or "
                         "axial_floor_m",
                         file, p.axial_linear_m, z_m));
  CheckInput(
      2 * p.axial_slant_power == std::round(2 * p.axial_slant_power),
      fmt::format("{}: axial_slant_power {} must be a multiple of 0.5", file, p.axial_slant_power));
  CheckInput(p.disparity_step_px == 0 || TriangulationBaseline_m(p) > 0,
             fmt::format("{}: disparity_step_px {} needs baseline_m, which is {}", file,
                         p.disparity_step_px, p.baseline_m == 0 ? "0" : "the same as sensor_x_m"));
  for (const auto& [key, focal_px] : {std::pair{"lateral_focal_px", p.lateral_focal_px},
                                      std::pair{"disparity_focal_px", p.disparity_focal_px}}) {
    CheckInput(
        focal_px == 0 || focal_px >= 1,
        fmt::format("{}: {} {} must be at least 1, or 0 for the focal length of the depth image",
                    file, key, focal_px));
  }
  CheckInput(p.dark_luma < p.shiny_luma,
             fmt::format("{}: dark_luma {} must be less than shiny_luma {}", file, p.dark_luma,
                         p.shiny_luma));
}

// Every data sheet has range and step of the readings, and the step is last in the files of
// pickbed. So a file that is cut at the end of a line lacks it, and is not taken for a sensor
// without steps.
void CheckKeys(const KeyPlaces& given, const std::string& file) {
  CheckInput(given.contains("name"),
             fmt::format("{}: name is missing, which every sensor needs; is the file complete? Add "
                         "the key",
                         file));
  for (const char* key : {"min_range_m", "max_range_m", "quantization_m"}) {
    CheckInput(given.contains(key),
               fmt::format("{}: {} is missing, which every sensor needs; is the file complete? Add "
                           "the key, with {} if the sensor has no such limit",
                           file, key, key == std::string_view("max_range_m") ? 100 : 0));
  }
}

}  // namespace

void SensorProfile::Visit(SettingsVisitor& v) {
  v.Text("name", name, {}, "name of the profile");
  v.Real("min_range_m", min_range_m, {0, 100}, "distance of the nearest reading, m");
  v.Real("max_range_m", max_range_m, {0, 100}, "distance of the farthest reading, m");
  v.Real("axial_floor_m", axial_floor_m, {0, 0.1},
         "standard deviation of depth noise at any distance, m");
  v.Real("axial_linear_m", axial_linear_m, {-0.1, 0.1},
         "standard deviation of depth noise at 1 m, m; grows with z");
  v.Real("axial_sigma_m", axial_sigma_m, {0, 0.1},
         "standard deviation of depth noise at 1 m, m; grows with z^2");
  v.Real("axial_slant_m", axial_slant_m, {0, 0.1},
         "standard deviation of depth noise at 1 m by slant a, m; grows with a^2 / (pi/2 - a)^2");
  v.Real("axial_slant_power", axial_slant_power, {-1, 3},
         "power of z with which axial_slant_m grows, a multiple of 0.5");
  v.Real("lateral_sigma_px", lateral_sigma_px, {0, 10},
         "standard deviation of a pixel's lateral jitter, px");
  v.Real("lateral_slant_px", lateral_slant_px, {0, 1},
         "standard deviation of lateral jitter by slant a, px; grows with a / (pi/2 - a)");
  v.Real("correlation_px", correlation_px, {0, 100},
         "distance at which errors have correlation 0.285, px; errors and dropout are independent "
         "from twice this distance on, and all are up to one pixel of the depth image");
  v.Real("lateral_focal_px", lateral_focal_px, {0, 1e5},
         "focal length of the images in which lateral jitter, correlation_px and window_px are "
         "measured, px; 0 = the depth image's");
  v.Real("edge_step_m", edge_step_m, {1e-4, 10},
         "minimum depth step to a neighboring pixel at an edge, m");
  v.Real("edge_dropout", edge_dropout, {0, 1}, "probability of no reading at an edge");
  v.Real("window_px", window_px, {0, 100},
         "width of the matching windows, px; edge dropout falls to 0 at half of it; 0 = only the "
         "edge's own pixels");
  v.Real("random_dropout", random_dropout, {0, 1}, "probability of no reading anywhere");
  v.Real("grazing_dropout", grazing_dropout, {0, 1},
         "probability of no reading at 90 degrees slant");
  v.Real("grazing_start_rad", grazing_start_rad, {0, 1.5},
         "slant above which grazing dropout begins, rad");
  v.Real("dark_dropout", dark_dropout, {0, 1}, "probability of no reading on black surfaces");
  v.Real("dark_luma", dark_luma, {0.001, 1}, "luma, 0 to 1, below which dark dropout begins");
  v.Real("shiny_dropout", shiny_dropout, {0, 1}, "probability of no reading on white surfaces");
  v.Real("shiny_luma", shiny_luma, {0, 0.999}, "luma, 0 to 1, above which shiny dropout begins");
  v.Real("flying_share", flying_share, {0, 1},
         "share of edge pixels whose reading is between both surfaces");
  v.Real("baseline_m", baseline_m, {-1, 1},
         "position of the projector or second camera along camera x, m; points that it cannot see "
         "have no reading; 0 = none");
  v.Real("sensor_x_m", sensor_x_m, {-1, 1},
         "position of the sensor's own camera along camera x, m; points that it cannot see have no "
         "reading; not 0 if depth is registered to another image");
  v.Real("disparity_step_px", disparity_step_px, {0, 10}, "step of the disparity, px; 0 = none");
  v.Real("disparity_focal_px", disparity_focal_px, {0, 1e5},
         "focal length of the sensor's own images, px; 0 = the depth image's");
  v.Real("quantization_m", quantization_m, {0, 0.1}, "step of the reading, m; 0 = none");
}

double AxialSigma_m(const SensorProfile& p, double z_m, double slant_rad) {
  const double ratio = SlantRatio(slant_rad);
  return FrontalSigma_m(p, z_m) +
         p.axial_slant_m * std::pow(z_m, p.axial_slant_power) * ratio * ratio;
}

double LateralSigma_px(const SensorProfile& p, double slant_rad, double image_focal_px) {
  return LateralScale(p, image_focal_px) *
         (p.lateral_sigma_px + p.lateral_slant_px * SlantRatio(slant_rad));
}

double ErrorSpacing_px(const SensorProfile& p, double image_focal_px) {
  const double spacing_px = LateralScale(p, image_focal_px) * p.correlation_px;
  return spacing_px > 1 ? spacing_px : 0;
}

double WindowWidth_px(const SensorProfile& p, double image_focal_px) {
  return std::min(LateralScale(p, image_focal_px) * p.window_px, kWidestWindow_px);
}

double LateralScale(const SensorProfile& p, double image_focal_px) {
  return p.lateral_focal_px > 0 ? image_focal_px / p.lateral_focal_px : 1;
}

double TriangulationBaseline_m(const SensorProfile& p) {
  return std::abs(p.baseline_m - p.sensor_x_m);
}

double ReadingStep_m(const SensorProfile& p, double z_m, double image_focal_px) {
  if (p.disparity_step_px == 0) return p.quantization_m;
  const double focal_px = p.disparity_focal_px > 0 ? p.disparity_focal_px : image_focal_px;
  const double step_m = z_m * z_m * p.disparity_step_px / (focal_px * TriangulationBaseline_m(p));
  return std::max(step_m, p.quantization_m);
}

void RequireInRange(const SensorProfile& p, double floor_m) {
  CheckInput(floor_m > p.min_range_m && floor_m < p.max_range_m,
             fmt::format("{} reads from {} to {} m, but the bin's floor is {:.3f} m in front of "
                         "the camera; move the camera (camera.eye_m) or use another sensor",
                         p.name, p.min_range_m, p.max_range_m, floor_m));
}

bool ChangesNothing(const SensorProfile& p) {
  const SensorProfile none;
  return p.min_range_m == 0 && p.max_range_m >= none.max_range_m && p.axial_floor_m == 0 &&
         p.axial_linear_m == 0 && p.axial_sigma_m == 0 && p.axial_slant_m == 0 &&
         p.lateral_sigma_px == 0 && p.lateral_slant_px == 0 && p.edge_dropout == 0 &&
         p.random_dropout == 0 && p.grazing_dropout == 0 && p.dark_dropout == 0 &&
         p.shiny_dropout == 0 && p.flying_share == 0 && p.baseline_m == 0 && p.sensor_x_m == 0 &&
         p.disparity_step_px == 0 && p.quantization_m == 0;
}

std::vector<std::string> SensorProfileNames() {
  std::vector<std::string> names;
  for (const auto& entry : fs::directory_iterator(AssetsDir() / "sensors")) {
    if (entry.path().extension() == ".yaml") names.push_back(entry.path().stem().string());
  }
  std::sort(names.begin(), names.end());
  return names;
}

SensorProfile LoadSensorProfile(const std::string& name_or_path) {
  const fs::path path = ProfilePath(name_or_path);
  SensorProfile profile;
  const KeyPlaces given = ReadSettingsFile(path, [&](SettingsVisitor& v) { profile.Visit(v); });
  CheckProfile(profile, path.string());
  CheckKeys(given, path.string());
  return profile;
}

}  // namespace pickbed::sim
