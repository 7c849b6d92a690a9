#include "eval/tolerance/samples.h"

#include <fmt/format.h>

#include <cmath>

#include "scenes/base/error.h"
#include "scenes/base/math.h"

namespace pickbed::eval {
namespace {

constexpr double kMm = 1e-3, kDegree = kRadiansPerDegree;

constexpr std::array<ErrorAxis, 12> kAxes{{
    {"x", "along", "mm", false, 0, kMm},
    {"y", "along", "mm", false, 1, kMm},
    {"z", "along", "mm", false, 2, kMm},
    {"rx", "about", "deg", false, 3, kDegree},
    {"ry", "about", "deg", false, 4, kDegree},
    {"rz", "about", "deg", false, 5, kDegree},
    {"gx", "along", "mm", true, 0, kMm},
    {"gy", "along", "mm", true, 1, kMm},
    {"gz", "along", "mm", true, 2, kMm},
    {"grx", "about", "deg", true, 3, kDegree},
    {"gry", "about", "deg", true, 4, kDegree},
    {"grz", "about", "deg", true, 5, kDegree},
}};

// Pose error with the rotation about a point of O instead of the origin.
Pose TurnedAbout(const Eigen::Vector3d& point_O, const PoseOffset& error) {
  const Pose X = ToPose(error);
  return MakePose(X.linear(), point_O - X.linear() * point_O + X.translation());
}

class Planner {
 public:
  explicit Planner(ToleranceStudy& study) : study_(study), options_(study.options) {}

  void AddAxes() {
    for (int axis = 0; axis < static_cast<int>(kAxes.size()); ++axis) {
      for (int level = -options_.steps; level <= options_.steps; ++level) {
        // Without an error all axes are the same.
        if (level == 0 && axis > 0) continue;
        for (int grasp = 0; grasp < options_.grasps; ++grasp) {
          Add(SampleKind::kAxis, {axis, -1}, {level, 0}, grasp);
        }
      }
    }
  }

  void AddPairs() {
    const int grasps = std::min(options_.pair_grasps, options_.grasps);
    const int side = options_.steps / options_.pair_stride;
    for (const auto& pair : options_.pairs) {
      for (int a = -side; a <= side; ++a) {
        for (int b = -side; b <= side; ++b) {
          for (int grasp = 0; grasp < grasps; ++grasp) {
            // The grasps of the map are in the order of the resting poses, so the subset is spread
            // over them.
            const int spread = grasp * options_.grasps / grasps;
            Add(SampleKind::kPair, pair, {a * options_.pair_stride, b * options_.pair_stride},
                spread);
          }
        }
      }
    }
  }

  // Adds errors in random directions of the six axes, with length uniform up to the limit.
  void AddRandom(SampleKind kind, int count, int first_grasp, int grasps, std::string_view stream) {
    Rng rng = Rng::Derive(options_.seed, 0, stream);
    for (int i = 0; i < count; ++i) {
      PoseOffset direction;
      for (int k = 0; k < 6; ++k) direction[k] = rng.Normal();
      const double steps = rng.Uniform(0, options_.random_steps) / direction.norm();
      PoseOffset error;
      error << steps * options_.step_mm * kMm * direction.head<3>(),
          steps * options_.step_deg * kDegree * direction.tail<3>();
      PlannedSample sample;
      sample.kind = kind;
      sample.grasp = first_grasp + i % grasps;
      sample.X_OE = TurnedAbout(study_.model.surface_mean_O, error);
      study_.samples.push_back(sample);
    }
  }

 private:
  void Add(SampleKind kind, std::array<int, 2> axis, std::array<int, 2> level, int grasp) {
    PlannedSample sample{kind, axis, level, grasp, Pose::Identity()};
    PoseOffset error = PoseOffset::Zero();
    for (int i = 0; i < 2; ++i) {
      if (axis[i] < 0) continue;
      const ErrorAxis& row = kAxes[axis[i]];
      const double step = row.coordinate < 3 ? options_.step_mm : options_.step_deg;
      error[row.coordinate] = level[i] * step * row.per_unit_si;
    }
    const Pose& X_OG = study_.grasps[grasp].candidate.X_OG;
    sample.X_OE = kAxes[axis[0]].of_grasp ? X_OG * ToPose(error) * X_OG.inverse()
                                          : TurnedAbout(study_.model.surface_mean_O, error);
    study_.samples.push_back(sample);
  }

