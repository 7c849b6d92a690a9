// Estimates the poses of all objects in one RGB-D frame, and compares them with the ground truth.
//
//   estimate_poses [ESTIMATOR]    descriptor (default), or another row of `pickbed list estimators`

#include <algorithm>
#include <cstdio>
#include <exception>
#include <limits>
#include <memory>
#include <string>

#include "perception/estimators/pose_estimator.h"
#include "perception/model/pose_distance.h"
#include "scenes/base/files.h"
#include "scenes/scenario/find_scenario.h"
#include "sim/convex/convex_pieces.h"
#include "sim/drop/certified_scene.h"
#include "sim/render/renderer.h"
#include "sim/sensor/depth_noise.h"
#include "sim/training_view_source.h"

using namespace pickbed::scenes;
using namespace pickbed::sim;
using namespace pickbed::perception;

namespace {

void EstimatePoses(const std::string& estimator_name) {
  // The frame may come from any depth camera. Here it comes from a scenario of the simulator.
  ScenarioRequest request;
  request.scenario = "bin_bracket";
  request.settings = {"objects.0.count=5"};
  const LoadedScenario scenario = FindScenario(request);
  const ObjectSet objects = WithConvexPieces(scenario.objects);
  const Bin bin = BinOf(scenario.spec);
  const Camera camera = CameraOf(scenario.spec);
  const BinIndex bin_index(0);
  const Scene scene = MakeScene({bin, objects, {5}, scenario.spec.seed, bin_index}).scene;
  const RenderedImage image = SceneRenderer(objects, bin).Render(scene, camera);
  const SensorProfile sensor = LoadSensorProfile(scenario.spec.sensor);
  Rng rng = Rng::Derive(scenario.spec.seed, bin_index, "example");
  const RgbdFrame frame{
      camera.intrinsics, image.color,
      ApplySensorNoise({image.depth_m, camera.intrinsics, &image.color}, sensor, rng)};

  // Estimators that compare the frame with rendered views get these from the simulator.
  ViewSourceOptions view_options;
  view_options.sensor = sensor;
  view_options.camera = camera.intrinsics;
  view_options.bin = bin;
  const auto views = MakeSimViewSource(objects, view_options);

  EstimatorSetup setup;
  setup.objects = objects;
  setup.spec.name = estimator_name;
  setup.intrinsics = camera.intrinsics;
  setup.working_distance_m = camera.X_CW().translation().z();
  setup.views = views.get();
  setup.cache_dir = CacheDir();
  const std::unique_ptr<PoseEstimator> estimator = MakeEstimator(setup);  // loads its model

  // The bin is known, so its floor and walls are removed. Without the background the estimator
  // finds them itself.
  const KnownBackground background{bin, camera.X_CW()};
  const EstimateResult result = estimator->Estimate({frame, background}, rng);

  // The error is the largest displacement of the corners of the object's bounding box, between the
  // estimated pose and the nearest true one.
  for (const PoseHypothesis& hypothesis : result.hypotheses) {
    const PoseDistance distance(*objects[hypothesis.object]);
    double error_m = std::numeric_limits<double>::infinity();
    for (const PosedObject& posed : scene.objects) {
      const Pose X_CO = camera.X_CW() * posed.X_WO;
      error_m = std::min(error_m, distance(hypothesis.X_CO, X_CO) * distance.diameter_m());
    }
    const Eigen::Vector3d p_CO = hypothesis.X_CO.translation();
    std::printf("%s: score %.2f, at (%.3f, %.3f, %.3f) m in C, error %.1f mm\n",
                objects[hypothesis.object]->name.c_str(), hypothesis.score, p_CO.x(), p_CO.y(),
                p_CO.z(), 1e3 * error_m);
  }
}

}  // namespace

int main(int argc, char** argv) try {
  EstimatePoses(argc > 1 ? argv[1] : "descriptor");
  return 0;
} catch (const std::exception& error) {
  std::fprintf(stderr, "error: %s\n", error.what());
  return 1;
}
