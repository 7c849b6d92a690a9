#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <numbers>

#include "eval/cli/arguments.h"
#include "eval/cli/commands.h"
#include "eval/draw/overlay.h"
#include "eval/draw/plot.h"
#include "eval/stats/statistics.h"
#include "scenes/base/files.h"
#include "scenes/base/math.h"
#include "scenes/image/image_io.h"
#include "sim/sensor/depth_noise.h"
#include "sim/sensor/test_bench.h"

namespace pickbed::eval {
namespace {

constexpr int kTileWidth = 480, kTileHeight = 360;
constexpr double kErrorScale = 4;  // limit of the error map, in sigmas of the wall
constexpr Rgb8 kMeasured{200, 40, 40}, kFormula{30, 90, 180}, kAxial{150, 170, 200};

Image<Rgb8> NoiseChart(const std::vector<NoiseSample>& samples, const char* x_label,
                       double x_scale) {
  ChartSeries measured{"measured", {}, kMeasured, true};
  ChartSeries formula{"sigma + jitter on the slope + steps", {}, kFormula};
  ChartSeries axial{"sigma of the profile", {}, kAxial};
  for (const NoiseSample& s : samples) {
    if (s.lost_share < 0.9) measured.points.emplace_back(x_scale * s.at, 1e3 * s.measured_m);
    formula.points.emplace_back(x_scale * s.at, 1e3 * s.formula_m);
    axial.points.emplace_back(x_scale * s.at, 1e3 * s.axial_m);
  }
  return DrawChart({x_label, "mm", {axial, formula, measured}}, kTileWidth, kTileHeight, 0.1);
}

Image<Rgb8> FailureChart(const std::vector<NoiseSample>& samples) {
  ChartSeries measured{"measured", {}, kMeasured, true}, formula{"by the profile", {}, kFormula};
  for (const NoiseSample& s : samples) {
    const double degrees = Degrees(s.at);
    measured.points.emplace_back(degrees, 100 * s.lost_share);
    formula.points.emplace_back(degrees, 100 * s.lost_formula_share);
  }
  return DrawChart({"slant, degrees", "%", {formula, measured}}, kTileWidth, kTileHeight, 1);
}

std::vector<std::string> KeyNumbers(const SensorProfile& p, const SensorScene& scene,
                                    const Image<float>& seen_m) {
  const auto mm = [](double m) { return fmt::format("{:.2f} mm", 1e3 * m); };
  const double focal_px = scene.camera.fx(), steep = std::numbers::pi / 3;
  // A projector or camera away from the depth image (offset not 0) causes a shadow on one side of
  // an object.
  std::vector<std::string> shades_px;
  for (const double x_m : {p.baseline_m, p.sensor_x_m}) {
    if (x_m == 0 && !shades_px.empty()) continue;
    shades_px.push_back(fmt::format("{:.1f}", std::abs(x_m) * focal_px * (1 / 0.8 - 1)));
  }
  const auto holes = std::count(seen_m.pixels().begin(), seen_m.pixels().end(), 0.0f);
  return {
      fmt::format("profile\t{}", p.name),
      fmt::format("range\t{:g} to {:g} m", p.min_range_m, p.max_range_m),
      fmt::format("sigma, 0.5 / 1 / 2 m\t{:.2f} / {:.2f} / {}", 1e3 * AxialSigma_m(p, 0.5, 0),
                  1e3 * AxialSigma_m(p, 1, 0), mm(AxialSigma_m(p, 2, 0))),
      fmt::format("at 1 m and 60 deg\t{}", mm(AxialSigma_m(p, 1, steep))),
      fmt::format("lateral jitter\t{:.2f} px, {:.2f} px at 60 deg", LateralSigma_px(p, 0, focal_px),
                  LateralSigma_px(p, steep, focal_px)),
      fmt::format("steps at 1 m\t{} ({:.4g} px of disparity)", mm(ReadingStep_m(p, 1, focal_px)),
                  p.disparity_step_px),
      fmt::format("correlated within\t{:.1f} px; windows {:.1f} px",
                  2 * ErrorSpacing_px(p, focal_px), WindowWidth_px(p, focal_px)),
      fmt::format("baseline\t{:g} mm: a step from 1 to 0.8 m", 1e3 * TriangulationBaseline_m(p)),
      fmt::format("\tshadow of {} px here", fmt::join(shades_px, " and ")),
      fmt::format("missing anywhere\t{}", PercentText(p.random_dropout)),
      fmt::format("missing at edges\t{}, flying {} of the rest", WholePercentText(p.edge_dropout),
                  WholePercentText(p.flying_share)),
      fmt::format("missing by slant\t{} at 90 deg, none to {:.0f} deg",
                  WholePercentText(p.grazing_dropout), Degrees(p.grazing_start_rad)),
      fmt::format("missing on black\t{}, none over luma {:g}", WholePercentText(p.dark_dropout),
                  p.dark_luma),
      fmt::format("missing on white\t{}, none under luma {:g}", WholePercentText(p.shiny_dropout),
                  p.shiny_luma),
      fmt::format("missing in this scene\t{}",
                  PercentText(static_cast<int>(holes), static_cast<int>(seen_m.size()))),
  };
}

Image<Rgb8> DrawSensorSheet(const SensorProfile& p) {
  const double distance_m = TrialDistance_m(p);
  const SensorScene scene = MakeSensorScene(distance_m);
  Rng rng(1);
  const Image<float> seen_m = ApplySensorNoise({scene.depth_m, scene.camera, &scene.color}, p, rng);
  const double full_m =
      kErrorScale * std::max({AxialSigma_m(p, distance_m, 0),
                              ReadingStep_m(p, distance_m, scene.camera.fx()) / 2, 1e-4});
  const std::vector<NoiseSample> by_slant = NoiseBySlant(p, distance_m);
  return ContactSheet(
      {scene.color, ColorizeDepth(scene.depth_m), ColorizeDepth(seen_m),
       DrawDepthError(scene.depth_m, seen_m, full_m),
       NoiseChart(NoiseByDistance(p), "distance, m", 1),
       NoiseChart(by_slant, "slant, degrees", kDegreesPerRadian), FailureChart(by_slant),
       DrawTable(KeyNumbers(p, scene, seen_m), kTileWidth, kTileHeight)},
      {fmt::format("Scene: wall at {:.2g} m; boards at 30, 50, 70, 80 degrees", distance_m),
       "Ideal depth (near is warm)", "Depth as measured by the sensor (black: none)",
       fmt::format("Error: blue nearer, red farther, full at {:.1f} mm", 1e3 * full_m),
       "Noise against distance, surface facing the camera",
       fmt::format("Noise against slant at {:.2g} m", distance_m), "Missing readings against slant",
       "Key numbers"},
      4);
}

}  // namespace

int SensorCommand(int argc, char** argv) {
  CLI::App app(
      "`sensor show` draws the behaviour of a depth sensor profile: a test scene as ideal and as "
      "measured depth, the errors, and the measured noise and missing readings next to the "
      "formulas of the profile.",
      "pickbed sensor");
  std::string action, sensor, out;
  app.add_option("ACTION", action, "show")->required()->check(CLI::IsMember({"show"}));
  app.add_option("SENSOR", sensor, "name of a sensor (see pickbed list sensors), or a .yaml file")
      ->required();
  app.add_option("--out", out, "file name of the picture [results/sensor_NAME.png]");
  app.footer("Example: pickbed sensor show active_stereo --out active_stereo.png");
  if (!ParseArguments(app, argc, argv)) return 0;

  const SensorProfile profile = LoadSensorProfile(sensor);
  const std::filesystem::path path =
      out.empty() ? std::filesystem::path("results") /
                        fmt::format("sensor_{}.png", std::filesystem::path(sensor).stem().string())
                  : std::filesystem::path(out);
  if (path.has_parent_path()) MakeFolder(path.parent_path());
  WritePng(path, DrawSensorSheet(profile));
  fmt::print("{} in {}\n", profile.name, path.string());
  return 0;
}

}  // namespace pickbed::eval
