#include "perception/training/training.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/resource.h>

#include <chrono>
#include <filesystem>
#include <numeric>
#include <optional>
#include <thread>

#include "perception/networks/model_file.h"
#include "perception/training/checkpoint.h"
#include "scenes/base/error.h"
#include "scenes/base/files.h"
#include "tests/support/error_of.h"
#include "tests/support/ray_cast_views.h"
#include "tests/support/synthetic_depth.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/tiny_training.h"

namespace pickbed::tests {
namespace {

using testing::HasSubstr;

class Training : public testing::Test {
 protected:
  TrainingJob Job(const std::string& name) {
    return {views_, folder_ / (name + ".net"), folder_ / (name + ".ckpt"), false, {}, "test sensor",
            {}};
  }

  RayCastViews views_{{ObjectOf(BracketMesh())}};
  const TemporaryFolder temporary_;
  const std::filesystem::path folder_ = temporary_.path();
};

double Mean(const std::vector<double>& values, size_t first, size_t count) {
  return std::accumulate(values.begin() + first, values.begin() + first + count, 0.0) /
         static_cast<double>(count);
}

TEST_F(Training, LossFallsAndTheFileDescribesTheTraining) {
  std::vector<std::string> phases;
  TrainingJob job = Job("model");
  job.on_progress = [&](const TrainingProgress& progress) {
    if (phases.empty() || phases.back() != progress.phase) phases.push_back(progress.phase);
    EXPECT_LE(progress.done, progress.total);
    // The time left is unknown at the start of a phase and zero at its end.
    if (progress.done == 0) {
      EXPECT_EQ(progress.seconds_left, -1);
    } else if (progress.done == progress.total) {
      EXPECT_EQ(progress.seconds_left, 0);
    } else {
      EXPECT_GT(progress.seconds_left, 0);
    }
    return true;
  };
  const TrainingReport report = TrainDescriptor(job, TinyOptions());
  EXPECT_TRUE(report.finished);
  ASSERT_EQ(report.loss_history.size(), 24u);
  EXPECT_LT(Mean(report.loss_history, 16, 8), Mean(report.loss_history, 0, 8));
  EXPECT_EQ(phases, (std::vector<std::string>{"views", "network", "verifier"}));

  const DescriptorModel model = LoadModel(job.model_file);
  EXPECT_EQ(model.info.iterations, 24);
  EXPECT_EQ(model.info.sensor, "test sensor");
  EXPECT_EQ(model.info.network.descriptor, 8);
  EXPECT_THAT(model.info.training, HasSubstr("batch: 24"));
  ASSERT_EQ(model.info.objects.size(), 1u);
  EXPECT_EQ(model.info.objects[0].mesh_hash, views_.objects()[0]->mesh_hash);
  EXPECT_EQ(model.info.objects[0].diameter_m, views_.objects()[0]->diameter_m);
  ASSERT_EQ(model.verifiers.size(), 1u);
  EXPECT_EQ(model.verifiers[0].known.w1.cols(), kVerifyFeatures);
  EXPECT_LT(std::filesystem::file_size(job.model_file), 1u << 20);
}

TEST_F(Training, SameSeedSameFile) {
  TrainingOptions options = TinyOptions();
  TrainDescriptor(Job("a"), options);
  TrainDescriptor(Job("b"), options);
  EXPECT_EQ(LoadModel(Job("a").model_file).hash, LoadModel(Job("b").model_file).hash);
  options.seed = 1;
  TrainDescriptor(Job("c"), options);
  EXPECT_NE(LoadModel(Job("a").model_file).hash, LoadModel(Job("c").model_file).hash);
}

TEST_F(Training, StoppedAndResumedEqualsUninterrupted) {
  const TrainingReport straight = TrainDescriptor(Job("straight"), TinyOptions());

  TrainingJob job = Job("resumed");
  job.on_progress = [](const TrainingProgress& progress) {
    return progress.phase != "network" || progress.done < 11;
  };
  const TrainingReport stopped = TrainDescriptor(job, TinyOptions());
  EXPECT_FALSE(stopped.finished);
  EXPECT_EQ(stopped.loss_history.size(), 11u);
  EXPECT_FALSE(std::filesystem::exists(job.model_file));

  job.on_progress = {};
  job.resume = true;
  const TrainingReport resumed = TrainDescriptor(job, TinyOptions());
  EXPECT_TRUE(resumed.finished);
  EXPECT_EQ(resumed.loss_history, straight.loss_history);
  EXPECT_EQ(LoadModel(job.model_file).hash, LoadModel(Job("straight").model_file).hash);
}

TEST_F(Training, WrongOrDamagedCheckpointIsRefusedAtTheStart) {
  TrainingJob job = Job("model");
  job.resume = true;
  EXPECT_THAT(ErrorOf([&] { TrainDescriptor(job, TinyOptions()); }), HasSubstr("model.ckpt"));

  WriteCheckpoint(job.checkpoint, {"other settings", 3, {1, 2, 3}, {}, "state", {}});
  EXPECT_THAT(ErrorOf([&] { TrainDescriptor(job, TinyOptions()); }), HasSubstr("other settings"));

  const std::string bytes = ReadFileBytes(job.checkpoint);
  WriteFileAtomically(job.checkpoint, bytes.substr(0, bytes.size() - 2));
  EXPECT_THAT(ErrorOf([&] { TrainDescriptor(job, TinyOptions()); }), HasSubstr("damaged"));
  EXPECT_EQ(views_.isolated_calls(), 0);
}

// Limits the size of a file to `bytes`, which looks like a full disk to the program.
class FullDisk {
 public:
  explicit FullDisk(rlim_t bytes) {
    getrlimit(RLIMIT_FSIZE, &before_);
    const rlimit limit{bytes, before_.rlim_max};
    setrlimit(RLIMIT_FSIZE, &limit);
  }
  ~FullDisk() {
    setrlimit(RLIMIT_FSIZE, &before_);
    signal(SIGXFSZ, handler_);
  }

