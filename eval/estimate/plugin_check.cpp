#include "eval/estimate/plugin_check.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <functional>
#include <limits>
#include <memory>
#include <optional>

#include "eval/cell/simulated_cell.h"
#include "eval/trial/estimator_runner.h"
#include "eval/trial/pose_matching.h"
#include "grasp/grippers/tools.h"
#include "perception/estimators/score_calibration.h"
#include "scenes/base/files.h"
#include "scenes/plugin/plugin_messages.h"

namespace pickbed::eval {
namespace {

constexpr size_t kShownFaults = 5;
constexpr uint64_t kFrameSeed = 1;

using Clock = std::chrono::steady_clock;

std::string Milliseconds(double seconds) { return fmt::format("{:.1f} ms", 1e3 * seconds); }

std::vector<PluginGripper> GrippersOf(const ScenarioSpec& spec) {
  std::vector<PluginGripper> grippers;
  for (const auto& tool : LoadTools(spec.gripper.names)) {
    grippers.push_back({tool->name, tool->mechanism(), tool->MaxOpening_m(), tool->approach_m,
                        tool->SettingsText()});
  }
  return grippers;
}

// The settings with the kind of scores, and their minimum, with which a calibration was fitted.
EstimatorSpec BeforeCalibration(EstimatorSpec spec) {
  if (spec.calibration.empty()) return spec;
  const ScoreCalibration calibration = ReadCalibration(spec.calibration);
  spec.scores = calibration.scores;
  spec.min_score = calibration.min_score;
  return spec;
}

class PluginChecks {
 public:
  explicit PluginChecks(const PluginCheckJob& job)
      : job_(job),
        is_planner_(job.role == kPlannerRole),
        estimator_(BeforeCalibration(job.scenario.spec.estimator)),
        cell_(job.scenario.spec, job.scenario.objects),
        scene_(cell_.MakeScene(BinIndex(0)).scene) {
    for (const ObjectId object : cell_.wanted()) objects_.push_back(cell_.objects()[object]);
    for (const auto& object : cell_.objects()) metrics_.push_back(MakeMetricModel(*object));
    if (is_planner_) grippers_ = GrippersOf(job.scenario.spec);
    for (int i = 0; i < job.images; ++i) {
      images_.push_back(cell_.Capture(scene_, BinIndex(0), i));
    }
  }

  std::vector<PluginCheckup> Run() {
    client_ = std::make_unique<PluginClient>(job_.address, job_.role,
                                             [this](MessageWriter& message) { Setup(message); });
    const PluginIdentity& identity = client_->identity();
    Add("start", fmt::format("'{}', {}, needs [{}]; hello after {}, setup after {}", identity.name,
                             fmt::join(identity.roles, " and "), fmt::join(identity.needs, ", "),
                             Milliseconds(client_->start_times().hello_s),
                             Milliseconds(client_->start_times().setup_s)));
    CheckAnswer();
    CheckRepeatability();
    CheckBlankImage();
    if (!Needs(kNeedsColor)) CheckImageWithoutColor();
    if (!Needs(kNeedsBin)) CheckUnknownBin();
    if (is_planner_) CheckWithoutPoses();
    CheckUnknownVerb();
    CheckTimes();
    CheckEnd();
    return std::move(checkups_);
  }

 private:
  // What an answer contains.
  struct Answer {
    std::vector<PluginPose> poses;
    std::vector<PluginGrasp> grasps;
    std::vector<std::string> faults;
    size_t size() const { return poses.size() + grasps.size(); }
  };

  const char* noun() const { return is_planner_ ? "grasps" : "poses"; }

  bool Needs(const char* need) const {
    const auto& needs = client_->identity().needs;
    return std::find(needs.begin(), needs.end(), need) != needs.end();
  }

  void Setup(MessageWriter& message) const {
    PluginSetup setup{objects_};
    setup.intrinsics = cell_.camera().intrinsics;
    setup.working_distance_m = WorkingDistance_m(cell_);
    setup.bin = &cell_.bin();
    setup.min_score =
        HasRawScores(estimator_) ? -std::numeric_limits<double>::infinity() : estimator_.min_score;
    setup.model = estimator_.model;
    setup.mode = estimator_.mode;
    setup.grippers = grippers_;
    WriteSetup(setup, CacheDir() / kPluginMeshesFolder, message);
  }

  void Add(const std::string& name, const std::string& found,
           const std::vector<std::string>& remedy = {}) {
    checkups_.push_back({name, remedy.empty(), found, remedy});
  }

  // Adds a failed check for an exception of `check`.
  void Try(const std::string& name, const std::function<void()>& check) {
    try {
      check();
    } catch (const PluginError& error) {
      std::vector<std::string> remedy = error.traceback;
      if (remedy.empty()) remedy.push_back("the program wrote nothing to standard error");
      Add(name, error.what(), remedy);
    }
  }

