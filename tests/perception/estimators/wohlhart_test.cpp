// Estimator wohlhart, trained for seconds on unoccluded instances.

#include "perception/estimators/wohlhart.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "perception/features/labelled_patches.h"
#include "perception/features/patch.h"
#include "perception/training/verifier_library.h"
#include "scenes/base/files.h"
#include "tests/support/error_of.h"
#include "tests/support/ray_cast_views.h"
#include "tests/support/share_found.h"
#include "tests/support/synthetic_depth.h"
#include "tests/support/temporary_folder.h"

namespace pickbed::tests {
namespace {

using testing::HasSubstr;

WholeViewOptions FewViews() {
  WholeViewOptions options;
  options.templates.template_level = 1;
  options.templates.in_plane = 12;
  options.templates.in_plane_max_rad = 2.88;
  options.isolated = 150;
  options.clutter_scenes = 12;
  options.views_per_scene = 1;
  return options;
}

WohlhartBinOptions Quick() {
  WohlhartBinOptions options;
  options.views = FewViews();
  options.network.descriptor = 16;
  options.network.iterations = 150;
  options.network.mine_every = 50;
  options.network.anchors = 24;
  options.neighbors = 8;
  options.grid_px = 4;
  return options;
}

VerifierTrainingOptions FewScenes() {
  VerifierTrainingOptions options;
  options.clutter_scenes = 6;
  options.views_per_scene = 1;
  options.verifier.iterations = 300;
  return options;
}

class WohlhartInBins : public testing::Test {
 protected:
  VerifierReport Train(const std::string& name, const WohlhartBinOptions& options,
                       bool resume = false) {
    VerifierJob job{views_,
                    "wohlhart",
                    [&](const ObjectSet& objects, const LearnedNetwork& network) {
                      return MakeWohlhartCandidates(objects, views_, network, FewCandidates());
                    },
                    folder_ / name,
                    resume,
                    "test sensor",
                    {}};
    const auto training = MakeWohlhartTraining(options);
    job.network_settings = training->NetworkSettings(views_.objects());
    job.learn = [&](const std::function<bool(double)>& on_share) {
      return training->TrainNetwork({views_, 0, {}, on_share});
    };
    return TrainVerifierLibrary(job, FewScenes());
  }
  static CandidateRefinementOptions FewCandidates() {
    CandidateRefinementOptions options;
    options.candidates = 120;
    return options;
  }
  EstimatorSetup Setup(const std::string& model) {
    EstimatorSetup setup;
    setup.objects = views_.objects();
    setup.spec.name = "wohlhart";
    setup.spec.model = folder_ / model;
    setup.spec.min_score = 0;
    setup.intrinsics = SmallCamera();
    setup.views = &views_;
    return setup;
  }

