#include "perception/estimators/score_calibration.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "scenes/base/error.h"
#include "scenes/base/files.h"
#include "scenes/base/settings_tree.h"

namespace pickbed::perception {
namespace {

constexpr char kCalibrationFormat[] = "pickbed_calibration";
constexpr Range kAnyScore{-1e300, 1e300};
constexpr Range kAnyCount{0, 2e9};

void VisitCurve(const char* key, ScoreCurve& curve, const char* help, SettingsVisitor& v) {
  v.List(
      key, curve.knots.size(), [&](size_t size) { curve.knots.assign(size, {}); },
      [&](size_t i, SettingsVisitor& item) { curve.knots[i].Visit(item); }, help);
}

// Throws InputError if the probabilities fall or a score occurs twice.
void RequireRising(const std::string& file, const char* key, const ScoreCurve& curve) {
  for (size_t i = 1; i < curve.knots.size(); ++i) {
    const ScoreKnot &a = curve.knots[i - 1], &b = curve.knots[i];
    CheckInput(a.score < b.score,
               fmt::format("{}: {}: score {} comes after {}; scores must rise, so repeat pickbed "
                           "calibrate",
                           file, key, b.score, a.score));
    CheckInput(a.probability <= b.probability,
               fmt::format("{}: {}: the probability falls from {} to {} at score {}; it must not "
                           "fall, so repeat pickbed calibrate",
                           file, key, a.probability, b.probability, b.score));
  }
}

// Last parts of the paths in a command, since a program may be moved.
std::string FileNamesIn(const std::vector<std::string>& command) {
  std::vector<std::string> names;
  for (const std::string& word : command) {
    names.push_back(std::filesystem::path(word).filename().string());
  }
  return fmt::format("{}", fmt::join(names, " "));
}

}  // namespace

void ScoreKnot::Visit(SettingsVisitor& v) {
  v.Real("score", score, kAnyScore, "score of the estimator");
  v.Real("probability", probability, {0, 1}, "probability at this score");
}

double ScoreCurve::At(double score) const {
  const auto above =
      std::upper_bound(knots.begin(), knots.end(), score,
                       [](double s, const ScoreKnot& knot) { return s < knot.score; });
  if (above == knots.begin()) return knots.front().probability;
  if (above == knots.end()) return knots.back().probability;
  const ScoreKnot &a = *(above - 1), &b = *above;
  // Halves avoid an overflow of the difference of very large scores.
  const double share = (0.5 * score - 0.5 * a.score) / (0.5 * b.score - 0.5 * a.score);
  return a.probability + share * (b.probability - a.probability);
}

void ScoreCalibration::Visit(SettingsVisitor& v) {
  std::string format = kCalibrationFormat;
  int version = kVersion;
  v.Text("format", format, {kCalibrationFormat}, "kind of the file");
  v.Integer("version", version, {kVersion, kVersion}, "version of the format");
  v.Text("run", run, {}, "results folder on which the calibration was fitted");
  v.Group(
      "estimator",
      [this](SettingsVisitor& g) {
        g.Text("name", estimator, {}, "name of the estimator");
        g.Text("mode", mode, {}, "its search mode");
        g.Text("model", model, {}, "its trained model; empty = the shipped one");
        g.Words("command", command, "its program and arguments; only for estimator process");
        g.Text("scores", scores, {"probability", "raw"}, "kind of its scores");
        g.Real("min_score", min_score, {0, 1},
               "minimum score of a reported pose in that run; not used with raw scores");
      },
      "estimator for which the calibration holds");
  v.Integer("bins", bins, kAnyCount, "number of bins with a pose");
  v.Integer("poses", poses, kAnyCount, "number of reported poses");
  v.Integer("right", right, kAnyCount, "number of right poses among them");
  v.Integer("picks", picks, kAnyCount, "number of executed grasps");
  v.Integer("picked", picked, kAnyCount, "number of successful ones");
  VisitCurve("pose_right", pose_right,
             "probability that the pose is right, by score; linear between the scores, constant "
             "outside",
             v);
  VisitCurve("pick_succeeds", pick_succeeds,
             "probability that a pick at the pose succeeds, by score; empty = unknown", v);
  bool complete = true;
  v.Bool("complete", complete, "end of the file; a truncated file lacks it");
}

const ScoreCurve& ScoreCalibration::CurveFor(const EstimatorSpec& spec) const {
  const ScoreCurve& curve = spec.calibrated_to == "pick_succeeds" ? pick_succeeds : pose_right;
  CheckInput(!curve.empty(),
             fmt::format("{}: has no {}, because its run had too few picks or only one outcome; "
                         "set calibrated_to: pose_right, or calibrate on another run",
                         spec.calibration, spec.calibrated_to));
  return curve;
}

void ScoreCalibration::RequireFor(const EstimatorSpec& spec) const {
  const auto require = [&](const char* what, const std::string& here, const std::string& there) {
    CheckInput(
        here == there,
        fmt::format("{}: is for {} '{}', but the scenario has '{}'; run pickbed calibrate on "
                    "a run with this estimator",
                    spec.calibration, what, here, there));
  };
  require("estimator", estimator, spec.name);
  require("mode", mode, spec.mode);
  require("model", model, spec.model);
  // A program may be a child in one run and a server in another.
  if (command.empty() || spec.command.empty()) return;
  require("command", FileNamesIn(command), FileNamesIn(spec.command));
}

std::string WriteCalibration(ScoreCalibration calibration) {
  return "# Written by pickbed calibrate. estimator.calibration in a scenario names this file.\n" +
         WriteSettings([&](SettingsVisitor& v) { calibration.Visit(v); });
}

ScoreCalibration ReadCalibration(const std::filesystem::path& file) {
  const std::string name = file.string();
  const std::string truncated =
      name + ": is truncated, its last line 'complete: true' is missing; repeat pickbed calibrate";
  SettingsTree tree;
  const std::string text = ReadFileBytes(file);
  try {
    tree = ReadSettingsTreeText(text, name);
  } catch (const InputError& error) {
    const bool is_cut = text.find(kCalibrationFormat) != std::string::npos &&
                        text.find("\ncomplete: true") == std::string::npos;
    throw is_cut ? InputError(truncated) : error;
  }
  const SettingsTree* format = tree.Find("format");
  CheckInput(format != nullptr && format->text.find(kCalibrationFormat) != std::string::npos,
             fmt::format("{}: is no calibration file; make one with pickbed calibrate", name));
  const SettingsTree* version = tree.Find("version");
  CheckInput(
      version != nullptr && version->text == std::to_string(ScoreCalibration::kVersion),
      fmt::format("{}: has version {} of the format, but this pickbed reads {}; repeat "
                  "pickbed calibrate",
                  name, version == nullptr ? "none" : version->text, ScoreCalibration::kVersion));
  CheckInput(tree.Find("complete") != nullptr, truncated);
  ScoreCalibration calibration;
  ReadSettingsFile(file, [&](SettingsVisitor& v) { calibration.Visit(v); });
  CheckInput(!calibration.pose_right.empty(),
             fmt::format("{}: pose_right is empty; repeat pickbed calibrate", name));
  CheckInput(calibration.right <= calibration.poses && calibration.picked <= calibration.picks,
             fmt::format("{}: has {} right poses of {} and {} successful picks of {}; repeat "
                         "pickbed calibrate",
                         name, calibration.right, calibration.poses, calibration.picked,
                         calibration.picks));
  RequireRising(name, "pose_right", calibration.pose_right);
  RequireRising(name, "pick_succeeds", calibration.pick_succeeds);
  return calibration;
}

ScoreCalibration CalibrationFor(const EstimatorSpec& spec) {
  ScoreCalibration calibration = ReadCalibration(spec.calibration);
  calibration.RequireFor(spec);
  calibration.CurveFor(spec);
  return calibration;
}

}  // namespace pickbed::perception
