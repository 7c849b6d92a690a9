// Estimators kehl and doumanoglou, trained for seconds on unoccluded instances.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <numeric>

#include "perception/candidates/estimate_trace.h"
#include "perception/estimators/descriptor.h"
#include "perception/estimators/estimator_training.h"
#include "perception/networks/model_file.h"
#include "perception/training/training.h"
#include "scenes/base/files.h"
#include "tests/support/error_of.h"
#include "tests/support/ray_cast_views.h"
#include "tests/support/share_found.h"
#include "tests/support/synthetic_depth.h"
#include "tests/support/temporary_folder.h"

namespace pickbed::tests {
namespace {

using testing::HasSubstr;

TrainingOptions Quick(const std::string& method) {
  TrainingOptions options = EstimatorNamed(method).make_training()->PatchNetworkOptions();
  options.clutter_scenes = 24;
  options.views_per_scene = 1;
  options.positive_pairs.patches_per_view = 120;
  options.verifier_entries = 3000;
  options.iterations = 240;
  options.batch = 64;
  options.verifier_clutter_scenes = 6;
  options.verifier_room_scenes = 0;
  options.network.descriptor = 16;
  options.candidates.points = 150;
  options.candidates.candidates = 120;
  options.fast_candidates = options.candidates;
  options.held_out.clutter_scenes = 2;
  options.held_out.queries = 40;
  options.held_out.book_views = 20;
  return options;
}

class PublishedMethod : public testing::TestWithParam<const char*> {
 protected:
  TrainingReport Train(const std::string& name, const TrainingOptions& options) {
    return TrainDescriptor({views_, folder_ / name, {}, false, {}, "test", {}}, options);
  }
  EstimatorSetup Setup(const std::string& model) {
    EstimatorSetup setup;
    setup.objects = views_.objects();
    setup.spec.name = GetParam();
    setup.spec.model = folder_ / model;
    setup.spec.min_score = 0;
    setup.intrinsics = SmallCamera();
    setup.working_distance_m = RayCastViews::kDistanceM;
    setup.views = &views_;
    setup.cache_dir = folder_;
    return setup;
  }
  RayCastViews views_{{ObjectOf(BracketMesh())}};
  const TemporaryFolder temporary_;
  const std::filesystem::path folder_ = temporary_.path();
};

TEST_P(PublishedMethod, LearnsAndFindsUnoccludedInstances) {
  const TrainingReport report = Train("model.net", Quick(GetParam()));
  ASSERT_TRUE(report.finished);
  const std::vector<double>& losses = report.loss_history;
  const auto mean = [&](size_t first) {
    return std::accumulate(losses.begin() + first, losses.begin() + first + 20, 0.0) / 20;
  };
  EXPECT_LT(mean(losses.size() - 20), 0.8 * mean(0));
  EXPECT_EQ(LoadModel(folder_ / "model.net").info.network.kind, Quick(GetParam()).network.kind);

  const auto estimator = MakeEstimator(Setup("model.net"));
  EXPECT_GE(ShareFound(*estimator, views_), 0.5);

  // An unreadable file and another mesh are reported with the command that repairs them.
  const std::string bytes = ReadFileBytes(folder_ / "model.net");
  WriteFileAtomically(folder_ / "cut.net", bytes.substr(0, bytes.size() / 2));
  const std::string command = std::string("`pickbed train ") + GetParam();
  EXPECT_THAT(ErrorOf([&] { MakeEstimator(Setup("cut.net")); }),
              testing::AllOf(HasSubstr("cut.net"), HasSubstr(command)));
  EstimatorSetup changed = Setup("model.net");
  auto object = std::make_shared<ObjectModel>(*changed.objects[0]);
  object->mesh_hash += 1;
  changed.objects = {object};
  EXPECT_THAT(
      ErrorOf([&] { MakeEstimator(changed); }),
      testing::AllOf(HasSubstr("the mesh of object 'test part' has changed"), HasSubstr(command)));
}

TEST_P(PublishedMethod, SameSeedSameFileAndOtherMethodIsRefused) {
  TrainingOptions options = Quick(GetParam());
  options.iterations = 6;
  options.clutter_scenes = 3;
  options.verifier_clutter_scenes = 2;
  options.verifier_room_scenes = 0;
  Train("a.net", options);
  Train("b.net", options);
  EXPECT_EQ(ReadFileBytes(folder_ / "a.net"), ReadFileBytes(folder_ / "b.net"));
  options.network.kind = "convolutional";
  options.candidates.votes = "neighbors";
  Train("other.net", options);
  EXPECT_THAT(ErrorOf([&] { MakeEstimator(Setup("other.net")); }),
              testing::AllOf(HasSubstr("other.net"), HasSubstr("kind convolutional")));
  options.candidates.votes = "regressed";
  EXPECT_THAT(ErrorOf([&] { Train("none.net", options); }), HasSubstr("regresses no poses"));
}

INSTANTIATE_TEST_SUITE_P(Methods, PublishedMethod, testing::Values("kehl", "doumanoglou"));

// Two networks use the same patches: one for the codebook look-up, the other for regression.
TEST(UnionOfVotes, EachPatchCastsVotesOfBothNetworks) {
  const TemporaryFolder temporary;
  RayCastViews views({ObjectOf(BracketMesh())});
  const auto train = [&](const std::string& method, const std::string& name, double diameters) {
    TrainingOptions options = Quick(method);
    options.iterations = 6;
    options.clutter_scenes = 3;
    options.verifier_clutter_scenes = 2;
    options.verifier_room_scenes = 0;
    options.patch_diameters = diameters;
    TrainDescriptor({views, temporary.path() / name, {}, false, {}, "test", {}}, options);
  };
  const double side = TrainingOptions().patch_diameters;
  train("descriptor", "look_up.net", side);
  train("doumanoglou", "regression.net", side);
  train("doumanoglou", "narrow.net", 0.5 * side);
  EstimatorSetup setup;
  setup.objects = views.objects();
  setup.intrinsics = SmallCamera();
  setup.working_distance_m = RayCastViews::kDistanceM;
  setup.views = &views;
  DescriptorOptions options = OptionsForMode("fast");
  options.code_entries = 500;
  options.candidates.votes = "both";
  options.candidates.min_share = 0;
  options.candidates.points = 60;
  const auto make = [&](const std::filesystem::path& regression) {
    return MakeLearnedEstimator(setup, options,
                                {temporary.path() / "look_up.net", "", kTrainCommand, regression});
  };
  const LabelledView view = views.ClutterScene({5000, 1}).front();
  EstimateTrace trace;
  Rng rng(1);
  make(temporary.path() / "regression.net")->Estimate({view.frame, OutOfSightBin(), &trace}, rng);
  ASSERT_FALSE(trace.patches.empty());
  const size_t votes_per_patch = options.candidates.neighbors + 1;
  ASSERT_EQ(trace.votes.size(), trace.patches.size() * votes_per_patch);
  for (size_t i = 0; i < trace.votes.size(); ++i) {
    EXPECT_EQ(trace.votes[i].patch, static_cast<int>(i / votes_per_patch));
  }
  EXPECT_THAT(ErrorOf([&] { make({}); }), HasSubstr("regresses no poses"));
  EXPECT_THAT(ErrorOf([&] { make(temporary.path() / "narrow.net"); }),
              testing::AllOf(HasSubstr("narrow.net"), HasSubstr("same patch_diameters")));
}

TEST(PublishedSettings, OutOfRangeSettingsReportTheRange) {
  TrainingOptions options;
  const auto error_of = [&](const char* assignment) {
    return ErrorOf(
        [&] { ApplySetting(assignment, [&](SettingsVisitor& v) { options.Visit(v); }); });
  };
  EXPECT_THAT(error_of("network.descriptor=1"),
              testing::AllOf(HasSubstr("network.descriptor"), HasSubstr("2"), HasSubstr("1024")));
  EXPECT_THAT(error_of("candidates.neighbors=0"),
              testing::AllOf(HasSubstr("candidates.neighbors"), HasSubstr("1000")));
  EXPECT_THAT(error_of("patch_diameters=9"),
              testing::AllOf(HasSubstr("patch_diameters"), HasSubstr("0.05"), HasSubstr("4")));
  EXPECT_THAT(error_of("network.regression.siamese_weight=-1"), HasSubstr("siamese_weight"));
  EXPECT_THAT(error_of("network.regression.rotation=euler"), HasSubstr("six_d"));
  EXPECT_THAT(error_of("network.autoencoder.target=positve"), HasSubstr("did you mean 'positive'"));
}

}  // namespace
}  // namespace pickbed::tests