 private:
  rlimit before_{};
  sighandler_t handler_ =
      signal(SIGXFSZ, SIG_IGN);  // a write then fails and does not kill the process
};

TEST_F(Training, FullDiskKeepsTheLastGoodCheckpoint) {
  TrainingJob job = Job("model");
  std::optional<FullDisk> full;
  int steps = 0;
  job.on_progress = [&](const TrainingProgress& progress) {
    steps += progress.phase == "network";
    // After the checkpoint of step 8 and before the one of step 16.
    if (progress.phase == "network" && progress.done == 12) full.emplace(20000);
    return true;
  };
  const std::string error = ErrorOf([&] { TrainDescriptor(job, TinyOptions()); });
  full.reset();
  EXPECT_THAT(error, HasSubstr("model.ckpt"));
  EXPECT_THAT(error, HasSubstr("File too large"));
  EXPECT_GE(steps, 12);
  int files = 0;
  for ([[maybe_unused]] const auto& entry : std::filesystem::directory_iterator(folder_)) ++files;
  EXPECT_EQ(files, 1) << "a broken file was left beside the checkpoint";

  job.on_progress = {};
  job.resume = true;
  const TrainingReport resumed = TrainDescriptor(job, TinyOptions());
  EXPECT_TRUE(resumed.finished);
  EXPECT_EQ(resumed.loss_history, TrainDescriptor(Job("straight"), TinyOptions()).loss_history);
}

// Views that take `delay` each, so that clutter scenes arrive late or early.
class SlowViews : public RayCastViews {
 public:
  SlowViews(ObjectSet objects, std::chrono::milliseconds delay)
      : RayCastViews(std::move(objects)), delay_(delay) {}
  std::vector<LabelledView> ClutterScene(const ClutterSceneRequest& request) override {
    std::this_thread::sleep_for(delay_);
    return RayCastViews::ClutterScene(request);
  }

