#include "grasp/completed/completed_planner.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>

#include "grasp/candidates/jaw_wrenches.h"
#include "grasp/cloud/cloud_antipodal.h"
#include "grasp/cloud/cloud_suction.h"
#include "grasp/completed/success_network.h"
#include "grasp/grippers/parallel_jaw.h"
#include "grasp/grippers/suction_cup.h"
#include "scenes/base/error.h"
#include "scenes/base/math.h"
#include "scenes/base/random.h"
#include "scenes/camera/depth_points.h"

namespace pickbed::grasp {

namespace {

using Eigen::Vector3d;

// Returns the pad friction of the jaws. Other grippers ignore the friction of an object.
double PadFriction(const std::vector<std::shared_ptr<const Gripper>>& tools) {
  for (const auto& tool : tools) {
    if (const auto* jaw = dynamic_cast<const ParallelJaw*>(tool.get()))
      return jaw->hand.pad_friction;
  }
  return 1;
}

bool IsSuction(const Gripper& tool) { return dynamic_cast<const SuctionCup*>(&tool) != nullptr; }

// Returns the grasp candidates of an object whose frame O has the axes of the bin. Only approaches
// from above are kept for a jaw, since each contact test takes time: up to `max_tilt_rad`, and up
// to `relaxed_tilt_rad` if there are fewer than `max_candidates`.
std::vector<GraspCandidate> CandidatesOf(const ObjectModel& model, const Gripper& tool,
                                         double max_tilt_rad, double relaxed_tilt_rad,
                                         int max_candidates, Rng& rng,
                                         const GraspCandidateOptions& options) {
  const auto* jaw = dynamic_cast<const ParallelJaw*>(&tool);
  if (jaw == nullptr) return MakeCandidates(model, tool, rng, options);
  const AntipodalOptions& antipodal = options.antipodal;
  std::vector<GraspCandidate> candidates =
      AntipodalGrasps(model, jaw->hand, jaw->clearance_m, rng, antipodal);
  const auto down = [](const GraspCandidate& candidate) { return -candidate.X_OG.linear()(2, 2); };
  std::vector<GraspCandidate> steep, tilted;
  for (const GraspCandidate& candidate : candidates) {
    if (down(candidate) >= std::cos(max_tilt_rad)) {
      steep.push_back(candidate);
    } else if (down(candidate) >= std::cos(relaxed_tilt_rad)) {
      tilted.push_back(candidate);
    }
  }
  const auto none_same = [](const GraspCandidate&, const GraspCandidate&) { return false; };
  candidates = SpreadOverDirections(std::move(steep), max_candidates, none_same);
  const int left = max_candidates - static_cast<int>(candidates.size());
  tilted = SpreadOverDirections(std::move(tilted), left, none_same);
  candidates.insert(candidates.end(), tilted.begin(), tilted.end());
  if (candidates.empty()) return candidates;
  const SurfacePoints surface = SpreadPoints(model.mesh_O, antipodal.point_spacing_m,
                                             antipodal.min_points, antipodal.max_points, rng);
  // The chance of success takes the place of the robustness. Epsilon only orders the candidates, so
  // that a rough value is enough.
  constexpr double kEpsilonTolerance = 0.1;
  SetJawEpsilon(model, jaw->hand, jaw->clearance_m, surface, options.robust, candidates,
                {.tolerance = kEpsilonTolerance});
  return candidates;
}

// A table at the height of the lowest observed point, for an image without a known bin.
std::optional<double> LowestPoint_m(const PlannerInput& input) {
  double lowest_m = std::numeric_limits<double>::infinity();
  ForEachDepthPoint(input.frame.intrinsics, input.frame.depth_m,
                    [&](int, int, const Vector3d& p_C) {
                      lowest_m = std::min(lowest_m, (input.X_WC * p_C).z());
                    });
  if (!std::isfinite(lowest_m)) return std::nullopt;
  return lowest_m;
}

bool IsBetter(const Grasp& a, const Grasp& b) { return a.score > b.score; }

// Leaves out the grasps from `first` on and counts them as rejected.
void LeaveOut(std::vector<Grasp>::iterator first, const char* cause, PlanResult& plan) {
  if (first == plan.grasps.end()) return;
  plan.rejected[cause] += static_cast<int>(plan.grasps.end() - first);
  plan.grasps.erase(first, plan.grasps.end());
}

}  // namespace

CompletedPlannerOptions::CompletedPlannerOptions() {
  // An object is grasped once, so fewer candidates are sampled than for a known object.
  AntipodalOptions& antipodal = candidates.antipodal;
  antipodal.candidates = 600;
  antipodal.resting_candidates = 300;
  antipodal.resting_level_rad = 0.25;
  antipodal.max_samples = 4000;
  antipodal.max_pairs = 150;
  antipodal.approaches = 12;
  antipodal.resting_rotations = 1;
  antipodal.point_spacing_m = 0.003;
  antipodal.min_points = 800;
  antipodal.max_points = 1500;
  candidates.suction.candidates = 100;
  candidates.suction.max_samples = 600;
  candidates.suction.min_points = 800;
  candidates.suction.max_points = 1500;
  candidates.robust.samples = 1;
  candidates.robust.cone_edges = 4;
}

void CompletedPlannerOptions::Visit(SettingsVisitor& v) {
  const Range probability{0.01, 0.99};
  v.Integer("max_shapes", max_shapes, {1, 1000}, "number of objects that are completed");
  v.Real("min_reported_score", min_reported_score, {0, 1},
         "chance of success, before rehearsals, under which a grasp is not reported");
  v.Integer("smoothing", smoothing, {0, 10}, "number of passes of the smoothing of a shape");
  v.Bool("grasps_observed", grasps_observed, "whether the hands also grasp the observed surface");
  v.Group(
      "chance", [this](SettingsVisitor& g) { chance.Visit(g); },
      "log odds of success of a grasp, which give its score");
  v.Real("surface_level", surface_level, probability, "probability at the grasped surface");
  v.Real("possible_level", possible_level, probability,
         "probability from which a hand keeps out of a cell");
  v.Real("relaxed_level", relaxed_level, probability,
         "probability from which a hand keeps out of a cell if no grasp is found otherwise");
  v.Real("wider_m", wider_m, {0, 0.1}, "step by which a jaw opens wider, m");
  v.Integer("max_wider", max_wider, {0, 100}, "number of steps by which a jaw opens wider");
  v.Integer("max_candidates", max_candidates, {1, 100000},
            "number of candidates of an object for one jaw");
  v.Real("density_kgpm3", density_kgpm3, {1, 30000}, "assumed density of an object, kg/m3");
  v.Integer("tested_grasps", tested_grasps, {1, 1e6},
            "number of planned grasps that are tested against possible matter");
  v.Group(
      "plan", [this](SettingsVisitor& g) { plan.Visit(g); }, "limits and ranking of grasps");
  v.Group(
      "candidates", [this](SettingsVisitor& g) { candidates.Visit(g); },
      "grasp candidates of an object");
  v.Group(
      "rehearsal", [this](SettingsVisitor& g) { rehearsal.Visit(g); },
      "execution of grasps on completed shapes");
}

CompletedPlanner::CompletedPlanner(const PlannerSetup& setup,
                                   const CompletedPlannerOptions& options)
    : setup_(setup), options_(options) {
  CheckSettings("CompletedPlannerOptions", options_);
  CheckInput(options_.possible_level <= options_.relaxed_level,
             fmt::format("possible_level ({:g}) is above relaxed_level ({:g}); lower it",
                         options_.possible_level, options_.relaxed_level));
  CheckInput(setup.shapes != nullptr,
             "planner completed needs shapes of objects, which this program does not give; choose "
             "planner cloud_antipodal");
  if (!options_.grasps_observed) return;
  std::vector<std::shared_ptr<const Gripper>> jaws, cups;
  for (const auto& tool : setup.tools) {
    (IsSuction(*tool) ? cups : jaws).push_back(tool);
  }
  const auto setup_with = [&](const std::vector<std::shared_ptr<const Gripper>>& tools) {
    return PlannerSetup{setup.spec, tools, setup.objects, setup.candidates, {}};
  };
  if (!jaws.empty()) on_surface_.push_back(std::make_unique<CloudAntipodal>(setup_with(jaws)));
  if (!cups.empty()) on_surface_.push_back(std::make_unique<CloudSuction>(setup_with(cups)));
}

double CompletedPlanner::MaxTilt_rad() const {
  return setup_.spec.max_tilt_deg > 0 ? Radians(setup_.spec.max_tilt_deg)
                                      : options_.plan.max_tilt_rad;
}

CompletedObjectOptions CompletedPlanner::Assumed() const {
  CompletedObjectOptions assumed;
  assumed.surface_level = options_.surface_level;
  assumed.density_kgpm3 = options_.density_kgpm3;
  assumed.friction = setup_.spec.friction / PadFriction(setup_.tools);
  return assumed;
}

const Gripper& CompletedPlanner::ToolOf(const Grasp& grasp) const {
  return **std::find_if(setup_.tools.begin(), setup_.tools.end(),
                        [&](const auto& tool) { return tool->name == grasp.tool; });
}

bool CompletedPlanner::Passes(const ObstacleField& matter, const Pose& X_BW, Grasp& grasp) const {
  const Gripper& tool = ToolOf(grasp);
  const std::vector<uint8_t> none{0};  // its points are one group
  const Pose X_BG = X_BW * grasp.X_WG;
  for (int step = 0; step <= options_.max_wider; ++step) {
    const double width_m = grasp.width_m + step * options_.wider_m;
    const std::optional<double> opening_m = tool.ApproachOpening_m(width_m);
    if (!opening_m) return false;
    if (!matter.FirstMet(X_BG, HandSweep(tool, *opening_m), none, 0)) {
      grasp.width_m = width_m;
      return true;
    }
    if (tool.MaxOpening_m() <= 0) return false;
  }
  return false;
}

double CompletedPlanner::ChanceOf(const Grasp& grasp, GraspedSurface surface,
                                  const GraspRater& rater) const {
  const Gripper& tool = ToolOf(grasp);
  if (setup_.network != nullptr && !IsSuction(tool)) {
    return setup_.network->Chance(rater.Inputs(grasp, tool, surface));
  }
  return options_.chance.Of(rater.Measure(grasp, tool, surface));
}

PlanResult CompletedPlanner::PlanOn(const std::vector<CompletedObject>& completed,
                                    const GraspRater& rater, const PlannerInput& input,
                                    const BinPlacement& bin) const {
  const Pose X_BW = bin.X_WB.inverse();
  ObjectSet objects;
  std::vector<EstimatedPose> poses;
  std::vector<std::vector<std::vector<GraspCandidate>>> candidates(setup_.tools.size());
  for (const CompletedObject& object : completed) {
    poses.push_back({ObjectId(static_cast<int>(objects.size())), object.X_BO, 1});
    objects.push_back(object.model);
    Rng rng = Rng::Derive(input.seed, BinIndex(0), "grasp/completed");
    for (size_t k = 0; k < candidates.size(); ++k) {
      candidates[k].push_back(CandidatesOf(*object.model, *setup_.tools[k], MaxTilt_rad(),
                                           options_.plan.relaxed.max_tilt_rad,
                                           options_.max_candidates, rng, options_.candidates));
    }
  }
  std::vector<Vector3d> cloud_B;
  ForEachDepthPoint(
      input.frame.intrinsics, input.frame.depth_m,
      [&](int, int, const Vector3d& p_C) { cloud_B.push_back(X_BW * (input.X_WC * p_C)); },
      setup_.cloud_stride_px);
  PlanOptions plan_options = options_.plan;
  plan_options.max_grasps = std::max(options_.tested_grasps, input.max_grasps);
  plan_options.seed = input.seed;
  plan_options.max_tilt_rad = MaxTilt_rad();
  // The chances of success were measured with lifts straight up.
  plan_options.lift_aside_diameters = 0;
  std::vector<PlanInput> inputs;
  for (size_t k = 0; k < setup_.tools.size(); ++k) {
    inputs.push_back({bin.bin, poses, candidates[k], cloud_B, objects, *setup_.tools[k],
                      input.targets, &rater.hidden()});
  }
  PlanResult plan = PlanWithTools(inputs, plan_options);
  for (Grasp& grasp : plan.grasps) {
    grasp.X_WG = bin.X_WB * grasp.X_WG;
    grasp.hypothesis = kNoHypothesis;
  }
  return plan;
}

void CompletedPlanner::KeepOutOfPossibleMatter(std::span<const OccupancyShape> shapes,
                                               const Pose& X_BW, PlanResult& plan,
                                               PlanResult& observed) const {
  for (const double level : {options_.possible_level, options_.relaxed_level}) {
    std::vector<Vector3d> points_B;
    for (const OccupancyShape& shape : shapes) {
      for (const Vector3d& p_W : ShellOf(shape, level)) points_B.push_back(X_BW * p_W);
    }
    std::vector<int> groups(points_B.size(), 0);
    const ObstacleField matter(std::move(points_B), std::move(groups), options_.plan.column_m);
    const auto passing = [&](const PlanResult& all) {
      std::vector<Grasp> passed;
      for (Grasp grasp : all.grasps) {
        if (Passes(matter, X_BW, grasp)) passed.push_back(grasp);
      }
      return passed;
    };
    std::vector<Grasp> of_plan = passing(plan), of_observed = passing(observed);
    if (of_plan.empty() && of_observed.empty() && level < options_.relaxed_level) continue;
    const size_t before = plan.grasps.size() + observed.grasps.size();
    plan.grasps = std::move(of_plan);
    observed.grasps = std::move(of_observed);
    const size_t after = plan.grasps.size() + observed.grasps.size();
    if (after < before) plan.rejected["possible matter"] += static_cast<int>(before - after);
    return;
  }
}

void CompletedPlanner::Rehearse(Rehearsal& rehearsal, int max_grasps,
                                std::vector<Grasp>& grasps) const {
  struct Rated {
    Grasp grasp;
    bool is_final;  // rehearsed, or of a cup
  };
  std::vector<Rated> rated;
  for (const Grasp& grasp : grasps) rated.push_back({grasp, IsSuction(ToolOf(grasp))});
  const auto is_better = [](const Rated& a, const Rated& b) { return IsBetter(a.grasp, b.grasp); };
  // A rehearsal never raises a score. So a final grasp that is better than all others stays so.
  int left = setup_.spec.rehearsals;
  auto next = rated.begin();
  const auto last = rated.begin() + std::clamp<std::ptrdiff_t>(max_grasps, 0, std::ssize(rated));
  while (next != last && left > 0) {
    const auto best = std::min_element(next, rated.end(), is_better);
    if (best->is_final) {
      std::rotate(next++, best, best + 1);
      continue;
    }
    Grasp& grasp = best->grasp;
    // The cell does not execute the grasps that are left, and a rehearsal does not change that.
    if (grasp.score < setup_.spec.min_score) break;
    if (const auto failures = rehearsal.FailuresOf(grasp, ToolOf(grasp))) {
      grasp.score = options_.chance.AfterRehearsal(grasp.score, failures->hit, failures->lost);
    }
    best->is_final = true;
    --left;
  }
  std::stable_sort(rated.begin(), rated.end(), is_better);
  grasps.clear();
  for (const Rated& one : rated) grasps.push_back(one.grasp);
}

PlanResult CompletedPlanner::Plan(const PlannerInput& input) {
  CheckInput(!input.frame.depth_m.empty(),
             "the image has no depth, which a planner without poses needs");
  const Bin table{{10, 10, 0}};
  Pose X_WB = Pose::Identity();
  if (input.bin) {
    X_WB = input.bin->X_WB;
  } else if (const std::optional<double> lowest_m = LowestPoint_m(input)) {
    X_WB = Translation({0, 0, *lowest_m});
  } else {
    return {};
  }
  const std::vector<OccupancyShape> shapes = setup_.shapes->Shapes(input, options_.max_shapes);
  std::vector<OccupancyShape> smoothed = shapes;
  for (OccupancyShape& shape : smoothed) {
    for (int pass = 0; pass < options_.smoothing; ++pass) shape = Smoothed(shape);
  }
  std::vector<CompletedObject> completed;
  for (const OccupancyShape& shape : smoothed) {
    const auto object = MakeCompletedObject(shape, X_WB.inverse(), Assumed());
    if (object) completed.push_back(*object);
  }
  const ImageSegments segments = setup_.shapes->Segments();
  const GraspRater rater(input, X_WB, segments, shapes, options_.plan);
  PlanResult plan, observed;
  if (!completed.empty()) {
    plan = PlanOn(completed, rater, input, {input.bin ? input.bin->bin : table, X_WB});
  }
  for (const auto& planner : on_surface_) {
    const PlanResult found = planner->Plan(input);
    observed.grasps.insert(observed.grasps.end(), found.grasps.begin(), found.grasps.end());
    for (const auto& [cause, count] : found.rejected) plan.rejected[cause] += count;
  }
  if (segments.without_shape > 0) plan.rejected["segment without shape"] = segments.without_shape;
  KeepOutOfPossibleMatter(smoothed, X_WB.inverse(), plan, observed);
  // The scores of these planners rank candidates of one shape, but do not predict which grasps
  // succeed. Grasps with equal chances keep their order.
  for (Grasp& grasp : plan.grasps) {
    grasp.score = ChanceOf(grasp, GraspedSurface::kCompleted, rater);
  }
  for (Grasp& grasp : observed.grasps) {
    grasp.score = ChanceOf(grasp, GraspedSurface::kObserved, rater);
  }
  plan.grasps.insert(plan.grasps.end(), observed.grasps.begin(), observed.grasps.end());
  std::stable_sort(plan.grasps.begin(), plan.grasps.end(), IsBetter);
  // A rehearsal leaves no grasp out: the shape may be wrong, and there may be no other grasp.
  const auto weak = std::ranges::find_if(
      plan.grasps, [&](const Grasp& grasp) { return grasp.score < options_.min_reported_score; });
  LeaveOut(weak, "score too low", plan);
  const double bin_friction = input.bin ? input.bin->bin.friction : table.friction;
  Rehearsal rehearsal(smoothed, X_WB.inverse(), Assumed(), bin_friction, options_.rehearsal);
  Rehearse(rehearsal, input.max_grasps, plan.grasps);
  const int left = std::min(input.max_grasps, static_cast<int>(plan.grasps.size()));
  LeaveOut(plan.grasps.begin() + left, "outranked", plan);
  return plan;
}

}  // namespace pickbed::grasp
