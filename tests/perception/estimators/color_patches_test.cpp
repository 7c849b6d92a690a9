// Patches of depth and color, tested from the pixel to the pose on objects that differ only in
// color.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "perception/candidates/estimate_trace.h"
#include "perception/candidates/vote_candidates.h"
#include "perception/estimators/descriptor.h"
#include "perception/networks/model_file.h"
#include "perception/training/training.h"
#include "scenes/base/files.h"
#include "tests/support/error_of.h"
#include "tests/support/painted_views.h"
#include "tests/support/synthetic_depth.h"
#include "tests/support/temporary_folder.h"

namespace pickbed::tests {
namespace {

using testing::AllOf;
using testing::HasSubstr;

// No training steps: the channels that a network uses do not depend on its weights.
TrainingOptions Untrained(const std::string& channels) {
  TrainingOptions options;
  options.network.kind = "autoencoder";
  options.network.descriptor = 16;
  options.network.autoencoder.channels = channels;
  options.clutter_scenes = 2;
  options.views_per_scene = 1;
  options.positive_pairs.patches_per_view = 60;
  options.iterations = 0;
  options.verifier_clutter_scenes = 2;
  options.verifier_room_scenes = 0;
  options.verifier_entries = 400;
  options.verifier.iterations = 50;
  options.candidates.points = 40;
  options.candidates.candidates = 30;
  options.candidates.min_candidates = 10;
  options.fast_candidates = options.candidates;
  options.held_out.clutter_scenes = 1;
  options.held_out.queries = 20;
  options.held_out.book_views = 10;
  return options;
}

// Substitute for a network: the means of the channels except depth, as a row of unit length.
std::vector<float> ChannelMeans(std::span<const int8_t> patches) {
  std::vector<float> rows;
  for (size_t first = 0; first < patches.size(); first += kPatchValues) {
    Eigen::Vector3f means = Eigen::Vector3f::Constant(1e-3f);  // never zero
    for (int i = kPatchArea; i < kPatchValues; ++i) means[i / kPatchArea - 1] += patches[first + i];
    means.normalize();
    rows.insert(rows.end(), means.begin(), means.end());
  }
  return rows;
}

std::shared_ptr<const ObjectModel> Named(const char* name) {
  ObjectModel object = *ObjectOf(BracketMesh());
  object.name = name;
  return std::make_shared<const ObjectModel>(std::move(object));
}

// Two objects of one shape, one red and one blue, and a model for each set of channels.
class TwoColors : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    temporary_ = new TemporaryFolder;
    views_ = new PaintedViews({Named("red"), Named("blue")});
    for (const char* channels : {"depth_normals", "rgbd"}) {
      ASSERT_TRUE(TrainDescriptor(Job(channels), Untrained(channels)).finished);
    }
  }
  static void TearDownTestSuite() {
    delete views_;
    delete temporary_;
  }
  static std::filesystem::path File(const std::string& name) {
    return temporary_->path() / (name + ".net");
  }
  static TrainingJob Job(const std::string& name) {
    return {*views_, File(name), {}, false, {}, "test", {}};
  }
  static std::unique_ptr<PoseEstimator> Make(const std::string& model,
                                             const std::filesystem::path& regression = {}) {
    EstimatorSetup setup;
    setup.objects = views_->objects();
    setup.intrinsics = SmallCamera();
    setup.working_distance_m = RayCastViews::kDistanceM;
    setup.views = views_;
    setup.cache_dir = temporary_->path();
    DescriptorOptions options = OptionsForMode("fast");
    options.code_entries = 400;
    options.candidates.points = 40;
    if (!regression.empty()) options.candidates.votes = "both";
    return MakeLearnedEstimator(setup, options, {File(model), "", kTrainCommand, regression});
  }
  static TemporaryFolder* temporary_;
  static PaintedViews* views_;
};
TemporaryFolder* TwoColors::temporary_ = nullptr;
PaintedViews* TwoColors::views_ = nullptr;