 private:
  std::chrono::milliseconds delay_;
};

TEST_F(Training, WeightsDoNotDependOnTheSpeedOfRendering) {
  TrainingOptions options = TinyOptions();
  options.clutter_scenes = 6;
  const TrainingReport quick = TrainDescriptor(Job("quick"), options);
  SlowViews slow_views(views_.objects(), std::chrono::milliseconds(150));
  const TrainingJob slow{slow_views, folder_ / "slow.net", {}, false, {}, "test sensor", {}};
  TrainDescriptor(slow, options);
  EXPECT_EQ(LoadModel(Job("quick").model_file).hash, LoadModel(slow.model_file).hash);
  EXPECT_EQ(ReadFileBytes(Job("quick").model_file), ReadFileBytes(slow.model_file));
}

TEST_F(Training, HeldOutRecallIsMeasuredAndSaved) {
  TrainingJob job = Job("model");
  double shown = -1;
  job.on_progress = [&](const TrainingProgress& progress) {
    shown = progress.recall_at_1;
    return true;
  };
  const TrainingReport report = TrainDescriptor(job, TinyOptions());
  std::vector<int> iterations;
  for (const HeldOutRecall& recall : report.recall_history) iterations.push_back(recall.iteration);
  EXPECT_EQ(iterations, (std::vector{0, 8, 16, 24}));
  const HeldOutRecall& last = report.recall_history.back();
  EXPECT_EQ(shown, last.at_1);
  EXPECT_GE(last.at_8, last.at_1);
  const ModelInfo info = LoadModel(job.model_file).info;
  EXPECT_NEAR(info.recall_at_1, last.at_1, 1e-9);
  EXPECT_NEAR(info.objects[0].recall_at_8, last.object_at_8[0], 1e-9);
  ASSERT_EQ(report.pairs.size(), 1u);
  EXPECT_GT(report.pairs[0].size(), 0u);
  EXPECT_EQ(report.answers.size(), report.held_out.queries[0].size());
}

TEST_F(Training, PlateauEndsTrainingEarlyAlsoAfterResume) {
  TrainingOptions options = TinyOptions();
  options.iterations = 200;
  options.held_out.every = 10;
  options.held_out.patience = 2;
  options.held_out.gain = 1;  // nothing counts as a gain after the first measurement
  options.held_out.cooling = 0.1;
  const TrainingReport straight = TrainDescriptor(Job("straight"), options);
  EXPECT_EQ(straight.plateau_iteration, 20);
  EXPECT_EQ(straight.loss_history.size(), 40u);  // plus 20 steps of cooling

  TrainingJob job = Job("resumed");
  int reports = 0;
  job.on_progress = [&](const TrainingProgress& progress) {
    reports += progress.phase == "network";
    return reports < 27;  // during cooling
  };
  EXPECT_FALSE(TrainDescriptor(job, options).finished);
  job.on_progress = {};
  job.resume = true;
  EXPECT_EQ(TrainDescriptor(job, options).loss_history, straight.loss_history);
  EXPECT_EQ(LoadModel(job.model_file).hash, LoadModel(Job("straight").model_file).hash);
}

TEST_F(Training, StopBeforeTheFirstStepLeavesNoCheckpoint) {
  TrainingJob job = Job("model");
  job.on_progress = [](const TrainingProgress&) { return false; };
  const TrainingReport report = TrainDescriptor(job, TinyOptions());
  EXPECT_FALSE(report.finished);
  EXPECT_FALSE(report.has_checkpoint);
  EXPECT_FALSE(std::filesystem::exists(job.checkpoint));
}

// The report says what a resumed training begins with, which is not all that was done.
TEST_F(Training, AStopWithinAVerifierKeepsTheNetworkOnly) {
  TrainingJob job = Job("model");
  bool is_verifier = false;
  job.on_progress = [&](const TrainingProgress& progress) {
    return !(is_verifier = progress.phase == "verifier");
  };
  const TrainingReport report = TrainDescriptor(job, TinyOptions());
  EXPECT_TRUE(is_verifier);
  EXPECT_TRUE(report.has_checkpoint);
  EXPECT_EQ(report.kept_steps, TinyOptions().iterations);
  EXPECT_EQ(report.kept_verifiers, 0);
  EXPECT_EQ(report.new_objects, 1);
}

TEST_F(Training, FailureOfTheViewsIsRethrown) {
  class Broken : public RayCastViews {
   public:
    using RayCastViews::RayCastViews;
    std::vector<LabelledView> ClutterScene(const ClutterSceneRequest&) override {
      throw std::runtime_error("no settled clutter scene");
    }
  } broken(views_.objects());
  TrainingJob job{broken, folder_ / "m.net", {}, false, {}, "", {}};
  EXPECT_THROW(TrainDescriptor(job, TinyOptions()), std::runtime_error);
}

// An object is added to a model that was trained for another one.
class AddedObject : public Training {
 protected:
  std::shared_ptr<ObjectModel> Named(const std::string& name, TriangleMesh mesh, uint64_t hash) {
    auto object = std::make_shared<ObjectModel>(*ObjectOf(std::move(mesh)));
    object->name = name;
    object->mesh_hash = hash;
    return object;
  }
  std::shared_ptr<ObjectModel> old_ = Named("old", BracketMesh(), 1);
  std::shared_ptr<ObjectModel> new_ = Named("new", ScaledY(BracketMesh(), 0.5), 2);
  static TriangleMesh ScaledY(TriangleMesh mesh, double factor) {
    for (Eigen::Vector3d& vertex : mesh.vertices) vertex.y() *= factor;
    return mesh;
  }
};

TEST_F(AddedObject, OldObjectsAreRehearsedAndKeepTheirVerifiers) {
  RayCastViews first({old_});
  TrainingJob job{first, folder_ / "old.net", {}, false, {}, "test sensor", {}};
  TrainDescriptor(job, TinyOptions());
  const DescriptorModel before = LoadModel(job.model_file);

  RayCastViews both({new_, old_});
  TrainingOptions options = TinyOptions();
  options.rehearsal = 0.5;
  TrainingJob added{both, folder_ / "both.net", {}, false, job.model_file, "test sensor", {}};
  const TrainingReport report = TrainDescriptor(added, options);
  EXPECT_EQ(report.rehearsed, (std::vector<uint8_t>{0, 1}));
  EXPECT_EQ(report.loss_history.size(), 36u);  // 24 for the new object, half for the old one
  ASSERT_EQ(report.pairs.size(), 2u);
  EXPECT_GT(report.pairs[1].size(), 0u) << "the old object is in no batch";
  const DescriptorModel after = LoadModel(added.model_file);
  EXPECT_NE(after.network_hash, before.network_hash);
  VerifyFeatures features{};
  features[3] = 0.7f;
  EXPECT_EQ(after.verifiers.at(1).Score(features), before.verifiers.at(0).Score(features));
  EXPECT_EQ(after.info.objects[1].verifier_auc, before.info.objects[0].verifier_auc);
}

TEST_F(AddedObject, NoStepsKeepTheOldNetwork) {
  RayCastViews first({old_});
  TrainingJob job{first, folder_ / "old.net", {}, false, {}, "test sensor", {}};
  TrainDescriptor(job, TinyOptions());
  RayCastViews both({new_, old_});
  TrainingOptions options = TinyOptions();
  options.iterations = 0;
  TrainingJob added{both, folder_ / "both.net", {}, false, job.model_file, "test sensor", {}};
  TrainDescriptor(added, options);
  EXPECT_EQ(LoadModel(added.model_file).network_hash, LoadModel(job.model_file).network_hash);
}

TEST_F(AddedObject, ResumeSkipsFinishedVerifiers) {
  RayCastViews both({new_, old_});
  const auto job_of = [&](const char* name) {
    return TrainingJob{
        both, folder_ / name, folder_ / (std::string(name) + ".ckpt"), false, {}, "test sensor",
        {}};
  };
  TrainingJob straight = job_of("straight.net");
  TrainDescriptor(straight, TinyOptions());

  TrainingJob job = job_of("resumed.net");
  const auto second = [](const TrainingProgress& p) { return 2 * p.done >= p.total; };
  job.on_progress = [&](const TrainingProgress& p) { return p.phase != "verifier" || !second(p); };
  EXPECT_FALSE(TrainDescriptor(job, TinyOptions()).finished);
  job.resume = true;
  bool again = false;
  job.on_progress = [&](const TrainingProgress& p) {
    again = again || (p.phase == "verifier" && !second(p));
    return true;
  };
  EXPECT_TRUE(TrainDescriptor(job, TinyOptions()).finished);
  EXPECT_FALSE(again);
  EXPECT_EQ(LoadModel(job.model_file).hash, LoadModel(straight.model_file).hash);
}

TEST_F(AddedObject, ChangedMeshIsLearnedAsANewObject) {
  RayCastViews first({old_});
  TrainingJob job{first, folder_ / "old.net", {}, false, {}, "test sensor", {}};
  TrainDescriptor(job, TinyOptions());
  RayCastViews changed({Named("old", ScaledY(BracketMesh(), 0.7), 3)});
  TrainingJob again{changed, folder_ / "again.net", {}, false, job.model_file, "test sensor", {}};
  const TrainingReport report = TrainDescriptor(again, TinyOptions());
  EXPECT_EQ(report.rehearsed, (std::vector<uint8_t>{0}));
  EXPECT_EQ(LoadModel(again.model_file).info.objects[0].mesh_hash, 3u);
}

TEST_F(Training, ObjectThatIsNeverVisibleIsNamed) {
  TrainingOptions options = TinyOptions();
  options.positive_pairs.min_visible = 1;
  options.clutter_scenes = 1;
  class Unseen : public RayCastViews {
   public:
    using RayCastViews::RayCastViews;
    std::vector<LabelledView> ClutterScene(const ClutterSceneRequest& request) override {
      std::vector<LabelledView> result = RayCastViews::ClutterScene(request);
      for (LabelledView& view : result) {
        for (LabelledInstance& instance : view.instances) instance.visible_fraction = 0.5;
      }
      return result;
    }
  } unseen(views_.objects());
  TrainingJob job{unseen, folder_ / "m.net", {}, false, {}, "", {}};
  EXPECT_THAT(ErrorOf([&] { TrainDescriptor(job, options); }),
              HasSubstr("object 'test part' was never visible enough"));
}

}  // namespace
}  // namespace pickbed::tests
