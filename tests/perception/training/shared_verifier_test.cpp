#include "perception/training/shared_verifier.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "perception/networks/model_file.h"
#include "perception/networks/tensor_file.h"
#include "scenes/base/files.h"
#include "tests/support/error_of.h"
#include "tests/support/ray_cast_views.h"
#include "tests/support/synthetic_depth.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/tiny_training.h"

namespace pickbed::tests {
namespace {

using testing::HasSubstr;

class SharedVerifier : public testing::Test {
 protected:
  // A descriptor model of both objects, trained once.
  static std::filesystem::path Model() {
    static const TemporaryFolder folder;
    static const std::filesystem::path file = [] {
      RayCastViews views(Objects());
      const std::filesystem::path model = folder.path() / "model.net";
      TrainDescriptor({views, model, {}, false, {}, "test sensor", {}}, TinyOptions());
      return model;
    }();
    return file;
  }
  static ObjectSet Objects() {
    auto box = std::make_shared<ObjectModel>(
        *ObjectOf(BoxMesh({0.05, 0.04, 0.03}, Eigen::Vector3d::Zero())));
    box->name = "box";
    return {ObjectOf(BracketMesh()), box};
  }
  SharedVerifierJob Job(const std::string& name) {
    return {views_, Model(), folder_ / (name + ".net"), false, "test sensor", {}};
  }
  static std::vector<float> Logits(const VerifierNetwork& network) {
    std::vector<float> logits;
    for (int i = 0; i < kVerifyFeatures; ++i) {
      VerifyFeatures features{};
      features[i] = 1;
      logits.push_back(network.Logit(features));
    }
    return logits;
  }

