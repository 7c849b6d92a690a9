#include "perception/training.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <numeric>

#include "perception/checkpoint.h"
#include "perception/torch_model_file.h"
#include "perception/verifier_training.h"
#include "scenes/check.h"
#include "scenes/files.h"
#include "tests/support/ray_cast_views.h"
#include "tests/support/synthetic_depth.h"
#include "tests/support/temporary_folder.h"

namespace pickbed {
namespace {

using testing::HasSubstr;

// Seconds of training: enough to learn something, not to be good.
TrainingOptions TinyOptions() {
  TrainingOptions options;
  options.piles = 4;
  options.views_per_pile = 1;
  options.twins.patches_per_view = 60;
  options.verifier_entries = 480;
  options.iterations = 24;
  options.batch = 24;
  options.verifier_piles = 2;
  options.checkpoint_every = 8;
  options.network.descriptor = 8;
  options.verifier.iterations = 50;
  options.candidates.points = 40;
  options.candidates.candidates = 30;
  options.candidates.min_candidates = 10;
  return options;
}

class Training : public testing::Test {
 protected:
  TrainingJob Job(const std::string& name) {
    return {views_, folder_ / (name + ".pt"), folder_ / (name + ".ckpt"), false, {}, "test sensor",
            {}};
  }
  std::string ErrorOf(const std::function<void()>& run) {
    try {
      run();
    } catch (const InputError& error) {
      return error.what();
    }
    return "no error";
  }

