#include "perception/training/positive_pairs.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "scenes/geometry/decompositions.h"

namespace pickbed::perception {
namespace {

// A pixel in a view of the clutter scene and the in-plane angle of its patch.
struct PatchAnchor {
  int pixel = 0;
  double angle_rad = 0;
};

// One isolated view of an instance and the anchors that get their positive patches from it.
struct PositiveView {
  int view = 0;                  // view of the clutter scene
  int position = 0;              // index into the instances of the view
  Pose X_TO = Pose::Identity();  // object pose in the camera frame T of the isolated view
  double distance_m = 0;         // camera to the object center
  std::vector<PatchAnchor> anchors;
};

// Returns X_TO: the object appears as along the ray from C, but on the optical axis, and is rotated
// by a small random angle.
Pose PositivePose(const ObjectModel& model, const Pose& X_CO, double turn_rad, Rng& rng) {
  const Eigen::Vector3d center_O = MeshBounds(model.mesh_O).center();
  const Eigen::Vector3d center_C = X_CO * center_O;
  const Eigen::Quaterniond to_axis = RotationBetween(center_C, Eigen::Vector3d::UnitZ());
  const Eigen::AngleAxisd turn(turn_rad * rng.Normal(), rng.UnitVector());
  return Translation({0, 0, center_C.norm()}) *
         MakePose((turn * to_axis * Eigen::Quaterniond(X_CO.linear())).toRotationMatrix(),
                  Eigen::Vector3d::Zero()) *
         Translation(-center_O);
}

// Returns the in-plane angle about the ray to point_C at which the x axis of the patch frame is
// nearest to x_C.
double AngleOf(const Eigen::Vector3d& point_C, const Eigen::Vector3d& x_C) {
  const Eigen::Matrix3d R_CP0 = PatchFrame(point_C, 0).linear();
  return std::atan2(R_CP0.col(1).dot(x_C), R_CP0.col(0).dot(x_C));
}

// Returns the pixel of the isolated view that shows the anchor's surface point, with a small random
// shift; -1 if another surface point is visible there.
int PositivePixel(const OrganizedCloud& cloud, const Eigen::Vector3d& point_T, double shift_px,
                  double tolerance_m, Rng& rng) {
  const Eigen::Vector2d at = Project(cloud.intrinsics, point_T);
  const int x = static_cast<int>(std::lround(at.x() + shift_px * rng.Normal()));
  const int y = static_cast<int>(std::lround(at.y() + shift_px * rng.Normal()));
  if (!cloud.foreground.Contains(x, y) || !cloud.foreground(x, y)) return -1;
  const int pixel = y * cloud.intrinsics.width() + x;
  const double off_m = (cloud.points_C[pixel].cast<double>() - point_T).norm();
  return off_m < tolerance_m ? pixel : -1;
}

// Samples the anchors of one view and assigns them to isolated views, by object.
void PlanPositives(const ObjectSet& objects, const LabelledView& view, int view_index,
                   const OrganizedCloud& cloud, const PositivePairOptions& options, Rng& rng,
                   std::vector<std::vector<PositiveView>>& by_object) {
  const std::vector<std::vector<int>> pixels = PixelsByInstance(view, cloud);
  std::vector<int> usable;
  for (size_t i = 0; i < pixels.size(); ++i) {
    const bool seen = view.instances[i].visible_fraction >= options.min_visible;
    if (seen && !pixels[i].empty()) usable.push_back(static_cast<int>(i));
  }
  for (const int i : usable) {
    const LabelledInstance& instance = view.instances[i];
    const int pair_count = static_cast<int>(usable.size()) * options.pairs_per_instance;
    const int share = std::max(1, options.patches_per_view / pair_count);
    for (int k = 0; k < options.pairs_per_instance; ++k) {
      PositiveView positive{view_index, i, Pose::Identity(), 0, {}};
      positive.X_TO =
          PositivePose(*objects[instance.object], instance.X_CO, options.rotation_rad, rng);
      positive.distance_m =
          (positive.X_TO * MeshBounds(objects[instance.object]->mesh_O).center()).norm();
      for (int a = 0; a < share; ++a) {
        const int pixel = pixels[i][rng.Index(static_cast<int>(pixels[i].size()))];
        positive.anchors.push_back({pixel, rng.Uniform(0, 2 * std::numbers::pi)});
      }
      by_object[instance.object].push_back(std::move(positive));
    }
  }
}

struct CutList {
  std::vector<int> pixels;
  std::vector<double> angles_rad;
};

void AppendPairs(const OrganizedCloud& clutter_cloud, const Pose& X_CO, const OrganizedCloud& alone,
                 const PositiveView& positive, const PatchForm& form, double tolerance_m,
                 const PositivePairOptions& options, Rng& rng, PatchPairs& pairs) {
  CutList anchors, codes;
  const Pose X_TC = positive.X_TO * X_CO.inverse();
  for (const PatchAnchor& anchor : positive.anchors) {
    const Eigen::Vector3d point_C = clutter_cloud.points_C[anchor.pixel].cast<double>();
    const int pixel = PositivePixel(alone, X_TC * point_C, options.shift_px, tolerance_m, rng);
    if (pixel < 0) continue;
    const Eigen::Vector3d x_C = PatchFrame(point_C, anchor.angle_rad).linear().col(0);
    const double angle = AngleOf(alone.points_C[pixel].cast<double>(), X_TC.linear() * x_C);
    anchors.pixels.push_back(anchor.pixel);
    anchors.angles_rad.push_back(anchor.angle_rad);
    codes.pixels.push_back(pixel);
    codes.angles_rad.push_back(angle + options.in_plane_rad * rng.Normal());
  }
  AppendPatches(clutter_cloud, anchors.pixels, anchors.angles_rad, form, X_CO, pairs.anchors);
  AppendPatches(alone, codes.pixels, codes.angles_rad, form, positive.X_TO, pairs.codes);
}

}  // namespace

void PositivePairOptions::Visit(SettingsVisitor& v) {
  v.Integer("patches_per_view", patches_per_view, {1, 100000},
            "approximate number of pairs per view of a clutter scene");
  v.Real("min_visible", min_visible, {0, 1}, "minimum visible fraction of a training instance");
  v.RenamedKey("twins_per_instance", "pairs_per_instance");
  v.Integer("pairs_per_instance", pairs_per_instance, {1, 100},
            "number of isolated views per instance");
  v.RenamedKey("turn_rad", "rotation_rad");
  v.Real("rotation_rad", rotation_rad, {0, 1},
         "standard deviation of the rotation between the poses of a pair, rad");
  v.Real("in_plane_rad", in_plane_rad, {0, 1},
         "standard deviation of the in-plane rotation of a pair, rad");
  v.Real("shift_px", shift_px, {0, 100},
         "standard deviation of the patch position of a pair along each axis, px");
}

void AppendPositivePatches(LabelledViewSource& source,
                           const std::vector<LabelledView>& clutter_scene,
                           const std::vector<PatchForm>& forms, const PositivePairOptions& options,
                           Rng& rng, std::vector<PatchPairs>& by_object) {
  CheckSettings("PositivePairOptions", options);
  const ObjectSet& objects = source.objects();
  std::vector<OrganizedCloud> clouds;
  std::vector<std::vector<PositiveView>> positives(objects.size());
  for (size_t v = 0; v < clutter_scene.size(); ++v) {
    clouds.push_back(BuildCloud(clutter_scene[v].frame, clutter_scene[v].background));
    PlanPositives(objects, clutter_scene[v], static_cast<int>(v), clouds[v], options, rng,
                  positives);
  }
  for (size_t o = 0; o < objects.size(); ++o) {
    if (positives[o].empty()) continue;
    IsolatedOptions nearest;
    nearest.focal_px = clutter_scene.front().frame.intrinsics.fx();
    nearest.distance_spread = 0;
    nearest.distance_m = positives[o].front().distance_m;
    std::vector<Pose> poses;
    for (const PositiveView& positive : positives[o]) {
      poses.push_back(positive.X_TO);
      nearest.distance_m = std::min(nearest.distance_m, positive.distance_m);
    }
    const CameraIntrinsics camera =
        CropCamera(MeshBounds(objects[o]->mesh_O).size().norm(), nearest);
    // Upper bound of the displacement by rotation, shift and noise.
    const double tolerance_m = kCorrectDiameters * objects[o]->diameter_m;
    const std::vector<LabelledView> views = source.Isolated(ObjectId(o), poses, camera, rng.Next());
    for (size_t i = 0; i < views.size(); ++i) {
      const OrganizedCloud alone = IsolatedCloud(views[i]);
      const PositiveView& positive = positives[o][i];
      AppendPairs(clouds[positive.view],
                  clutter_scene[positive.view].instances[positive.position].X_CO, alone, positive,
                  forms[o], tolerance_m, options, rng, by_object[o]);
    }
  }
}

}  // namespace pickbed::perception