  RayCastViews views_{Objects()};
  const TemporaryFolder temporary_;
  const std::filesystem::path folder_ = temporary_.path();
  VerifierTrainingOptions options_ = VerifierOptionsOf(TinyOptions());
};

TEST_F(SharedVerifier, StoppedAndResumedEqualsUninterrupted) {
  const SharedVerifierReport straight = TrainSharedVerifier(Job("straight"), options_);
  EXPECT_TRUE(straight.finished);
  EXPECT_EQ(straight.objects, 2);
  EXPECT_GT(straight.right, 0);
  EXPECT_LT(straight.right, straight.candidates);

  SharedVerifierJob job = Job("resumed");
  job.on_progress = [](std::string_view object, double) { return object != "box"; };
  const SharedVerifierReport stopped = TrainSharedVerifier(job, options_);
  EXPECT_FALSE(stopped.finished);
  EXPECT_EQ(stopped.objects, 1);
  EXPECT_FALSE(std::filesystem::exists(job.file));

  job.resume = true;
  job.on_progress = [](std::string_view object, double) { return object == "box"; };
  EXPECT_TRUE(TrainSharedVerifier(job, options_).finished);
  EXPECT_EQ(ReadFileBytes(job.file), ReadFileBytes(Job("straight").file));
  EXPECT_FALSE(std::filesystem::exists(UnfinishedSharedVerifier(job.file)));
}

TEST_F(SharedVerifier, ResumingWithOtherSettingsOrADamagedFileIsRefused) {
  SharedVerifierJob job = Job("a");
  job.on_progress = [](std::string_view object, double) { return object != "box"; };
  ASSERT_FALSE(TrainSharedVerifier(job, options_).finished);
  job.resume = true;
  options_.room_scenes = 3;
  EXPECT_THAT(ErrorOf([&] { TrainSharedVerifier(job, options_); }), HasSubstr("other settings"));
  options_.room_scenes = 2;
  const std::filesystem::path unfinished = UnfinishedSharedVerifier(job.file);
  std::filesystem::resize_file(unfinished, std::filesystem::file_size(unfinished) / 2);
  EXPECT_THAT(ErrorOf([&] { TrainSharedVerifier(job, options_); }), HasSubstr(unfinished.string()));
}

TEST_F(SharedVerifier, ResumingAfterAnImpossibleNumberOfObjectsIsRefused) {
  SharedVerifierJob job = Job("a");
  job.on_progress = [](std::string_view object, double) { return object != "box"; };
  ASSERT_FALSE(TrainSharedVerifier(job, options_).finished);
  job.resume = true;
  const std::filesystem::path unfinished = UnfinishedSharedVerifier(job.file);
  const std::string kind = "unfinished shared verifier";
  const TensorFile stored = TensorFile::Parse(ReadFileBytes(unfinished), kind, 1, 1);
  for (const int64_t objects : {-1, 3}) {
    TensorFile changed(kind, 1);
    changed.PutText("settings", stored.Text("settings"));
    changed.Put("objects", std::vector<int64_t>{objects}, {1});
    changed.Put("features", stored.Floats("features"), stored.Shape("features"));
    changed.Put("right", stored.Integers("right"), stored.Shape("right"));
    WriteFileAtomically(unfinished, changed.Bytes());
    EXPECT_THAT(ErrorOf([&] { TrainSharedVerifier(job, options_); }), HasSubstr("damaged"));
  }
}

TEST_F(SharedVerifier, TrainingOfAModelUsesItAndNoticesAnotherOne) {
  TrainSharedVerifier(Job("first"), options_);
  options_.seed = 1;
  TrainSharedVerifier(Job("second"), options_);
  TrainingOptions training = TinyOptions();
  training.verifier_room_scenes = 4;  // two folds
  TrainingJob job{views_, folder_ / "m.net", folder_ / "m.ckpt", false, {}, "s", {}};
  training.shared_verifier = Job("first").file.string();
  job.on_progress = [](const TrainingProgress& progress) { return progress.phase != "verifier"; };
  ASSERT_FALSE(TrainDescriptor(job, training).finished);
  job.on_progress = {};
  job.resume = true;
  // The settings are equal, but the content of the file is not.
  const std::filesystem::path aside = folder_ / "aside.net";
  std::filesystem::rename(Job("first").file, aside);
  std::filesystem::rename(Job("second").file, Job("first").file);
  EXPECT_THAT(ErrorOf([&] { TrainDescriptor(job, training); }), HasSubstr("other settings"));
  std::filesystem::rename(aside, Job("first").file);
  ASSERT_TRUE(TrainDescriptor(job, training).finished);
  const DescriptorModel model = LoadModel(job.model_file);
  training.shared_verifier = kNoSharedVerifier;
  const TrainingJob own_job{views_, folder_ / "own.net", {}, false, {}, "s", {}};
  ASSERT_TRUE(TrainDescriptor(own_job, training).finished);
  const DescriptorModel own = LoadModel(own_job.model_file);
  const std::vector<float> shared = Logits(LoadSharedVerifier(Job("first").file));
  ASSERT_EQ(model.verifiers.size(), 2u);
  for (size_t i = 0; i < model.verifiers.size(); ++i) {
    EXPECT_EQ(Logits(model.verifiers[i].known), Logits(own.verifiers[i].known));
    const std::vector<float> logits = Logits(model.verifiers[i].unknown);
    const std::vector<float> of_object = Logits(own.verifiers[i].unknown);
    for (size_t k = 0; k < logits.size(); ++k) {
      EXPECT_NEAR(logits[k], 0.5f * (of_object[k] + shared[k]), 1e-4);
    }
  }
  const auto shift = [&](int object) {
    return model.verifiers[object].calibrations.back().front().shift;
  };
  EXPECT_NE(shift(0), shift(1));
}

TEST_F(SharedVerifier, MayHaveAnotherNumberOfHiddenUnits) {
  TrainSharedVerifier(Job("a"), options_);
  TrainingOptions training = TinyOptions();
  training.shared_verifier = Job("a").file.string();
  training.verifier.hidden = 7;
  const TrainingJob job{views_, folder_ / "m.net", {}, false, {}, "s", {}};
  ASSERT_TRUE(TrainDescriptor(job, training).finished);
  const Verifier verifier = LoadModel(job.model_file).verifiers.front();
  EXPECT_EQ(verifier.unknown.b1.size(), 7 + 24);
  EXPECT_EQ(verifier.known.b1.size(), 7 + 24);  // 24 of them without an effect
  EXPECT_TRUE(verifier.known.w2.tail(24).isZero(0));
}

TEST_F(SharedVerifier, FilesThatAreNoSharedVerifierAreRefused) {
  const auto error = [&](const std::filesystem::path& file) {
    return ErrorOf([&] { LoadSharedVerifier(file); });
  };
  EXPECT_THAT(error(folder_ / "none.net"), HasSubstr("does not exist"));
  EXPECT_THAT(error(Model()), HasSubstr("pickbed train verifier"));
  TrainSharedVerifier(Job("cut"), options_);
  const std::filesystem::path file = Job("cut").file;
  std::filesystem::resize_file(file, std::filesystem::file_size(file) - 1);
  EXPECT_THAT(error(file), HasSubstr(file.string()));
}

}  // namespace
}  // namespace pickbed::tests
