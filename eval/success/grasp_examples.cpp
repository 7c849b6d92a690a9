#include "eval/success/grasp_examples.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "eval/shapes/segment_shapes.h"
#include "eval/trial/attempt.h"
#include "eval/trial/grasp_choice.h"
#include "eval/trial/trial_setup.h"
#include "grasp/cloud/cloud_antipodal.h"
#include "grasp/completed/completed_planner.h"
#include "grasp/completed/grasp_rater.h"
#include "grasp/completed/success_network.h"
#include "scenes/base/byte_blocks.h"
#include "scenes/base/error.h"
#include "scenes/base/files.h"
#include "scenes/base/random.h"
#include "scenes/scenario/find_scenario.h"

namespace pickbed::eval {
namespace {

using Eigen::Vector3d;

// The blocks are the key, inputs, successes and images.
constexpr std::string_view kMagic = "PICKGEXA";
constexpr uint64_t kVersion = 1;
constexpr uint64_t kSeed = 800000;                   // of group 0; no preset uses seeds near it
constexpr int kDeepObjects = 60, kRoundObjects = 5;  // drawn by a bin of each preset
constexpr int kFirstRoundObject = 500000;            // deep bins use the seen objects from 0 on
constexpr int kMaxFailuresInRow = 6;                 // of the best grasps
constexpr double kSamePlace_m = 0.015;               // grasps nearer to each other are alike
constexpr double kFailedPlace_m = 0.03;  // no grasp this near to a failed one is tried again
constexpr int kPlannedGrasps = 60;       // of each planner
constexpr int kMaxDraws = 40;            // of random grasps in an image

// Gives the shapes of another source and keeps them.
class KeptShapes : public ShapeSource {
 public:
  explicit KeptShapes(ShapeSource& source) : source_(source) {}
  std::vector<OccupancyShape> Shapes(const PlannerInput& input, int max_shapes) override {
    return last = source_.Shapes(input, max_shapes);
  }
  ImageSegments Segments() const override { return source_.Segments(); }
  std::vector<OccupancyShape> last;

 private:
  ShapeSource& source_;
};

struct PlannedGrasp {
  Grasp grasp;
  GraspedSurface surface;
  double chance = 0;
};

// Returns the settings that replace the unseen objects of a preset by `count` seen ones.
std::vector<std::string> SettingsOf(GroupKind kind, uint64_t seed, int first_object) {
  const auto range = [&](const char* domain, int list, int count) {
    return fmt::format("objects.{}.name=sampled/{}/seen/{}-{}", list, domain, first_object,
                       first_object + count - 1);
  };
  std::vector<std::string> settings{fmt::format("seed={}", seed)};
  if (kind == GroupKind::kDeep) {
    settings.push_back(range("machine", 0, kDeepObjects));
  } else {
    settings.push_back(range("machine", 0, kRoundObjects));
    settings.push_back(range("supermarket", 1, kRoundObjects));
  }
  return settings;
}

// One bin of unknown objects that is picked while examples are made.
class ExampleBin {
 public:
  ExampleBin(const LoadedScenario& scenario, const ExampleOptions& options, int max_images,
             GraspExamples& examples)
      : setup_(scenario.spec, scenario.objects, {}, {}),
        options_(options),
        max_images_(max_images),
        network_(SuccessNetworkNamed(options.ranking)),
        shapes_(*setup_.shapes),
        completed_(SetupOf(&shapes_), CompletedOptions()),
        observed_(SetupOf(nullptr)),
        rng_(Rng::Derive(setup_.spec.seed, BinIndex(0), "eval/grasp_examples")),
        examples_(examples) {
    trial_.objects = setup_.cell.TrueObjects(trial_.bin_index);
    trial_.scene = setup_.cell.MakeScene(trial_.bin_index).scene;
  }

  void Pick(const std::function<void()>& on_image) {
    int failures = 0;
    for (int i = 0; i < max_images_ && failures < kMaxFailuresInRow; ++i) {
      if (setup_.cell.WantedIn(trial_.scene) == 0) return;
      const std::optional<bool> picked = PickFromImage(i);
      if (!picked) return;
      failures = *picked ? 0 : failures + 1;
      on_image();
    }
  }

 private:
  PlannerSetup SetupOf(ShapeSource* shapes) const {
    PlannerSetup setup{setup_.spec.planner, setup_.tools, setup_.cell.objects(),
                       setup_.candidates,   {},           setup_.options.cloud_stride_px};
    setup.shapes = shapes;
    setup.network = network_;
    return setup;
  }

