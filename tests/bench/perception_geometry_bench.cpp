// Benchmarks of perception without networks on one simulated clutter scene: time per frame, and
// time per hypothesis at each stage.

#include <benchmark/benchmark.h>

#include <memory>
#include <numbers>
#include <vector>

#include "perception/cloud/search_cloud.h"
#include "perception/icp/bidirectional_icp.h"
#include "perception/icp/pcl_icp.h"
#include "perception/icp/projective_icp.h"
#include "perception/model/model_points.h"
#include "perception/segments/object_segments.h"
#include "perception/segments/segment_cover.h"
#include "perception/verify/non_maximum_suppression.h"
#include "perception/verify/pose_features.h"
#include "perception/voting/pose_clustering.h"
#include "perception/voting/vote_density.h"
#include "scenes/objects/object_catalog.h"
#include "sim/training_view_source.h"
#include "tests/support/layer.h"

namespace pickbed::tests {
namespace {

// A clutter scene of brackets with rough poses near the true ones, computed once.
struct BracketScene {
  ObjectSet objects;
  LabelledView view;
  std::vector<ModelPoints> models;
  OrganizedCloud cloud;
  std::vector<Pose> rough;
};

std::vector<Pose> RoughPoses(const LabelledView& view, int count) {
  Rng rng(2);
  std::vector<Pose> poses;
  for (int i = 0; i < count; ++i) {
    Pose X_CO = view.instances[i % view.instances.size()].X_CO;
    const double angle = rng.Uniform(0, 10) * std::numbers::pi / 180;
    X_CO.linear() = Eigen::AngleAxisd(angle, rng.UnitVector()) * X_CO.linear();
    X_CO.translation() += rng.Uniform(0, 0.006) * rng.UnitVector();
    poses.push_back(X_CO);
  }
  return poses;
}

const BracketScene& SharedScene() {
  static const BracketScene scene = [] {
    BracketScene p;
    p.objects = {ObjectCatalog({AssetsDir() / "objects"}).Load("bracket")};
    p.view = MakeSimViewSource(p.objects, {})->ClutterScene({1, 1}).front();
    p.models.push_back(MakeModelPoints(*p.objects.front()));
    p.cloud = BuildCloud(p.view.frame, p.view.background);
    p.rough = RoughPoses(p.view, 1000);
    return p;
  }();
  return scene;
}

void Cloud(benchmark::State& state) {
  const BracketScene& scene = SharedScene();
  for (auto _ : state) {
    benchmark::DoNotOptimize(BuildCloud(scene.view.frame, scene.view.background));
  }
  state.SetItemsProcessed(state.iterations());
}
BENCHMARK(Cloud)->Name("cloud/known_bin/640x480")->Unit(benchmark::kMillisecond);

// Returns a frame of industrial size: each pixel is repeated `factor` times per axis.
RgbdFrame Enlarged(const RgbdFrame& frame, int factor) {
  const CameraIntrinsics& k = frame.intrinsics;
  RgbdFrame large;
  large.intrinsics = {k.width() * factor, k.height() * factor, k.fx() * factor,
                      k.fy() * factor,    k.cx() * factor,     k.cy() * factor};
  large.depth_m = Image<float>(k.width() * factor, k.height() * factor);
  large.color = Image<Rgb8>(k.width() * factor, k.height() * factor);
  for (int y = 0; y < large.depth_m.height(); ++y) {
    for (int x = 0; x < large.depth_m.width(); ++x) {
      large.depth_m(x, y) = frame.depth_m(x / factor, y / factor);
      large.color(x, y) = frame.color(x / factor, y / factor);
    }
  }
  return large;
}

// The second argument is the binning factor, the first one the number of threads.
void LargeCloud(benchmark::State& state) {
  const BracketScene& scene = SharedScene();
  const RgbdFrame frame = Enlarged(scene.view.frame, 2);
  for (auto _ : state) {
    benchmark::DoNotOptimize(SearchCloud(frame, scene.view.background,
                                         static_cast<int>(state.range(1)), nullptr, true,
                                         static_cast<int>(state.range(0))));
  }
  state.SetItemsProcessed(state.iterations());
}
BENCHMARK(LargeCloud)
    ->Name("search_cloud/known_bin/1280x960")
    ->ArgNames({"threads", "binning"})
    ->ArgsProduct({{1, 2}, {1, 2}})
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime();

void Segments(benchmark::State& state) {
  const BracketScene& scene = SharedScene();
  for (auto _ : state) {
    benchmark::DoNotOptimize(SegmentFrame(scene.view.frame, scene.view.background));
  }
  state.SetItemsProcessed(state.iterations());
}
BENCHMARK(Segments)->Name("segments/known_bin/640x480")->Unit(benchmark::kMillisecond);

void SegmentCover(benchmark::State& state) {
  const BracketScene& scene = SharedScene();
  const ObjectSegments segments = SegmentFrame(scene.view.frame, scene.view.background);
  for (auto _ : state) {
    benchmark::DoNotOptimize(CoveredShares(scene.view.frame.depth_m, segments));
  }
  state.SetItemsProcessed(state.iterations());
}
BENCHMARK(SegmentCover)->Name("segment_cover/640x480")->Unit(benchmark::kMillisecond);

void ModelOfBracket(benchmark::State& state) {
  const ObjectModel& object = *SharedScene().objects.front();
  for (auto _ : state) benchmark::DoNotOptimize(MakeModelPoints(object));
}
BENCHMARK(ModelOfBracket)->Name("model_points/bracket/200")->Unit(benchmark::kMillisecond);

// Processes one hypothesis per iteration.
template <typename Work>
void ForEachPose(benchmark::State& state, Work work) {
  const BracketScene& scene = SharedScene();
  size_t i = 0;
  for (auto _ : state) {
    work(scene, scene.rough[i]);
    i = (i + 1) % scene.rough.size();
  }
  state.SetItemsProcessed(state.iterations());
}

void Quick(benchmark::State& state) {
  ForEachPose(state, [](const BracketScene& scene, const Pose& X_CO) {
    benchmark::DoNotOptimize(QuickScore(scene.cloud, scene.models[0], X_CO));
  });
}
BENCHMARK(Quick)->Name("quick_score/bracket/120")->Unit(benchmark::kMicrosecond);

void BulkIcp(benchmark::State& state) {
  ForEachPose(state, [](const BracketScene& scene, const Pose& X_CO) {
    benchmark::DoNotOptimize(ProjectiveIcp(scene.cloud, scene.models[0], X_CO));
  });
}
BENCHMARK(BulkIcp)->Name("projective_icp/bracket/150")->Unit(benchmark::kMicrosecond);

void Evidence(benchmark::State& state) {
  const DepthEvidenceOf evidence(*SharedScene().objects.front());
  EvidenceScratch scratch;
  ForEachPose(state, [&](const BracketScene& scene, const Pose& X_CO) {
    benchmark::DoNotOptimize(evidence(scene.cloud, X_CO, scratch));
  });
}
BENCHMARK(Evidence)->Name("depth_evidence/bracket/1500")->Unit(benchmark::kMicrosecond);

void Support(benchmark::State& state) {
  const DepthEvidenceOf evidence(*SharedScene().objects.front());
  EvidenceScratch scratch;
  PoseSupportMeasure support;
  ForEachPose(state, [&](const BracketScene& scene, const Pose& X_CO) {
    benchmark::DoNotOptimize(evidence(scene.cloud, X_CO, scratch, 1500, &support));
    benchmark::DoNotOptimize(support.Finish());
  });
}
BENCHMARK(Support)->Name("pose_support/bracket/1500")->Unit(benchmark::kMicrosecond);

void Verify(benchmark::State& state) {
  ForEachPose(state, [](const BracketScene& scene, const Pose& X_CO) {
    FitReport fit;
    benchmark::DoNotOptimize(
        ComputeVerifyFeatures(scene.cloud, scene.models[0], X_CO, {}, {}, 3, fit));
  });
}
BENCHMARK(Verify)->Name("verify/bracket/600")->Unit(benchmark::kMicrosecond);

void FinalIcp(benchmark::State& state) {
  const PclIcp refiner(SharedScene().cloud);
  ForEachPose(state, [&](const BracketScene& scene, const Pose& X_CO) {
    benchmark::DoNotOptimize(refiner.Refine(scene.models[0], X_CO));
  });
}
BENCHMARK(FinalIcp)->Name("pcl_icp/bracket/400")->Unit(benchmark::kMicrosecond);

void Bidirectional(benchmark::State& state) {
  ForEachPose(state, [](const BracketScene& scene, const Pose& X_CO) {
    benchmark::DoNotOptimize(BidirectionalIcp(scene.cloud, scene.models[0], X_CO));
  });
}
BENCHMARK(Bidirectional)->Name("bidirectional_icp/bracket/600")->Unit(benchmark::kMicrosecond);

void SearchTree(benchmark::State& state) {
  const OrganizedCloud& cloud = SharedScene().cloud;
  for (auto _ : state) benchmark::DoNotOptimize(PclIcp(cloud));
}
BENCHMARK(SearchTree)->Name("pcl_tree/pile/640x480")->Unit(benchmark::kMillisecond);

void Cluster(benchmark::State& state) {
  const BracketScene& scene = SharedScene();
  const std::vector<PoseDistance> distances{PoseDistance(*scene.objects.front())};
  std::vector<RawHypothesis> raw(state.range(0));
  Rng rng(5);
  for (size_t i = 0; i < raw.size(); ++i) {
    raw[i].X_CO = scene.rough[i % scene.rough.size()];
    if (rng.Uniform() < 0.5) raw[i].X_CO.linear() = rng.Rotation().toRotationMatrix();
    raw[i].quick_score = static_cast<float>(rng.Uniform());
  }
  for (auto _ : state) benchmark::DoNotOptimize(ClusterVotes(raw, distances, 0.1, 1000));
  state.SetItemsProcessed(state.iterations() * state.range(0));
}
BENCHMARK(Cluster)->Name("cluster/votes")->Arg(1200)->Arg(9600)->Unit(benchmark::kMillisecond);

void Suppress(benchmark::State& state) {
  const BracketScene& scene = SharedScene();
  std::vector<PoseHypothesis> hypotheses(state.range(0));
  for (size_t i = 0; i < hypotheses.size(); ++i) {
    hypotheses[i].X_CO = scene.rough[i];
    hypotheses[i].score = 1.0 / static_cast<double>(i + 1);
  }
  for (auto _ : state) {
    benchmark::DoNotOptimize(SuppressNonMaxima(scene.cloud, scene.models, hypotheses));
  }
  state.SetItemsProcessed(state.iterations() * state.range(0));
}
BENCHMARK(Suppress)
    ->Name("non_maximum_suppression/hypotheses")
    ->Arg(100)
    ->Arg(1000)
    ->Unit(benchmark::kMillisecond);

// Density of the votes of a frame around some of them. A bracket has one equivalent pose, a gear
// 24.
void Density(benchmark::State& state, const char* object_name) {
  constexpr int kVotes = 5000, kPlaces = 20, kQueries = 200;
  const auto model = ObjectCatalog({AssetsDir() / "objects"}).Load(object_name);
  LabelledView view;
  Rng rng(3);
  for (int i = 0; i < kPlaces; ++i) {
    LabelledInstance& instance = view.instances.emplace_back();
    instance.X_CO = Translation({rng.Uniform(-0.1, 0.1), rng.Uniform(-0.1, 0.1), 0.8});
    instance.X_CO.linear() = Eigen::AngleAxisd(3, rng.UnitVector()).toRotationMatrix();
  }
  std::vector<PoseVote> votes;
  for (const Pose& X_CO : RoughPoses(view, kVotes)) {
    votes.push_back({X_CO, static_cast<int>(votes.size())});
  }
  const PoseEmbedding embedding(*model);
  const VoteDensity density(embedding, model->mass.com_O, model->diameter_m, 0.2, votes);
  VoteDensity::Scratch scratch;
  for (auto _ : state) {
    for (int i = 0; i < kQueries; ++i) {
      benchmark::DoNotOptimize(density.Around(votes[i].X_CO, votes[i].patch, scratch));
    }
  }
  state.SetItemsProcessed(state.iterations() * kQueries);
}
BENCHMARK_CAPTURE(Density, bracket, "bracket")->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(Density, gear, "gear")->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace pickbed::tests