  RayCastViews views_{{ObjectOf(BracketMesh())}};
  const TemporaryFolder temporary_;
  const std::filesystem::path folder_ = temporary_.path();
};

TEST_F(WohlhartInBins, LearnsAndFindsUnoccludedInstances) {
  ASSERT_TRUE(Train("model.net", Quick()).finished);
  const auto estimator = MakeWohlhartEstimator(Setup("model.net"));
  EXPECT_GE(ShareFound(*estimator, views_), 0.5);

  // For another mesh, the templates of the network would be wrong.
  EstimatorSetup changed = Setup("model.net");
  auto object = std::make_shared<ObjectModel>(*changed.objects[0]);
  object->mesh_hash += 1;
  changed.objects = {object};
  EXPECT_THAT(ErrorOf([&] { MakeWohlhartEstimator(changed); }),
              testing::AllOf(HasSubstr("the mesh of object 'test part' has changed"),
                             HasSubstr("`pickbed train` as verifiers of wohlhart")));
}

TEST_F(WohlhartInBins, SameSeedSameFile) {
  WohlhartBinOptions options = Quick();
  options.network.iterations = 60;  // past the first mining of hard negatives
  options.views.isolated = 40;
  options.views.clutter_scenes = 2;
  Train("a.net", options);
  Train("b.net", options);
  EXPECT_EQ(ReadFileBytes(folder_ / "a.net"), ReadFileBytes(folder_ / "b.net"));
  const VerifierFile file = LoadVerifiers(folder_ / "a.net", "wohlhart");
  EXPECT_THAT(file.network.settings, HasSubstr("parts: \"test part\""));
  EXPECT_EQ(WohlhartNetwork(options.network, 1).weights(),
            static_cast<int64_t>(file.network.weights.size()));
}

TEST_F(WohlhartInBins, ResumeWithOtherSettingsIsRefused) {
  WohlhartBinOptions options = Quick();
  options.network.iterations = 2;
  options.views.clutter_scenes = 2;
  VerifierFile begun{"wohlhart", "test sensor", "", {}, {}, {}};
  begun.training = VerifierTrainingText(views_, FewScenes());
  auto changed = std::make_shared<ObjectModel>(*views_.objects()[0]);
  changed->mesh_hash += 1;
  begun.network = {MakeWohlhartTraining(options)->NetworkSettings({changed}), {1.0f}};
  SaveVerifiers(folder_ / "other_mesh.net", begun);
  begun.network.settings = MakeWohlhartTraining(options)->NetworkSettings(views_.objects());
  SaveVerifiers(folder_ / "begun.net", begun);
  const auto refused = [&](const char* name) {
    EXPECT_THAT(
        ErrorOf([&] { Train(name, options, true); }),
        testing::AllOf(HasSubstr(name), HasSubstr("its network was trained for other objects"),
                       HasSubstr("do not resume it")));
  };
  refused("other_mesh.net");
  options.network.margin = 0.02;
  refused("begun.net");
}

TEST_F(WohlhartInBins, UntrainedObjectsAreRefused) {
  const LearnedNetwork other{"parts: mug,rod\n", {}};
  EXPECT_THAT(ErrorOf([&] {
                MakeWohlhartCandidates(
                    views_.objects(), views_,
                    {other.settings, WohlhartNetwork({.input = "depth"}, 0).Weights()},
                    FewCandidates());
              }),
              HasSubstr("trained for mug,rod and not for object 'test part'"));
}

double MeanDifference(const CropSet& a, size_t i, const CropSet& b, size_t j) {
  double sum = 0;
  for (int p = 0; p < kCropArea; ++p) sum += std::abs(a.depth_of(i)[p] - b.depth_of(j)[p]);
  return sum / kCropArea / kCropDepthUnit;
}

// Templates are rendered on the optical axis. At a point beside the axis, the patch frame carries
// the pose of the template there. An object at that pose must look like the template, and unlike a
// template that is rotated by about 60 degrees.
TEST_F(WohlhartInBins, TemplatePoseIsValidAnywhereInTheImage) {
  CropViewOptions options = FewViews().templates;
  options.template_level = 0;
  const WholeTemplates templates = MakeWholeTemplates(views_, ObjectId{0}, options, 0);
  const ObjectModel& object = *views_.objects()[0];
  const double z_m = options.distance_diameters * object.diameter_m;
  CameraIntrinsics camera = CropCamera(options, 6);
  for (size_t i = 0; i < templates.X_PO.size(); i += 17) {
    const Pose X_CP = PatchFrame({0.2 * z_m, -0.1 * z_m, z_m}, 0);
    const LabelledView view =
        views_.Isolated(ObjectId{0}, {X_CP * templates.X_PO[i]}, camera, 0).front();
    const OrganizedCloud cloud = IsolatedCloud(view);
    const auto off_px = [&](int index) {
      const Eigen::Vector2d at(index % camera.width(), index / camera.width());
      return (at - Project(camera, X_CP.translation())).norm();
    };
    // The point may be on the object's outline.
    const int index =
        *std::min_element(cloud.foreground_pixels.begin(), cloud.foreground_pixels.end(),
                          [&](int a, int b) { return off_px(a) < off_px(b); });
    ASSERT_LT(off_px(index), 2);
    const CropSet crops = CutWholeCrops(cloud, {index}, CropSide_m(object, options));
    const size_t rotated = i % options.in_plane < 6 ? i + 2 : i - 2;
    EXPECT_LT(MeanDifference(crops, 0, templates.crops.crops, i),
              0.5 * MeanDifference(crops, 0, templates.crops.crops, rotated));
  }
}

TEST(WohlhartBinSettings, OutOfRangeSettingsReportTheRange) {
  WohlhartBinOptions options;
  const auto error_of = [&](const char* assignment) {
    return ErrorOf(
        [&] { ApplySetting(assignment, [&](SettingsVisitor& v) { options.Visit(v); }); });
  };
  EXPECT_THAT(error_of("neighbors=0"), testing::AllOf(HasSubstr("neighbors"), HasSubstr("100")));
  EXPECT_THAT(error_of("network.margin=0"),
              testing::AllOf(HasSubstr("network.margin"), HasSubstr("10")));
  EXPECT_THAT(error_of("network.descriptor=1"), testing::AllOf(HasSubstr("2"), HasSubstr("1024")));
  EXPECT_THAT(error_of("views.templates.side_diameters=9"), HasSubstr("5"));
}

}  // namespace
}  // namespace pickbed::tests