  // The true poses that are visible, for a planner.
  std::vector<PluginPose> TruePoses() const {
    std::vector<PluginPose> poses;
    for (size_t i = 0; i < scene_.objects.size(); ++i) {
      const double visible = images_.front().visible_fractions[i];
      if (visible < kCountedVisibility || !cell_.IsWanted(scene_.objects[i].object)) continue;
      poses.push_back({OwnId(scene_.objects[i].object),
                       cell_.camera().X_CW() * scene_.objects[i].X_WO, visible});
    }
    return poses;
  }

  // Number of instances of each object of the program.
  std::vector<int> Counts() const {
    std::vector<int> counts(objects_.size(), 0);
    for (const PosedObject& posed : scene_.objects) {
      if (cell_.IsWanted(posed.object)) ++counts[OwnId(posed.object)];
    }
    return counts;
  }

  // Index of an object of the cell among the objects of the program.
  ObjectId OwnId(ObjectId object) const {
    const auto found = std::find(cell_.wanted().begin(), cell_.wanted().end(), object);
    return ObjectId(static_cast<int>(found - cell_.wanted().begin()));
  }

  Answer Ask(const RgbdFrame& frame, bool with_poses = true, bool with_bin = true) {
    PluginFrame input{frame};
    // Without a bin, the world is unknown too. Only a planner needs it, for its answers.
    if (with_bin || is_planner_) input.X_WC = cell_.camera().X_WC();
    if (with_bin) input.X_CB = cell_.camera().X_CW();
    input.seed = kFrameSeed;
    const std::vector<int> counts = Needs(kNeedsCounts) ? Counts() : std::vector<int>();
    input.counts = counts;
    MessageWriter request;
    std::vector<PluginPose> poses;
    if (is_planner_) {
      if (with_poses) poses = TruePoses();
      WritePlanGrasps(input, objects_, with_poses ? &poses : nullptr, request);
    } else {
      WriteEstimate(input, objects_, request);
    }
    const auto start = Clock::now();
    const MessageValue message = client_->Ask(request);
    seconds_.push_back(std::chrono::duration<double>(Clock::now() - start).count());
    Answer answer;
    if (is_planner_) {
      answer.grasps =
          ReadGrasps(message, grippers_, static_cast<int>(poses.size()), &answer.faults);
    } else {
      answer.poses =
          ReadPoses(message, objects_, WorkingDistance_m(cell_), &answer.faults,
                    HasRawScores(estimator_) ? PluginScores::kAny : PluginScores::kProbabilities);
    }
    if (answer.faults.size() > kShownFaults) {
      answer.faults.resize(kShownFaults);
      answer.faults.push_back("...");
    }
    return answer;
  }

  void CheckAnswer() {
    Try("answer", [this] {
      const Answer answer = Ask(images_.front().frame);
      Add("answer", fmt::format("{} {} in the first image", answer.size(), noun()), answer.faults);
      if (is_planner_) return AddGrasps(answer);
      AddScores(answer);
      AddAccuracy(answer);
    });
  }

  void AddScores(const Answer& answer) {
    if (HasRawScores(estimator_)) {
      const auto [low, high] = std::ranges::minmax_element(answer.poses, {}, &PluginPose::score);
      const std::string range =
          answer.poses.empty() ? "none" : fmt::format("from {:g} to {:g}", low->score, high->score);
      return Add("scores",
                 fmt::format("raw, {}; pickbed calibrate converts them after a run", range));
    }
    const double min_score = estimator_.min_score;
    const auto below = std::count_if(answer.poses.begin(), answer.poses.end(),
                                     [&](const auto& p) { return p.score < min_score; });
    Add("scores", fmt::format("{} of {} poses have a score below estimator.min_score = {:g} and "
                              "are not used",
                              below, answer.poses.size(), min_score));
  }

  // Counts correct poses. The program need not be good, so that this check never fails.
  void AddAccuracy(const Answer& answer) {
    std::vector<PoseHypothesis> hypotheses;
    for (const PluginPose& pose : answer.poses) {
      PoseHypothesis& hypothesis = hypotheses.emplace_back();
      hypothesis.object = cell_.wanted()[pose.object];
      hypothesis.X_CO = pose.X_CO;
      hypothesis.score = pose.score;
    }
    std::stable_sort(hypotheses.begin(), hypotheses.end(),
                     [](const auto& a, const auto& b) { return a.score > b.score; });
    const InstanceMatcher truth(
        metrics_, InstancesOf(scene_, images_.front().visible_fractions, cell_.camera().X_CW()));
    const AttemptScore score = ScoreAgainstTruth(truth, cell_.camera(), hypotheses);
    int visible = 0, recalled = 0, correct = 0;
    for (const InstanceRecord& instance : score.instances) {
      visible += instance.visible_fraction >= kCountedVisibility;
      recalled += instance.recalled;
    }
    for (const ScoredHypothesis& hypothesis : score.hypotheses) {
      correct += hypothesis.record.correct;
    }
    Add("accuracy", fmt::format("{} of {} poses are right; {} of {} visible instances are found",
                                correct, hypotheses.size(), recalled, visible));
  }

