#include "eval/benchmark/crops.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <memory>
#include <stdexcept>

#include "perception/icp/bidirectional_icp.h"
#include "perception/model/pose_distance.h"
#include "scenes/base/error.h"
#include "scenes/base/parallel.h"
#include "sim/training_view_source.h"

namespace pickbed::eval {
namespace {

// Shares of the work, for the progress line.
constexpr double kViewsShare = 0.05, kTrainingShare = 0.6;

using Clock = std::chrono::steady_clock;

double SecondsSince(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

const CropMethodRow& MethodRow(const std::string& name) {
  std::vector<std::string> names;
  for (const CropMethodRow& row : CropMethodTable()) {
    if (row.name == name) return row;
    names.push_back(row.name);
  }
  throw InputError(UnknownNameMessage("crop method", name, names));
}

int ConditionIndex(const std::string& name) {
  std::vector<std::string> names;
  for (const CropCondition& row : CropConditionTable()) {
    if (row.name == name) return static_cast<int>(names.size());
    names.push_back(row.name);
  }
  throw InputError(UnknownNameMessage("condition", name, names));
}

// A test view with the data needed to score it.
struct TestScene {
  OrganizedCloud cloud;
  CropSpot spot;
  Pose X_CO = Pose::Identity();
  double occluded = 0;
};

class Benchmark {
 public:
  explicit Benchmark(const CropBenchmarkJob& job) : job_(job), options_(job.options) {
    for (const std::string& name : job.methods) rows_.push_back(&MethodRow(name));
    for (const std::string& name : job.conditions) conditions_.push_back(ConditionIndex(name));
    for (const auto& object : job.objects) {
      models_.push_back(MakeModelPoints(*object));
      distances_.emplace_back(object->symmetries_O);
    }
    MakeSources();
  }

  CropBenchmark Run();

 private:
  void MakeSources();
  bool MakeMethods();
  void TestCell(ObjectId object, int condition);
  std::vector<TestScene> Scenes(ObjectId object, int condition, CropSet& crops);
  void Score(const std::string& method, CropStage stage, ObjectId object, int condition,
             const std::vector<TestScene>& scenes,
             const std::vector<std::vector<CropAnswer>>& answers, double seconds);
  Pose StartPose(const TestScene& scene, ObjectId object, const Eigen::Matrix3d& R_CO) const;
  CropAnswer BestByIcp(const TestScene& scene, const std::vector<CropAnswer>& starts) const;
  std::vector<std::vector<CropAnswer>> AllByIcp(
      const std::vector<TestScene>& scenes,
      const std::vector<std::vector<CropAnswer>>& starts) const;
  std::vector<std::vector<CropAnswer>> NearestToTruth(ObjectId object,
                                                      const std::vector<TestScene>& scenes) const;
  std::vector<std::vector<CropAnswer>> RandomStarts(ObjectId object, int condition,
                                                    size_t count) const;
  bool Report(const std::string& what, double share) {
    go_on_ = go_on_ && (!job_.on_progress || job_.on_progress(what, share));
    return go_on_;
  }

  const CropBenchmarkJob& job_;
  const CropBenchmarkOptions& options_;
  std::vector<const CropMethodRow*> rows_;
  std::vector<int> conditions_;
  std::vector<ModelPoints> models_;
  std::vector<RotationDistance> distances_;
  std::unique_ptr<LabelledViewSource> clean_, noisy_, relit_, varied_;
  std::shared_ptr<const CropTrainingSet> training_set_;
  std::vector<std::unique_ptr<CropMethod>> methods_;
  CropBenchmark result_;
  bool go_on_ = true;
};

void Benchmark::MakeSources() {
  ViewSourceOptions options;
  options.appearance = FixedAppearance();
  clean_ = MakeSimViewSource(job_.objects, options);
  options.sensor = LoadSensorProfile(options_.sensor);
  noisy_ = MakeSimViewSource(job_.objects, options);
  options.appearance = WideAppearance();
  // No painted background here: it is a separate condition.
  options.appearance.background = {0, 0};
  options.isolated_lamps = true;
  varied_ = MakeSimViewSource(job_.objects, options);
  options.sensor = {};
  relit_ = MakeSimViewSource(job_.objects, options);
}

bool Benchmark::MakeMethods() {
  auto training_set =
      MakeCropTrainingSet(*clean_, *varied_, options_.views, options_.seed,
                          [&](double share) { return Report("views", kViewsShare * share); });
  if (!go_on_) return false;
  training_set_ = std::make_shared<const CropTrainingSet>(std::move(training_set));
  varied_.reset();
  for (const CropMethodRow* row : rows_) {
    const auto start = Clock::now();
    CropMethodSetup setup{training_set_, options_.methods, job_.models, job_.threads, {}};
    setup.options.seed = options_.seed;
    setup.on_progress = [&](double share) {
      return Report(fmt::format("making {}", row->name),
                    kViewsShare + kTrainingShare * (static_cast<double>(methods_.size()) + share) /
                                      static_cast<double>(rows_.size()));
    };
    std::unique_ptr<CropMethod> method = row->make(setup);
    if (method == nullptr || !go_on_) return false;
    methods_.push_back(std::move(method));
    result_.training.push_back({row->name, SecondsSince(start)});
  }
  return true;
}

std::vector<TestScene> Benchmark::Scenes(ObjectId object, int condition, CropSet& crops) {
  CloudOptions all_is_foreground;
  all_is_foreground.min_plane_share = 1;
  // The same views under every condition, which allows paired comparisons.
  Rng rng = Rng::Derive(options_.seed, object, "crop test views");
  const Rotations R_CO = TestRotations(options_.tests, options_.views, rng);
  const std::vector<CropTest> tests = MakeCropTests(
      {clean_.get(), noisy_.get(), relit_.get()}, object, CropConditionTable()[condition], R_CO,
      options_.views, Rng::Derive(options_.seed, object, "crop tests").Next());
  const ObjectModel& model = *job_.objects[object];
  std::vector<TestScene> scenes(tests.size());
  for (size_t i = 0; i < tests.size(); ++i) {
    const CropSpot spot{tests[i].X_CO * CropCenter_O(model), CropSide_m(model, options_.views)};
    AppendCrop(tests[i].frame, spot, nullptr, crops);
    scenes[i] = {{}, spot, tests[i].X_CO, tests[i].occluded};
  }
  ForRanges(static_cast<int>(tests.size()), job_.threads, [&](int begin, int end) {
    for (int i = begin; i < end; ++i) {
      scenes[i].cloud = BuildCloud(tests[i].frame, std::nullopt, all_is_foreground);
    }
  });
  return scenes;
}

// Start pose for an orientation. The object center is known, as for all crop methods.
Pose Benchmark::StartPose(const TestScene& scene, ObjectId object,
                          const Eigen::Matrix3d& R_CO) const {
  return MakePose(R_CO, scene.spot.center_C - R_CO * CropCenter_O(*job_.objects[object]));
}

CropAnswer Benchmark::BestByIcp(const TestScene& scene,
                                const std::vector<CropAnswer>& starts) const {
  CropAnswer best;
  best.object = ObjectId{-1};
  for (const CropAnswer& start : starts) {
    const IcpResult result = BidirectionalIcp(scene.cloud, models_[start.object],
                                              StartPose(scene, start.object, start.R_CO));
    if (best.object >= 0 && -result.agreement >= best.distance) continue;
    best = {start.object, result.X_CO.linear(), -result.agreement};
  }
  return best;
}

std::vector<std::vector<CropAnswer>> Benchmark::AllByIcp(
    const std::vector<TestScene>& scenes,
    const std::vector<std::vector<CropAnswer>>& starts) const {
  std::vector<std::vector<CropAnswer>> refined(scenes.size());
  ForRanges(static_cast<int>(scenes.size()), job_.threads, [&](int begin, int end) {
    for (int i = begin; i < end; ++i) {
      if (!starts[i].empty()) refined[i] = {BestByIcp(scenes[i], starts[i])};
    }
  });
  return refined;
}

std::vector<std::vector<CropAnswer>> Benchmark::NearestToTruth(
    ObjectId object, const std::vector<TestScene>& scenes) const {
  std::vector<std::vector<CropAnswer>> answers;
  for (const TestScene& scene : scenes) {
    CropAnswer nearest{object, {}, std::numeric_limits<double>::infinity()};
    for (const Eigen::Matrix3d& R_CO : training_set_->templates[object].R_CO) {
      const double distance = distances_[object](scene.X_CO.linear(), R_CO);
      if (distance < nearest.distance) nearest = {object, R_CO, distance};
    }
    answers.push_back({nearest});
  }
  return answers;
}

std::vector<std::vector<CropAnswer>> Benchmark::RandomStarts(ObjectId object, int condition,
                                                             size_t count) const {
  Rng rng = Rng::Derive(options_.seed, object, fmt::format("crop random starts {}", condition));
  std::vector<std::vector<CropAnswer>> starts(count);
  for (std::vector<CropAnswer>& of_one : starts) {
    for (int i = 0; i < options_.icp_starts; ++i) {
      of_one.push_back({object, rng.Rotation().toRotationMatrix(), 0});
    }
  }
  return starts;
}

void Benchmark::Score(const std::string& method, CropStage stage, ObjectId object, int condition,
                      const std::vector<TestScene>& scenes,
                      const std::vector<std::vector<CropAnswer>>& answers, double seconds) {
  for (size_t i = 0; i < scenes.size(); ++i) {
    CropRecord record{method, stage, object, condition, static_cast<int>(i)};
    record.occluded = scenes[i].occluded;
    record.seconds = seconds / static_cast<double>(scenes.size());
    if (!answers[i].empty()) record.found_object = answers[i].front().object;
    if (record.found_object == object) {
      record.angle_rad = distances_[object](scenes[i].X_CO.linear(), answers[i].front().R_CO);
    }
    result_.records.push_back(record);
  }
}

void Benchmark::TestCell(ObjectId object, int condition) {
  CropSet crops;
  const std::vector<TestScene> scenes = Scenes(object, condition, crops);
  const auto with_icp = [&](const std::string& method,
                            const std::vector<std::vector<CropAnswer>>& starts, CropStage stage) {
    const auto start = Clock::now();
    const auto refined = AllByIcp(scenes, starts);
    Score(method, stage, object, condition, scenes, refined, SecondsSince(start));
  };
  for (size_t m = 0; m < methods_.size(); ++m) {
    const auto start = Clock::now();
    const auto answers = methods_[m]->Answer(crops, options_.k, job_.threads);
    Score(rows_[m]->name, CropStage::kNearest, object, condition, scenes, answers,
          SecondsSince(start));
    with_icp(rows_[m]->name, answers, CropStage::kNearestIcp);
  }
  const auto oracle = NearestToTruth(object, scenes);
  Score(kOracleMethod, CropStage::kNearest, object, condition, scenes, oracle, 0);
  with_icp(kOracleMethod, oracle, CropStage::kNearestIcp);
  with_icp(kRandomStarts, RandomStarts(object, condition, scenes.size()), CropStage::kIcpOnly);
}

CropBenchmark Benchmark::Run() {
  if (!MakeMethods()) return std::move(result_);
  const size_t cells = job_.objects.size() * conditions_.size();
  size_t done = 0;
  for (ObjectId object{0}; object < static_cast<int>(job_.objects.size()); ++object) {
    for (const int condition : conditions_) {
      const double before = kViewsShare + kTrainingShare;
      if (!Report(
              fmt::format("{}, {}", job_.objects[object]->name,
                          CropConditionTable()[condition].name),
              before + (1 - before) * static_cast<double>(done++) / static_cast<double>(cells))) {
        return std::move(result_);
      }
      TestCell(object, condition);
    }
  }
  result_.finished = true;
  return std::move(result_);
}

}  // namespace

void CropBenchmarkOptions::Visit(SettingsVisitor& v) {
  v.Seed("seed", seed, "random seed of views, weights and random poses");
  v.Integer("tests", tests, {1, 100000}, "number of test views per object and condition");
  v.Integer("k", k, {1, 100}, "number of nearest answers that ICP starts from");
  v.Integer("icp_starts", icp_starts, {1, 1000},
            "number of random orientations that the ICP baseline starts from");
  v.Text("sensor", sensor, {},
         "sensor profile whose noise the noisy condition and the training have");
  v.Group(
      "views", [&](SettingsVisitor& g) { views.Visit(g); }, "templates, crops and test views");
  v.Group(
      "methods", [&](SettingsVisitor& g) { methods.Visit(g); }, "settings of the methods");
}

const char* CropStageName(CropStage stage) {
  switch (stage) {
    case CropStage::kNearest:
      return "nearest";
    case CropStage::kNearestIcp:
      return "nearest+icp";
    case CropStage::kIcpOnly:
      return "icp_alone";
  }
  throw std::logic_error("unknown stage of the crop table");
}

CropBenchmark RunCropBenchmark(const CropBenchmarkJob& job) {
  CheckSettings("CropBenchmarkOptions", job.options);
  CheckInput(!job.objects.empty(), "the crop table needs at least one object");
  return Benchmark(job).Run();
}

}  // namespace pickbed::eval