  static CompletedPlannerOptions CompletedOptions() {
    CompletedPlannerOptions options;
    options.grasps_observed = false;  // these are planned by `observed_`, with their own scores
    options.min_reported_score = 0;
    return options;
  }

  // Returns all planned grasps with their chances, best first, without those at places where one
  // failed.
  std::vector<PlannedGrasp> Planned(const PlannerInput& input, const GraspRater& rater,
                                    const std::vector<Grasp>& completed) {
    std::vector<PlannedGrasp> planned;
    const auto is_new = [&](const Grasp& grasp) {
      return std::ranges::none_of(failed_W_, [&](const Vector3d& p_W) {
        return (p_W - grasp.X_WG.translation()).norm() < kFailedPlace_m;
      });
    };
    for (const Grasp& grasp : completed) {
      if (is_new(grasp)) planned.push_back({grasp, GraspedSurface::kCompleted, grasp.score});
    }
    for (const Grasp& grasp : observed_.Plan(input).grasps) {
      if (!is_new(grasp)) continue;
      const Gripper& tool = ToolNamed(setup_.tools, grasp.tool);
      constexpr GraspedSurface kSurface = GraspedSurface::kObserved;
      const double chance = network_ ? network_->Chance(rater.Inputs(grasp, tool, kSurface))
                                     : SuccessChance().Of(rater.Measure(grasp, tool, kSurface));
      planned.push_back({grasp, kSurface, chance});
    }
    std::stable_sort(planned.begin(), planned.end(),
                     [](const auto& a, const auto& b) { return a.chance > b.chance; });
    return planned;
  }

  // Returns the indices of the grasps to execute, the best one first.
  std::vector<size_t> Chosen(const std::vector<PlannedGrasp>& planned) {
    std::vector<size_t> chosen;
    const size_t best = static_cast<size_t>(options_.best);
    for (size_t i = 0; i < planned.size() && chosen.size() < best; ++i) {
      const Vector3d& p_W = planned[i].grasp.X_WG.translation();
      const auto is_near = [&](size_t j) {
        return (planned[j].grasp.X_WG.translation() - p_W).norm() < kSamePlace_m;
      };
      if (std::ranges::none_of(chosen, is_near)) chosen.push_back(i);
    }
    const size_t wanted = std::min(planned.size(), chosen.size() + options_.random);
    for (int draw = 0; draw < kMaxDraws && chosen.size() < wanted; ++draw) {
      const size_t i =
          std::min(planned.size() - 1, static_cast<size_t>(rng_.Uniform() * planned.size()));
      if (std::ranges::find(chosen, i) == chosen.end()) chosen.push_back(i);
    }
    return chosen;
  }

  // Returns whether the best grasp of a new image succeeded; nullopt if there is no grasp.
  std::optional<bool> PickFromImage(int number) {
    LiveAttempt attempt(setup_, {number}, trial_);
    attempt.Estimate();
    const Observation& view = attempt.image()->view;
    const CellCalibration& calibration = view.calibration;
    const Pose X_WB = calibration.X_WB.value_or(Pose::Identity());
    const PlannerInput input{view.frame,
                             calibration.camera.X_WC(),
                             BinPlacement{setup_.cell.bin(), X_WB},
                             {},
                             {},
                             kPlannedGrasps,
                             PlanSeed(setup_, trial_.bin_index, number)};
    const std::vector<Grasp> completed = completed_.Plan(input).grasps;
    const ImageSegments segments = shapes_.Segments();
    const PlanOptions plan;
    const GraspRater rater(input, X_WB, segments, shapes_.last, plan);
    const std::vector<PlannedGrasp> planned = Planned(input, rater, completed);
    const std::vector<size_t> chosen = Chosen(planned);
    if (chosen.empty()) return std::nullopt;
    const int image = examples_.image.empty() ? 0 : examples_.image.back() + 1;
    for (const size_t i : chosen) {
      const auto& [grasp, surface, chance] = planned[i];
      const std::vector<float> inputs =
          rater.Inputs(grasp, ToolNamed(setup_.tools, grasp.tool), surface);
      examples_.inputs.insert(examples_.inputs.end(), inputs.begin(), inputs.end());
      examples_.image.push_back(image);
      examples_.success.push_back(
          TryGrasp(setup_, {trial_.scene, trial_.objects}, grasp, {}, {}).outcome.success);
    }
    const Grasp& best = planned[chosen.front()].grasp;
    const bool picked = attempt.Execute(best).outcome.success;
    if (!picked) failed_W_.push_back(best.X_WG.translation());
    return picked;
  }