  void AddGrasps(const Answer& answer) {
    const auto inside = std::count_if(
        answer.grasps.begin(), answer.grasps.end(),
        [this](const PluginGrasp& g) { return cell_.bin().Holds(g.X_WG.translation()); });
    Add("place", fmt::format("{} of {} grasps are inside the bin", inside, answer.grasps.size()));
  }

  void CheckRepeatability() {
    Try("repeat", [this] {
      const Answer first = Ask(images_.front().frame), second = Ask(images_.front().frame);
      const auto same_pose = [](const PluginPose& a, const PluginPose& b) {
        return a.object == b.object && a.X_CO.matrix() == b.X_CO.matrix() && a.score == b.score;
      };
      const auto same_grasp = [](const PluginGrasp& a, const PluginGrasp& b) {
        return a.X_WG.matrix() == b.X_WG.matrix() && a.score == b.score;
      };
      const bool same = std::equal(first.poses.begin(), first.poses.end(), second.poses.begin(),
                                   second.poses.end(), same_pose) &&
                        std::equal(first.grasps.begin(), first.grasps.end(), second.grasps.begin(),
                                   second.grasps.end(), same_grasp);
      if (same) return Add("repeat", "the same image and seed give the same answer");
      Add("repeat", "the same image and seed give different answers",
          {"derive random numbers from the seed of the frame, frame.rng() in Python, and keep no "
           "state from one image to the next"});
    });
  }

  void CheckBlankImage() {
    Try("blank", [this] {
      RgbdFrame blank = images_.front().frame;
      std::fill(blank.depth_m.pixels().begin(), blank.depth_m.pixels().end(), 0.0f);
      const Answer answer = Ask(blank);
      Add("blank", fmt::format("{} {} in an image without readings", answer.size(), noun()),
          answer.faults);
    });
  }

  void CheckImageWithoutColor() {
    Try("gray", [this] {
      RgbdFrame gray = images_.front().frame;
      gray.color = {};
      const Answer answer = Ask(gray);
      Add("gray", fmt::format("{} {} in an image without color", answer.size(), noun()),
          answer.faults);
    });
  }

  void CheckUnknownBin() {
    Try("no bin", [this] {
      const Answer answer = Ask(images_.front().frame, true, false);
      Add("no bin",
          fmt::format("{} {} in an image whose bin pose is unknown", answer.size(), noun()),
          answer.faults);
    });
  }

  void CheckWithoutPoses() {
    Try("unposed", [this] {
      const Answer answer = Ask(images_.front().frame, false);
      Add("unposed", fmt::format("{} grasps without poses", answer.size()), answer.faults);
    });
  }

  void CheckUnknownVerb() {
    MessageWriter request;
    request.BeginMap(1);
    request.Text("verb");
    request.Text("unknown");
    const std::vector<std::string> remedy{"answer an unknown verb with {\"error\": TEXT}"};
    try {
      client_->Ask(request);
      Add("errors", "an unknown verb is no error", remedy);
    } catch (const PluginError& error) {
      const bool reported = error.fault == PluginFault::kReported;
      Add("errors", reported ? "an unknown verb is reported as an error" : error.what(),
          reported ? std::vector<std::string>() : remedy);
    }
  }

  void CheckTimes() {
    Try("times", [this] {
      seconds_.clear();
      for (const Observation& image : images_) Ask(image.frame);
      const double first_s = seconds_.front();
      std::sort(seconds_.begin(), seconds_.end());
      const double longest_s = seconds_.back(), limit_s = job_.address.timeout_s;
      const std::string found =
          fmt::format("median {} of {} images, first {}, longest {}; limit {:g} s",
                      Milliseconds(seconds_[(seconds_.size() - 1) / 2]), seconds_.size(),
                      Milliseconds(first_s), Milliseconds(longest_s), limit_s);
      if (2 * longest_s < limit_s) return Add("times", found);
      Add("times", found, {"raise timeout_s to at least twice the longest time"});
    });
  }

  void CheckEnd() {
    const auto start = Clock::now();
    const std::string how = client_->Close();
    const double seconds = std::chrono::duration<double>(Clock::now() - start).count();
    const std::string found =
        fmt::format("the program {} {} after close", how, Milliseconds(seconds));
    if (how != "was stopped" && !how.starts_with("was ended")) return Add("end", found);
    Add("end", found, {"end the program at the verb close, and at the end of its input"});
  }

  const PluginCheckJob& job_;
  bool is_planner_;
  const EstimatorSpec estimator_;
  SimulatedCell cell_;
  Scene scene_;
  ObjectSet objects_;  // that the program knows
  std::vector<MetricModel> metrics_;
  std::vector<PluginGripper> grippers_;
  std::vector<Observation> images_;
  std::vector<double> seconds_;  // of the answers since the last check of times
  std::vector<PluginCheckup> checkups_;
  std::unique_ptr<PluginClient> client_;
};

}  // namespace

std::vector<PluginCheckup> CheckPlugin(const PluginCheckJob& job) {
  return PluginChecks(job).Run();
}

}  // namespace pickbed::eval