  ToleranceStudy& study_;
  const ToleranceOptions& options_;
};

}  // namespace

std::span<const ErrorAxis> ErrorAxisTable() { return kAxes; }

std::string AxisHelp(const ErrorAxis& axis, const Gripper& gripper) {
  const int xyz = axis.coordinate % 3;
  if (axis.of_grasp) return fmt::format("{} {}", axis.way, gripper.axes_G()[xyz]);
  return fmt::format("{} {} of the object", axis.way, std::array{"x", "y", "z"}[xyz]);
}

int ErrorAxisNamed(const std::string& name) {
  std::vector<std::string> names;
  for (size_t i = 0; i < kAxes.size(); ++i) {
    if (name == kAxes[i].name) return static_cast<int>(i);
    names.push_back(kAxes[i].name);
  }
  throw InputError(UnknownNameMessage("error axis", name, names));
}

const char* SampleKindName(SampleKind kind) {
  constexpr const char* kNames[] = {"axis", "pair", "fit", "test"};
  return kNames[static_cast<int>(kind)];
}

void ToleranceOptions::Visit(SettingsVisitor& v) {
  v.Integer("grasps", grasps, {1, 100000}, "number of grasps that are executed with each error");
  v.Real("step_mm", step_mm, {0.01, 100}, "step of the translation errors along an axis, mm");
  v.Real("step_deg", step_deg, {0.01, 60}, "step of the rotation errors about an axis, deg");
  v.Integer("steps", steps, {1, 100}, "number of steps to each side of zero error");
  v.Integer("pair_grasps", pair_grasps, {1, 100000},
            "number of grasps that are executed with each error of an axis pair");
  v.Integer("pair_stride", pair_stride, {1, 100},
            "number of steps between the errors of an axis pair");
  v.Integer("fit_grasps", fit_grasps, {1, 100000}, "number of grasps that the model is fitted to");
  v.RenamedKey("fit_tries", "fit_samples");
  v.Integer("fit_samples", fit_samples, {0, 10000000},
            "number of random errors that the model is fitted to");
  v.RenamedKey("test_tries", "test_samples");
  v.Integer("test_samples", test_samples, {0, 10000000},
            "number of random errors that the predictors are tested on");
  v.Real("random_steps", random_steps, {0.1, 1000}, "largest length of a random error, steps");
  v.Real("keep_share", keep_share, {0.01, 1},
         "share of the success rate without error that a region must keep");
  v.Seed("seed", seed, "random seed of grasps and random errors");
  v.Group(
      "table", [&](SettingsVisitor& g) { table.Visit(g); }, "table that the object is on");
  v.Group(
      "execute", [&](SettingsVisitor& g) { execute.Visit(g); }, "execution of each grasp");
  v.Group(
      "fit", [&](SettingsVisitor& g) { fit.Visit(g); }, "fit of the model");
}

ToleranceOptions QuickOptions() {
  ToleranceOptions options;
  const double coarser = 2.5;
  options.step_mm *= coarser;
  options.step_deg *= coarser;
  options.steps = static_cast<int>(options.steps / coarser);
  options.random_steps /= coarser;
  options.pair_stride = 1;
  options.grasps = 6;
  options.pair_grasps = 6;
  options.fit_grasps = 60;
  options.fit_samples = 300;
  options.test_samples = 200;
  return options;
}

ToleranceStudy PlanStudy(std::shared_ptr<const ObjectModel> object,
                         std::shared_ptr<const Gripper> gripper,
                         std::vector<GraspCandidate> candidates, const ToleranceOptions& options) {
  CheckSettings("ToleranceOptions", options);
  ToleranceStudy study;
  study.options = options;
  study.table = MakeTable(object, gripper, std::move(candidates), options.table);
  // Each kind draws its own grasps. The planner selects few of the candidates, so the same grasp
  // may be drawn several times, also in different kinds. The test evaluates errors that the model
  // has not seen, not new grasps.
  const auto draw = [&](int count, std::string_view stream) {
    Rng rng = Rng::Derive(options.seed, 0, stream);
    const auto drawn = DrawTableGrasps(study.table, count, rng, options.table);
    study.grasps.insert(study.grasps.end(), drawn.begin(), drawn.end());
    return static_cast<int>(drawn.size());
  };
  const int of_map = study.options.grasps = draw(options.grasps, "tolerance grasps");
  const int of_fit = draw(options.fit_grasps, "tolerance fit grasps");
  const int of_test = draw(options.test_samples, "tolerance test grasps");
  CheckInput(of_map > 0 && of_fit > 0 && (of_test > 0 || options.test_samples == 0),
             fmt::format("{}: no grasp with {} was found in table.max_draws = {} draws; raise it, "
                         "or lower table.min_choice",
                         object->name, gripper->name, options.table.max_draws));

  std::vector<Pose> X_OG;
  for (int i = of_map; i < of_map + of_fit; ++i) X_OG.push_back(study.grasps[i].candidate.X_OG);
  study.model = EmptyToleranceModel(*object, gripper->name, X_OG, options.fit);
  Planner planner(study);
  planner.AddAxes();
  planner.AddPairs();
  planner.AddRandom(SampleKind::kFit, options.fit_samples, of_map, of_fit, "tolerance fit errors");
  planner.AddRandom(SampleKind::kTest, of_test, of_map + of_fit, of_test, "tolerance test errors");
  return study;
}

PoseOffset ErrorInG(const ToleranceStudy& study, const PlannedSample& sample) {
  const Pose& X_OG = study.grasps[sample.grasp].candidate.X_OG;
  return ToPoseOffset(X_OG.inverse() * NearestError(study.model, sample.X_OE) * X_OG);
}

}  // namespace pickbed::eval