  TrialSetup setup_;
  const ExampleOptions options_;
  const int max_images_;
  const std::shared_ptr<const SuccessNetwork> network_;  // null: the logistic function
  KeptShapes shapes_;
  CompletedPlanner completed_;
  CloudAntipodal observed_;
  Rng rng_;
  LiveTrial trial_;
  std::vector<Vector3d> failed_W_;  // places of failed grasps
  GraspExamples& examples_;
};

}  // namespace

void ExampleOptions::Visit(SettingsVisitor& v) {
  v.Integer("shallow_rounds", shallow_rounds, {1, 1000}, "rounds of clutter_unseen in a group");
  v.Integer("deep_attempts", deep_attempts, {1, 10000}, "images of a bin of deep_unknown");
  v.Integer("shallow_attempts", shallow_attempts, {1, 10000}, "images of a round");
  v.Integer("best", best, {1, 1000}, "grasps of an image with the best scores");
  v.Integer("random", random, {0, 1000}, "other grasps of an image");
  v.Text("ranking", ranking, {},
         "network whose chances are the scores, or none for the logistic function");
}

GraspExamples MakeGraspExamples(int group, const ExampleOptions& options,
                                const std::function<void()>& on_image) {
  const GroupKind kind = KindOf(group);
  const bool is_deep = kind == GroupKind::kDeep;
  GraspExamples examples;
  for (int round = 0; round < (is_deep ? 1 : options.shallow_rounds); ++round) {
    const int number = is_deep ? group : group * options.shallow_rounds + round;
    ScenarioRequest request;
    request.scenario = is_deep ? "deep_unknown" : "clutter_unseen";
    request.settings =
        SettingsOf(kind, kSeed + number,
                   is_deep ? group * kDeepObjects : kFirstRoundObject + number * kRoundObjects);
    ExampleBin bin(FindScenario(request), options,
                   is_deep ? options.deep_attempts : options.shallow_attempts, examples);
    bin.Pick(on_image);
  }
  return examples;
}

std::string ExamplesKey(int group, const ExampleOptions& options) {
  ExampleOptions copy = options;  // Visit() is not const
  return fmt::format("group {}\n{}", group,
                     WriteSettings([&](SettingsVisitor& v) { copy.Visit(v); }));
}

void SaveGraspExamples(const std::filesystem::path& file, const std::string& key,
                       const GraspExamples& examples) {
  BlockWriter writer;
  writer.Put(key);
  writer.Put(examples.inputs);
  writer.Put(examples.success);
  writer.Put(examples.image);
  WriteFileAtomically(file, writer.Bytes(kMagic, kVersion));
}

GraspExamples LoadGraspExamples(const std::filesystem::path& file, const std::string& key) {
  const std::string bytes = ReadFileBytes(file);
  try {
    BlockReader reader(bytes, kMagic, kVersion, "a file of grasp examples");
    CheckInput(key == reader.Take() || key.empty(), "it was made with other settings");
    GraspExamples examples;
    examples.inputs = reader.TakeAll<float>();
    examples.success = reader.TakeAll<uint8_t>();
    examples.image = reader.TakeAll<int32_t>();
    reader.RequireEnd();
    CheckInput(examples.image.size() == examples.success.size() &&
                   examples.inputs.size() == examples.success.size() * grasp::kSuccessInputs,
               "the file is damaged: its lists do not belong together");
    CheckInput(std::ranges::all_of(examples.success, [](uint8_t value) { return value <= 1; }),
               "a success is neither 0 nor 1");
    constexpr float kLargest = 1e6f;  // inputs are lengths in m, shares and angles
    const auto is_usual = [](float value) { return std::abs(value) <= kLargest; };
    CheckInput(std::ranges::all_of(examples.inputs, is_usual),
               "an input is not finite, or too large");
    return examples;
  } catch (const InputError& error) {
    throw InputError(fmt::format("{}: {}; give another folder with --data, or move the file away",
                                 file.string(), error.what()));
  }
}

}  // namespace pickbed::eval