  RayCastViews views_{{ObjectOf(BracketMesh())}};
  const TemporaryFolder temporary_;
  const std::filesystem::path folder_ = temporary_.path();
};

double Mean(const std::vector<double>& values, size_t first, size_t count) {
  return std::accumulate(values.begin() + first, values.begin() + first + count, 0.0) /
         static_cast<double>(count);
}

TEST_F(Training, LossFallsAndTheFileHoldsWhatWasTrained) {
  std::vector<std::string> phases;
  TrainingJob job = Job("model");
  job.on_progress = [&](const TrainingProgress& progress) {
    if (phases.empty() || phases.back() != progress.phase) phases.push_back(progress.phase);
    EXPECT_LE(progress.done, progress.total);
    EXPECT_GE(progress.seconds_left, 0);
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
  EXPECT_EQ(model.verifiers[0].w1.cols(), kVerifyFeatures);
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

TEST_F(Training, ForeignOrDamagedCheckpointIsRefusedBeforeAnyWork) {
  TrainingJob job = Job("model");
  job.resume = true;
  EXPECT_THAT(ErrorOf([&] { TrainDescriptor(job, TinyOptions()); }), HasSubstr("model.ckpt"));

  WriteCheckpoint(job.checkpoint, {"other settings", 3, {1, 2, 3}, "state"});
  EXPECT_THAT(ErrorOf([&] { TrainDescriptor(job, TinyOptions()); }), HasSubstr("other settings"));

  const std::string bytes = ReadFileBytes(job.checkpoint);
  WriteFileAtomically(job.checkpoint, bytes.substr(0, bytes.size() - 2));
  EXPECT_THAT(ErrorOf([&] { TrainDescriptor(job, TinyOptions()); }), HasSubstr("damaged"));
  EXPECT_EQ(views_.isolated_calls(), 0);
}

TEST_F(Training, CheckpointSurvivesTheRoundTrip) {
  const Checkpoint saved{"key", 7, {0.5, 0.25}, std::string("\0state\xff", 7)};
  WriteCheckpoint(folder_ / "c", saved);
  const Checkpoint read = ReadCheckpoint(folder_ / "c", "key");
  EXPECT_EQ(read.iteration, saved.iteration);
  EXPECT_EQ(read.loss_history, saved.loss_history);
  EXPECT_EQ(read.training_state, saved.training_state);
}

TEST_F(Training, PartNeverSeenIsNamed) {
  TrainingOptions options = TinyOptions();
  options.twins.min_visible = 1;
  options.piles = 1;
  class Unseen : public RayCastViews {
   public:
    using RayCastViews::RayCastViews;
    std::vector<LabelledView> Pile(const PileRequest& request) override {
      std::vector<LabelledView> result = RayCastViews::Pile(request);
      for (LabelledView& view : result) {
        for (LabelledInstance& instance : view.instances) instance.visible_fraction = 0.5;
      }
      return result;
    }
  } unseen(views_.objects());
  TrainingJob job{unseen, folder_ / "m.pt", {}, false, {}, "", {}};
  EXPECT_THAT(ErrorOf([&] { TrainDescriptor(job, options); }),
              HasSubstr("part 'test part' was never seen well enough"));
}

class ModelFile : public Training {
 protected:
  // A model without training.
  std::filesystem::path Untrained() {
    const std::filesystem::path file = folder_ / "model.pt";
    ModelInfo info;
    info.objects = {{"test part", views_.objects()[0]->mesh_hash, 0.08, 0.064}};
    info.network = TinyOptions().network;
    Verifier verifier;
    verifier.mean = Eigen::VectorXf::LinSpaced(kVerifyFeatures, 0, 1);
    verifier.scale = Eigen::VectorXf::Ones(kVerifyFeatures);
    verifier.w1 = Eigen::MatrixXf::Random(24, kVerifyFeatures);
    verifier.b1 = Eigen::VectorXf::LinSpaced(24, -1, 1);
    verifier.w2 = Eigen::VectorXf::LinSpaced(24, 1, -1);
    verifier.b2 = 0.25f;
    SaveModel(file, info, DescriptorNetwork(info.network, 3), {verifier});
    verifier_ = verifier;
    return file;
  }
  Verifier verifier_;
};

TEST_F(ModelFile, VerifierAndWeightsSurviveTheRoundTrip) {
  const DescriptorModel model = LoadModel(Untrained());
  EXPECT_EQ(model.network.Weights(), DescriptorNetwork({"convolutional", 8}, 3).Weights());
  VerifyFeatures features{};
  features[3] = 0.7f;
  EXPECT_EQ(model.verifiers.at(0).Score(features), verifier_.Score(features));
}

TEST_F(ModelFile, DamagedFilesAreRefusedWithTheirName) {
  const std::filesystem::path file = Untrained();
  const std::string bytes = ReadFileBytes(file);
  for (const double share : {0.0, 0.1, 0.5, 0.9, 0.999}) {
    WriteFileAtomically(file, bytes.substr(0, static_cast<size_t>(share * bytes.size())));
    const std::string error = ErrorOf([&] { LoadModel(file); });
    EXPECT_THAT(error, HasSubstr("model.pt")) << "cut to " << share;
    EXPECT_THAT(error, HasSubstr("pickbed train"));
    EXPECT_EQ(error.find('\n'), std::string::npos) << error;
  }
  int refused = 0;
  for (size_t place = bytes.size() / 4; place < bytes.size() * 3 / 4; place += bytes.size() / 20) {
    std::string damaged = bytes;
    damaged[place] ^= 0x10;
    WriteFileAtomically(file, damaged);
    refused += ErrorOf([&] { LoadModel(file); }) != "no error";
  }
  EXPECT_GE(refused, 10) << "a flipped bit among the weights goes unnoticed";
  WriteFileAtomically(file, "hello");
  EXPECT_THAT(ErrorOf([&] { LoadModel(file); }), HasSubstr("no model"));
  EXPECT_THAT(ErrorOf([&] { LoadModel(folder_ / "absent.pt"); }), HasSubstr("absent.pt"));
}

TEST_F(ModelFile, ForeignPartsAndChangedMeshesAreNamed) {
  const DescriptorModel model = LoadModel(Untrained());
  const ObjectSet& known = views_.objects();
  EXPECT_EQ(TrainedParts(model.info.objects, known, "m.pt"), std::vector{0});
  auto changed = std::make_shared<ObjectModel>(*known[0]);
  changed->mesh_hash += 1;
  EXPECT_THAT(ErrorOf([&] { TrainedParts(model.info.objects, {changed}, "m.pt"); }),
              HasSubstr("m.pt: the mesh of part 'test part' has changed"));
  changed->name = "widget";
  EXPECT_THAT(ErrorOf([&] { TrainedParts(model.info.objects, {changed}, "m.pt"); }),
              HasSubstr("m.pt: not trained for part 'widget' (knows test part)"));
}

TEST(TrainVerifier, LearnsASeparableRuleAndRefusesOneSidedExamples) {
  Rng rng(1);
  VerifierExamples examples;
  for (int i = 0; i < 1500; ++i) {
    VerifyFeatures features;
    for (float& feature : features) feature = static_cast<float>(rng.Normal());
    examples.right.push_back(features[0] * features[1] > 0.1f);  // not linear
    examples.features.push_back(features);
  }
  examples.held_out_from = 1200;
  VerifierOptions options;
  options.iterations = 400;
  const TrainedVerifier trained = TrainVerifier(examples, options, 0);
  EXPECT_GT(trained.auc, 0.95);
  VerifyFeatures right{};
  right[0] = right[1] = 1.5f;
  EXPECT_GT(trained.verifier.Score(right), 0.8);
  right[1] = -1.5f;
  EXPECT_LT(trained.verifier.Score(right), 0.2);
  examples.right.assign(examples.right.size(), 1);
  EXPECT_THROW(TrainVerifier(examples, options, 0), InputError);
}

// Poses that are right with P = 1 / (1 + exp(-(2 logit + 1))) while the score claims
// 1 / (1 + exp(-logit)).
TEST(Calibrate, FindsAPlantedRule) {
  Rng rng(3);
  std::vector<ScoredPose> poses(4000);
  for (ScoredPose& pose : poses) {
    pose.logit = rng.Uniform(-3, 3);
    pose.right = rng.Uniform() < 1 / (1 + std::exp(-(2 * pose.logit + 1)));
  }
  Verifier verifier;
  Calibrate(poses, verifier);
  EXPECT_NEAR(verifier.calibration_scale, 2, 0.2);
  EXPECT_NEAR(verifier.calibration_shift, 1, 0.2);
  Verifier untouched;
  Calibrate({}, untouched);
  EXPECT_EQ(untouched.calibration_scale, 1);
  EXPECT_EQ(untouched.calibration_shift, 0);
}

TEST(AreaUnderRoc, CountsOrderedPairs) {
  EXPECT_DOUBLE_EQ(AreaUnderRoc({0.1, 0.2, 0.8, 0.9}, {0, 0, 1, 1}), 1.0);
  EXPECT_DOUBLE_EQ(AreaUnderRoc({0.1, 0.2, 0.8, 0.9}, {1, 1, 0, 0}), 0.0);
  EXPECT_DOUBLE_EQ(AreaUnderRoc({0.5, 0.5, 0.5}, {0, 1, 0}), 0.5);
  EXPECT_DOUBLE_EQ(AreaUnderRoc({0.1, 0.4, 0.3, 0.8}, {0, 0, 1, 1}), 0.75);
  EXPECT_DOUBLE_EQ(AreaUnderRoc({0.1, 0.2}, {1, 1}), 0.5);
}

}  // namespace
}  // namespace pickbed
