#include <gtest/gtest.h>

#include "perception/candidates/pose_selection.h"
#include "perception/candidates/vote_candidates.h"
#include "perception/crops/crop_views.h"
#include "perception/crops/whole_crops.h"
#include "perception/estimators/descriptor.h"
#include "perception/estimators/ppf.h"
#include "perception/estimators/wohlhart.h"
#include "perception/icp/bidirectional_icp.h"
#include "perception/icp/pcl_icp.h"
#include "perception/icp/projective_icp.h"
#include "perception/networks/descriptor_network.h"
#include "perception/networks/wohlhart.h"
#include "perception/training/training.h"
#include "perception/training/verifier_library.h"
#include "perception/training/wohlhart_training.h"
#include "perception/verify/depth_evidence.h"
#include "tests/support/planted_option.h"
#include "tests/support/ray_cast_views.h"
#include "tests/support/synthetic_depth.h"

namespace pickbed::tests {
namespace {

// Calls `call` with default options in which `plant` sets a value.
template <typename Options>
std::function<void()> Planted(const std::function<void(Options&)>& plant,
                              const std::function<void(const Options&)>& call) {
  return [=] {
    Options options;
    plant(options);
    call(options);
  };
}

TEST(PerceptionOptions, ValuesOutOfRangeAreRefused) {
  RayCastViews views({});
  Rng rng(0);
  EstimatorSetup setup;
  const RgbdFrame frame{SmallCamera(), {}, Image<float>(320, 240)};
  const OrganizedCloud cloud = BuildCloud(frame, std::nullopt);
  std::vector<PoseHypothesis> hypotheses;
  const ModelPoints model;
  const auto train = [&](const TrainingOptions& o) {
    TrainDescriptor({views, {}, {}, false, {}, {}, {}}, o);
  };
  const auto train_crops = [&](const WohlhartOptions& o) { TrainWohlhart({{}, 0, {}, {}}, o); };
  const auto find = [&](const CandidateOptions& o) { CandidateFinder({}, {}, o); };
  const auto assess = [&](const CandidateRefinementOptions& o) { CandidateRefiner({}, o); };
  const auto build = [&](const CloudOptions& o) { BuildCloud(frame, std::nullopt, o); };
  const auto select = [&](const PoseSelectionOptions& o) { SelectPoses(cloud, {}, {}, {}, {}, o); };
  const auto verify = [&](const VerifierTrainingOptions& o) {
    TrainVerifierLibrary({views, "", {}, {}, false, {}, {}}, o);
  };
  const PlantedOption planted[] = {
      {"normal_window_px", Planted<CloudOptions>([](auto& o) { o.normal_window_px = 17; }, build)},
      {"fit_band_m", Planted<CloudOptions>([](auto& o) { o.fit_band_m = kNotANumber; }, build)},
      {"min_hidden_share", Planted<BackgroundOptions>([](auto& o) { o.min_hidden_share = -1; },
                                                      [](auto& o) { FitBackground({}, o); })},
      {"sigma_m", Planted<DepthEvidenceOptions>(
                      [](auto& o) { o.sigma_m = 0; },
                      [](auto& o) { DepthEvidenceOf(*ObjectOf(BracketMesh()), o); })},
      {"pixel_stride", Planted<NonMaximumSuppressionOptions>(
                           [](auto& o) { o.pixel_stride = 0; },
                           [&](auto& o) { SuppressNonMaxima(cloud, {}, hypotheses, o); })},
      {"merge_diameters",
       Planted<PoseSelectionOptions>([](auto& o) { o.merge_diameters = kNotANumber; }, select)},
      {"non_maximum_suppression.claim_m",
       Planted<PoseSelectionOptions>([](auto& o) { o.non_maximum_suppression.claim_m = -1; },
                                     select)},
      {"branching", Planted<NeighborOptions>([](auto& o) { o.branching = 1; },
                                             [](auto& o) { NeighborIndex({}, 1, o); })},
      {"views", Planted<IsolatedOptions>(
                    [](auto& o) { o.views = 0; },
                    [&](auto& o) { ForEachIsolatedBlock(views, ObjectId{0}, {}, o, 0, {}); })},
      {"modes.cell_diameters",
       Planted<CandidateOptions>([](auto& o) { o.modes.cell_diameters = kNotANumber; }, find)},
      {"votes", Planted<CandidateOptions>([](auto& o) { o.votes = "all"; }, find)},
      {"quick_tau_m",
       Planted<CandidateRefinementOptions>([](auto& o) { o.quick_tau_m = kNotANumber; }, assess)},
      {"damping", Planted<CandidateRefinementOptions>([](auto& o) { o.icp.damping = -1; }, assess)},
      {"iterations", Planted<PclIcpOptions>([](auto& o) { o.iterations = -1; },
                                            [&](auto& o) { PclIcp(cloud, o); })},
      {"max_points", Planted<ProjectiveIcpOptions>(
                         [](auto& o) { o.max_points = 513; },
                         [&](auto& o) { ProjectiveIcp(cloud, model, Pose::Identity(), o); })},
      {"outline_weight",
       Planted<BidirectionalIcpOptions>(
           [](auto& o) { o.outline_weight = kNotANumber; },
           [&](auto& o) { BidirectionalIcp(cloud, model, Pose::Identity(), o); })},
      {"descriptor", Planted<NetworkOptions>([](auto& o) { o.descriptor = 0; },
                                             [](auto& o) { DescriptorNetwork(o, 0); })},
      {"depth_reach", Planted<WohlhartOptions>([](auto& o) { o.depth_reach = 0; },
                                               [](auto& o) { WohlhartNetwork(o, 0); })},
      {"augment.occluded_max",
       Planted<WohlhartOptions>([](auto& o) { o.augment.occluded_max = 1; }, train_crops)},
      {"template_level",
       Planted<CropViewOptions>([](auto& o) { o.template_level = 9; },
                                [&](auto& o) { MakeCropTrainingSet(views, views, o, 0); })},
      {"focal_px",
       Planted<CropViewOptions>([](auto& o) { o.focal_px = kNotANumber; },
                                [&](auto& o) { RenderCrops(views, ObjectId{0}, {}, o, 0); })},
      {"isolated",
       Planted<WholeViewOptions>([](auto& o) { o.isolated = -1; },
                                 [&](auto& o) { MakeWholeTrainingSet(views, o, 0, {}); })},
      {"min_visible", Planted<PositivePairOptions>([](auto& o) { o.min_visible = kNotANumber; },
                                                   [&](auto& o) {
                                                     std::vector<PatchPairs> pairs;
                                                     AppendPositivePatches(views, {}, {}, o, rng,
                                                                           pairs);
                                                   })},
      {"queries", Planted<HeldOutOptions>([](auto& o) { o.queries = 0; },
                                          [&](auto& o) { MakeHeldOut(views, {}, o, 0, {}); })},
      {"learning_rate", Planted<VerifierOptions>([](auto& o) { o.learning_rate = kNotANumber; },
                                                 [](auto& o) { TrainVerifier({}, o, 0); })},
      {"clutter_scenes",
       Planted<VerifierTrainingOptions>([](auto& o) { o.clutter_scenes = -1; }, verify)},
      {"verifier.batch", Planted<VerifierTrainingOptions>([](auto& o) { o.verifier.batch = 0; },
                                                          [&](auto& o) {
                                                            MakeVerifierTrainingSet(
                                                                views, ObjectId{0}, {}, o, {});
                                                          })},
      {"calibration_share",
       Planted<VerifierTrainingOptions>([](auto& o) { o.calibration_share = 1; },
                                        [&](auto& o) {
                                          TrainObjectVerifier(
                                              VerifierTrainingSet(), ObjectId{0},
                                              std::span<const CandidateSource* const>(), o, {});
                                        })},
      {"rehearsal", Planted<TrainingOptions>([](auto& o) { o.rehearsal = kNotANumber; }, train)},
      {"loss.sigma", Planted<TrainingOptions>([](auto& o) { o.loss.sigma = kNotANumber; }, train)},
      {"network.regression.rotation",
       Planted<TrainingOptions>([](auto& o) { o.network.regression.rotation = "euler"; }, train)},
      {"network.autoencoder.target",
       Planted<TrainingOptions>([](auto& o) { o.network.autoencoder.target = "x"; }, train)},
      {"code_entries",
       Planted<DescriptorOptions>([](auto& o) { o.code_entries = 0; },
                                  [&](auto& o) { MakeDescriptorEstimator(setup, o); })},
      {"match.scene_step", Planted<PpfOptions>([](auto& o) { o.match.scene_step = 0; },
                                               [&](auto& o) { MakePpfEstimator(setup, o); })},
      {"icp.levels", Planted<PpfOptions>([](auto& o) { o.icp.levels = 0; },
                                         [&](auto& o) { MakePpfEstimator(setup, o); })},
      {"grid_px", Planted<WohlhartBinOptions>([](auto& o) { o.grid_px = 0; },
                                              [](auto& o) { MakeWohlhartTraining(o); })},
      {"min_score", Planted<EstimatorSpec>([](auto& o) { o.min_score = kNotANumber; },
                                           [&](auto& o) {
                                             setup.spec = o;
                                             MakeEstimator(setup);
                                           })},
  };
  ExpectRefused(planted);
}

}  // namespace
}  // namespace pickbed::tests
