// Writes a pose estimator of its own: it finds rings that rest flat and apart. It has the interface
// of the built-in estimators, so it works wherever a PoseEstimator is expected.

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <exception>
#include <utility>
#include <vector>

#include "perception/cloud/organized_cloud.h"
#include "perception/estimators/pose_estimator.h"
#include "scenes/base/error.h"
#include "scenes/base/files.h"
#include "scenes/objects/object_catalog.h"
#include "sim/convex/convex_pieces.h"
#include "sim/drop/certified_scene.h"
#include "sim/render/renderer.h"

using namespace pickbed::scenes;
using namespace pickbed::sim;
using namespace pickbed::perception;

namespace {

// Reports one pose for each connected region of the foreground. The z axis of the ring is up.
class FlatRingEstimator : public PoseEstimator {
 public:
  EstimateResult Estimate(const EstimatorInput& input, Rng&) override {
    CheckInput(input.background.has_value(), "the estimator needs the known background");
    // A shared stage of perception: points in C, with the floor and the walls of the bin removed.
    OrganizedCloud cloud = BuildCloud(input.frame, input.background);
    const Pose X_BC = input.background->X_CB.inverse();
    EstimateResult result;
    for (const int pixel : cloud.foreground_pixels) {
      const std::vector<Eigen::Vector3d> region_B = TakeRegion(pixel, cloud, X_BC);
      if (region_B.size() < 100) continue;  // noise
      // The upper face is a full circle for every camera above the ring; the sides are not.
      Eigen::AlignedBox3d all_B, face_B;
      for (const Eigen::Vector3d& p_B : region_B) all_B.extend(p_B);
      for (const Eigen::Vector3d& p_B : region_B) {
        if (p_B.z() > 0.8 * all_B.max().z()) face_B.extend(p_B);
      }
      const Eigen::Vector3d p_BO(face_B.center().x(), face_B.center().y(), all_B.max().z() / 2);
      PoseHypothesis& hypothesis = result.hypotheses.emplace_back();
      hypothesis.X_CO = input.background->X_CB * Translation(p_BO);
      hypothesis.score = 0.9;  // the estimated probability that the pose is right
    }
    return result;
  }

 private:
  // Returns the points of the region of a pixel, in B, and removes them from the foreground.
  static std::vector<Eigen::Vector3d> TakeRegion(int pixel, OrganizedCloud& cloud,
                                                 const Pose& X_BC) {
    std::vector<Eigen::Vector3d> points_B;
    const int width = cloud.foreground.width();
    std::vector<std::pair<int, int>> next{{pixel % width, pixel / width}};
    while (!next.empty()) {
      const auto [u, v] = next.back();
      next.pop_back();
      if (!cloud.foreground.Contains(u, v) || cloud.foreground(u, v) == 0) continue;
      cloud.foreground(u, v) = 0;
      points_B.push_back(X_BC * cloud.points_C[v * width + u].cast<double>());
      next.insert(next.end(), {{u + 1, v}, {u - 1, v}, {u, v + 1}, {u, v - 1}});
    }
    return points_B;
  }
};

void FindRings() {
  const ObjectCatalog catalog({AssetsDir() / "objects"});
  const ObjectSet objects = WithConvexPieces(ObjectSet{catalog.Load("ring")});
  const Bin bin;
  const DropOptions upright{.arrangement = Arrangement::kPacked};
  const Scene scene = MakeScene({bin, objects, {5}, /*seed=*/1, BinIndex(0)}, upright).scene;
  const Camera camera({}, LookAt({0, -0.12, 0.85}, {0, 0, 0}, Eigen::Vector3d::UnitZ()));
  const RenderedImage image = SceneRenderer(objects, bin).Render(scene, camera);
  const RgbdFrame frame{camera.intrinsics, image.color, image.depth_m};

  FlatRingEstimator estimator;
  Rng rng(1);  // this estimator needs no random numbers
  const EstimateResult result =
      estimator.Estimate({frame, KnownBackground{bin, camera.X_CW()}}, rng);
  for (const PoseHypothesis& hypothesis : result.hypotheses) {
    const Eigen::Vector3d p_WO = camera.X_WC() * hypothesis.X_CO.translation();
    double error_m = INFINITY;
    for (const PosedObject& posed : scene.objects) {
      error_m = std::min(error_m, (p_WO - posed.X_WO.translation()).norm());
    }
    std::printf("ring at (%.3f, %.3f, %.3f) m: error %.1f mm\n", p_WO.x(), p_WO.y(), p_WO.z(),
                1e3 * error_m);
  }
}

}  // namespace

int main() try {
  FindRings();
  return 0;
} catch (const std::exception& error) {
  std::fprintf(stderr, "error: %s\n", error.what());
  return 1;
}