// Share of the votes of the substitute network that are for the object at their place.
double ShareOfRightObject(PatchChannels channels) {
  PaintedViews views({Named("red"), Named("blue")});
  constexpr double kSide_m = 0.032;
  IsolatedOptions isolated;
  isolated.views = 50;
  isolated.distance_m = RayCastViews::kDistanceM;
  isolated.focal_px = SmallCamera().fx();
  PatchVoter voter;
  voter.channels = channels;
  voter.describe = ChannelMeans;
  std::vector<CandidateObject> objects;
  for (const ObjectId object : {ObjectId{0}, ObjectId{1}}) {
    ObjectCodes codes =
        MakeObjectCodes(views, object, {kSide_m, channels}, 3, ChannelMeans, isolated, 7, 1, {});
    objects.push_back({views.objects()[object], kSide_m, std::move(codes), object});
  }
  CandidateOptions options;
  options.points = 100;
  options.candidates = 20;
  const CandidateFinder finder(std::move(objects), voter, options);
  int right = 0, votes = 0;
  for (uint64_t seed = 5000; seed < 5003; ++seed) {
    const LabelledView view = views.ClutterScene({seed, 1}).front();
    EstimateTrace trace;
    StageSeconds seconds;
    Rng rng(1);
    finder.Find(BuildCloud(view.frame, OutOfSightBin()), rng, seconds, &trace);
    EXPECT_EQ(trace.channels, channels);
    for (const TracedVote& vote : trace.votes) {
      const auto gap_m = [&](const LabelledInstance& instance) {
        return (instance.X_CO.translation() - vote.vote.X_CO.translation()).norm();
      };
      right += vote.vote.object == std::ranges::min_element(view.instances, {}, gap_m)->object;
      ++votes;
    }
  }
  return static_cast<double>(right) / votes;
}

TEST(ColorVotes, DistinguishObjectsThatDepthCannot) {
  EXPECT_GT(ShareOfRightObject(PatchChannels::kDepthColor), 0.95);
  EXPECT_NEAR(ShareOfRightObject(PatchChannels::kDepthNormals), 0.5, 0.2);
}

TEST_F(TwoColors, ModelStoresTheChannels) {
  EXPECT_EQ(LoadModel(File("rgbd")).network.channels(), PatchChannels::kDepthColor);
  EXPECT_EQ(LoadModel(File("depth_normals")).network.channels(), PatchChannels::kDepthNormals);
}

TEST_F(TwoColors, FrameWithoutColorIsRefusedByColorChannels) {
  LabelledView view = views_->ClutterScene({5000, 1}).front();
  view.frame.color = {};
  const auto run = [&](const char* model) {
    const auto estimator = Make(model);
    Rng rng(1);
    return ErrorOf([&] { estimator->Estimate({view.frame, OutOfSightBin()}, rng); });
  };
  EXPECT_THAT(run("rgbd"), AllOf(HasSubstr("no color image"), HasSubstr("depth_normals")));
  EXPECT_EQ(run("depth_normals"), "no error");
  // Also if there is no foreground.
  std::ranges::fill(view.frame.depth_m.pixels(), 0.0f);
  EXPECT_THAT(run("rgbd"), HasSubstr("no color image"));
}

TEST_F(TwoColors, NetworksWithOtherChannelsAreNotMixed) {
  TrainingJob job = Job("mixed");
  job.start_from = File("rgbd");
  EXPECT_THAT(ErrorOf([&] { TrainDescriptor(job, Untrained("depth_normals")); }),
              AllOf(HasSubstr("rgbd.net"), HasSubstr("depth and color, not on depth and normals"),
                    HasSubstr("network.autoencoder.channels")));
  EXPECT_THAT(ErrorOf([&] { Make("rgbd", File("depth_normals")); }),
              AllOf(HasSubstr("depth_normals.net"), HasSubstr("train both on the same input")));
}

// Initial weights depend only on the seed and not on the channels.
TEST_F(TwoColors, CodebooksAreNotSharedBetweenChannels) {
  ASSERT_EQ(LoadModel(File("rgbd")).network_hash, LoadModel(File("depth_normals")).network_hash);
  const auto books = [] {
    std::vector<std::filesystem::path> files;
    for (const auto& entry : std::filesystem::directory_iterator(temporary_->path())) {
      if (entry.path().filename().string().starts_with("codes-")) files.push_back(entry.path());
    }
    return files;
  };
  for (const std::filesystem::path& file : books()) std::filesystem::remove(file);
  Make("rgbd");
  EXPECT_EQ(books().size(), 2u) << "one per object";
  const std::string seen = ReadFileBytes(books().front());
  Make("depth_normals");
  ASSERT_EQ(books().size(), 4u);
  // Different patches give different rows. The poses at the end of the files are equal.
  int alike = 0;
  constexpr size_t kHeader = 60, kRows = 1000;
  for (const std::filesystem::path& file : books()) {
    alike += ReadFileBytes(file).substr(kHeader, kRows) == seen.substr(kHeader, kRows);
  }
  EXPECT_EQ(alike, 1) << "only the file itself";
}

}  // namespace
}  // namespace pickbed::tests
