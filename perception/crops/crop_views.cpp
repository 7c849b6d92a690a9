#include "perception/crops/crop_views.h"

#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <utility>

#include "scenes/geometry/decompositions.h"

namespace pickbed::perception {
namespace {

constexpr double kMargin = 1.5;  // image side over crop side: shows the surroundings of the crop

using Face = std::array<int, 3>;

void MakeIcosahedron(std::vector<Eigen::Vector3d>& corners, std::vector<Face>& faces) {
  const double g = std::numbers::phi;
  corners = {{-1, g, 0},  {1, g, 0},  {-1, -g, 0}, {1, -g, 0}, {0, -1, g},  {0, 1, g},
             {0, -1, -g}, {0, 1, -g}, {g, 0, -1},  {g, 0, 1},  {-g, 0, -1}, {-g, 0, 1}};
  for (Eigen::Vector3d& corner : corners) corner.normalize();
  faces = {{0, 11, 5},  {0, 5, 1},  {0, 1, 7},  {0, 7, 10}, {0, 10, 11}, {1, 5, 9}, {5, 11, 4},
           {11, 10, 2}, {10, 7, 6}, {7, 1, 8},  {3, 9, 4},  {3, 4, 2},   {3, 2, 6}, {3, 6, 8},
           {3, 8, 9},   {4, 9, 5},  {2, 4, 11}, {6, 2, 10}, {8, 6, 7},   {9, 8, 1}};
}

// Whether a direction is used. Corners on the equator belong to the half sphere.
bool IsSeen(const Eigen::Vector3d& direction_O, const CropViewOptions& options) {
  constexpr double kEquator = -1e-9;
  return options.full_sphere || direction_O.z() >= kEquator;
}

std::vector<double> InPlaneAngles(const CropViewOptions& options) {
  if (options.in_plane == 1) return {0};
  std::vector<double> angles;
  for (int i = 0; i < options.in_plane; ++i) {
    angles.push_back(options.in_plane_max_rad * (2.0 * i / (options.in_plane - 1) - 1));
  }
  return angles;
}

Rotations RotationsFrom(const std::vector<Eigen::Vector3d>& directions, size_t first,
                        const CropViewOptions& options) {
  Rotations rotations;
  for (size_t i = first; i < directions.size(); ++i) {
    if (!IsSeen(directions[i], options)) continue;
    for (const double angle_rad : InPlaneAngles(options)) {
      rotations.push_back(RotationOfView(directions[i], angle_rad));
    }
  }
  return rotations;
}

}  // namespace

void CropViewOptions::Visit(SettingsVisitor& v) {
  v.Integer("template_level", template_level, {0, 5},
            "icosahedron subdivisions that give the template directions");
  v.Integer("train_level", train_level, {0, 5},
            "icosahedron subdivisions that give the training directions");
  v.Bool("full_sphere", full_sphere,
         "whether the directions are all around the object, not only above its z = 0");
  v.Integer("in_plane", in_plane, {1, 72},
            "number of camera rotations about the optical axis per direction");
  v.Real("in_plane_max_rad", in_plane_max_rad, {0, std::numbers::pi},
         "maximum camera rotation about the optical axis, rad");
  v.Real("side_diameters", side_diameters, {0.3, 5}, "side of a crop, object diameters");
  v.Real("distance_diameters", distance_diameters, {2, 100},
         "distance from the camera to the object center, object diameters");
  v.Real("focal_px", focal_px, {50, 10000}, "focal length, px");
  v.Real("apart_rad", apart_rad, {0, 0.02},
         "minimum angle from a test view to all other views, rad");
}

std::vector<Eigen::Vector3d> IcosahedronDirections(int level) {
  std::vector<Eigen::Vector3d> corners;
  std::vector<Face> faces;
  MakeIcosahedron(corners, faces);
  for (int cut = 0; cut < level; ++cut) {
    std::map<std::pair<int, int>, int> midpoints;  // index of the center of each edge
    const auto midpoint = [&](int a, int b) {
      const auto [entry, is_new] =
          midpoints.try_emplace(std::minmax(a, b), static_cast<int>(corners.size()));
      if (is_new) corners.push_back((corners[a] + corners[b]).normalized());
      return entry->second;
    };
    std::vector<Face> finer;
    for (const Face& f : faces) {
      const int ab = midpoint(f[0], f[1]), bc = midpoint(f[1], f[2]), ca = midpoint(f[2], f[0]);
      finer.insert(finer.end(), {{f[0], ab, ca}, {f[1], bc, ab}, {f[2], ca, bc}, {ab, bc, ca}});
    }
    faces = std::move(finer);
  }
  return corners;
}

Eigen::Matrix3d RotationOfView(const Eigen::Vector3d& direction_O, double in_plane_rad) {
  // At the pole the camera looks down the object's z axis: its own z axis is -z of O.
  const Eigen::Matrix3d R_OC_pole =
      Eigen::AngleAxisd(std::numbers::pi, Eigen::Vector3d::UnitX()).toRotationMatrix();
  const Eigen::Matrix3d arc =
      RotationBetween(Eigen::Vector3d::UnitZ(), direction_O).toRotationMatrix();
  const Eigen::Matrix3d turn =
      Eigen::AngleAxisd(in_plane_rad, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  return (arc * R_OC_pole * turn).transpose();
}

Rotations TemplateRotations(const CropViewOptions& options) {
  return RotationsFrom(IcosahedronDirections(options.template_level), 0, options);
}

Rotations TrainingRotations(const CropViewOptions& options) {
  // The corners of a coarser level come first in a finer level.
  const size_t templates = IcosahedronDirections(options.template_level).size();
  return RotationsFrom(IcosahedronDirections(options.train_level), templates, options);
}

Rotations TestRotations(int count, const CropViewOptions& options, Rng& rng) {
  const std::vector<Eigen::Vector3d> taken =
      IcosahedronDirections(std::max(options.template_level, options.train_level));
  const double nearest_cos = std::cos(options.apart_rad);
  const auto is_apart = [&](const Eigen::Vector3d& direction_O) {
    for (const Eigen::Vector3d& other : taken) {
      if (other.dot(direction_O) > nearest_cos) return false;
    }
    return true;
  };
  Rotations rotations;
  while (static_cast<int>(rotations.size()) < count) {
    const Eigen::Vector3d direction_O = rng.UnitVector();
    if (!IsSeen(direction_O, options) || !is_apart(direction_O)) continue;
    const double range_rad = options.in_plane > 1 ? options.in_plane_max_rad : 0;
    rotations.push_back(RotationOfView(direction_O, rng.Uniform(-range_rad, range_rad)));
  }
  return rotations;
}

double CropSide_m(const ObjectModel& object, const CropViewOptions& options) {
  return options.side_diameters * object.diameter_m;
}

Eigen::Vector3d CropCenter_O(const ObjectModel& object) {
  return MeshBounds(object.mesh_O).center();
}

CameraIntrinsics CropCamera(const CropViewOptions& options, double wider) {
  const double side_px = options.focal_px * options.side_diameters / options.distance_diameters;
  const int size = 2 * static_cast<int>(std::ceil(0.5 * kMargin * wider * side_px));
  const double center_px = 0.5 * (size - 1);
  return {size, size, options.focal_px, options.focal_px, center_px, center_px};
}

Pose CropPose(const ObjectModel& object, const Eigen::Matrix3d& R_CO,
              const CropViewOptions& options) {
  const Eigen::Vector3d center_C(0, 0, options.distance_diameters * object.diameter_m);
  return MakePose(R_CO, center_C - R_CO * CropCenter_O(object));
}

void ForEachCropView(LabelledViewSource& views, ObjectId object, const Rotations& R_CO,
                     const CropViewOptions& options, uint64_t seed,
                     const std::function<void(const LabelledView& view)>& take) {
  CheckSettings("CropViewOptions", options);
  constexpr size_t kBatch = 512;  // frames held at once
  const CameraIntrinsics camera = CropCamera(options);
  for (size_t begin = 0; begin < R_CO.size(); begin += kBatch) {
    std::vector<Pose> X_CO;
    for (size_t i = begin; i < std::min(R_CO.size(), begin + kBatch); ++i) {
      X_CO.push_back(CropPose(*views.objects()[object], R_CO[i], options));
    }
    for (const LabelledView& view : views.Isolated(object, X_CO, camera, seed + begin)) take(view);
  }
}

ObjectCrops RenderCrops(LabelledViewSource& views, ObjectId object, const Rotations& R_CO,
                        const CropViewOptions& options, uint64_t seed) {
  CheckSettings("CropViewOptions", options);
  const ObjectModel& model = *views.objects()[object];
  ObjectCrops out{object, R_CO, {}};
  ForEachCropView(views, object, R_CO, options, seed, [&](const LabelledView& view) {
    const CropSpot spot{view.instances.front().X_CO * CropCenter_O(model),
                        CropSide_m(model, options)};
    AppendCrop(view.frame, spot, &view.ids, out.crops);
  });
  return out;
}

namespace {

void AppendAll(const ObjectCrops& from, ObjectCrops& to) {
  to.R_CO.insert(to.R_CO.end(), from.R_CO.begin(), from.R_CO.end());
  for (size_t i = 0; i < from.crops.size(); ++i) AppendRow(from.crops, i, to.crops);
}

}  // namespace

CropTrainingSet MakeCropTrainingSet(LabelledViewSource& clean, LabelledViewSource& varied,
                                    const CropViewOptions& options, uint64_t seed,
                                    const std::function<bool(double share)>& on_share) {
  CheckSettings("CropViewOptions", options);
  CropTrainingSet training_set{clean.objects(), {}, {}};
  const Rotations templates = TemplateRotations(options), further = TrainingRotations(options);
  Rotations all = templates;
  all.insert(all.end(), further.begin(), further.end());
  const int object_count = static_cast<int>(training_set.objects.size());
  for (ObjectId object{0}; object < object_count; ++object) {
    if (on_share && !on_share(1.0 * object / object_count)) break;
    const auto stream = [&](const char* name) { return Rng::Derive(seed, object, name).Next(); };
    training_set.templates.push_back(
        RenderCrops(clean, object, templates, options, stream("templates")));
    training_set.training.push_back(
        RenderCrops(clean, object, further, options, stream("further")));
    AppendAll(RenderCrops(varied, object, all, options, stream("varied")),
              training_set.training.back());
  }
  return training_set;
}

}  // namespace pickbed::perception
