#include "perception/segment_poses/volume_codebook.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "perception/completion/random_view.h"
#include "perception/features/labelled_patches.h"
#include "scenes/base/byte_blocks.h"
#include "scenes/base/error.h"

namespace pickbed::perception {
namespace {

constexpr int kBlock = 64;         // views rendered and completed together
constexpr float kBehind_m = 0.3f;  // background behind the object

using Rows = Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

Pose RandomPose(const ObjectModel& model, const VolumeBookOptions& options, Rng& rng) {
  const double spread = options.distance_spread;
  const double z_m = options.distance_m * rng.Uniform(1 - spread, 1 + spread);
  const Pose X_CM = MakePose(rng.Rotation().toRotationMatrix(), {0, 0, z_m});
  return X_CM * Translation(-MeshBounds(model.mesh_O).center());
}

SegmentView ViewOfObject(const LabelledView& labelled, const VolumeBookOptions& options, Rng& rng) {
  SegmentView view;
  view.intrinsics = labelled.frame.intrinsics;
  view.depth_m = IsolatedCloud(labelled).depth_m;
  view.segment = Image<uint8_t>(view.depth_m.width(), view.depth_m.height(), 0);
  const float behind_m =
      static_cast<float>(labelled.instances.at(0).X_CO.translation().z()) + kBehind_m;
  for (size_t i = 0; i < view.depth_m.size(); ++i) {
    float& z_m = view.depth_m.pixels()[i];
    if (labelled.ids.pixels()[i] != 0) {
      view.segment.pixels()[i] = z_m > 0;
    } else {
      z_m = behind_m;
    }
  }
  const bool is_occluded = rng.Uniform() < options.occluded_share;
  const double hidden = rng.Uniform(options.min_hidden, options.max_hidden);
  view.occluders = is_occluded ? DrawOccluder(hidden, view.segment, rng, view.depth_m)
                               : Image<uint8_t>(view.depth_m.width(), view.depth_m.height(), 0);
  for (size_t i = 0; i < view.segment.size(); ++i) {
    if (view.occluders.pixels()[i]) view.segment.pixels()[i] = 0;
  }
  return view;
}

}  // namespace

void VolumeBookOptions::Visit(SettingsVisitor& v) {
  v.Integer("views", views, {1, 100000}, "completed views of each object in its codebook");
  v.Real("occluded_share", occluded_share, {0, 1}, "share of these views with an occluder");
  v.Real("min_hidden", min_hidden, {0, 0.9}, "smallest share of the pixels that it hides");
  v.Real("max_hidden", max_hidden, {0, 0.9}, "largest share of the pixels that it hides");
  v.Real("distance_m", distance_m, {0.01, 100}, "distance from the camera to the object, m");
  v.Real("distance_spread", distance_spread, {0, 0.9}, "relative spread of the camera distance");
  v.Real("focal_px", focal_px, {1, 1e6}, "focal length, px");
  v.Seed("seed", seed, "random seed of the views");
}

VolumeBook MakeVolumeBook(LabelledViewSource& views, ObjectId object, ShapeCompleter& completer,
                          const VolumeBookOptions& options,
                          const std::function<void(double)>& on_share) {
  CheckSettings("VolumeBookOptions", options);
  const ObjectModel& model = *views.objects()[object];
  IsolatedOptions isolated;
  isolated.distance_m = options.distance_m;
  isolated.distance_spread = options.distance_spread;
  isolated.focal_px = options.focal_px;
  const CameraIntrinsics camera = CropCamera(MeshBounds(model.mesh_O).size().norm(), isolated);
  VolumeBook book;
  book.side_m = kDescriptorSide * model.diameter_m;
  for (int first = 0; first < options.views; first += kBlock) {
    const int count = std::min(kBlock, options.views - first);
    Rng rng = Rng::Derive(options.seed, first, "volumes/" + model.name);
    std::vector<Pose> poses;
    for (int i = 0; i < count; ++i) poses.push_back(RandomPose(model, options, rng));
    std::vector<SegmentView> segments;
    const std::vector<LabelledView> rendered = views.Isolated(object, poses, camera, rng.Next());
    for (const LabelledView& view : rendered) {
      segments.push_back(ViewOfObject(view, options, rng));
    }
    const std::vector<CompletedVolume> volumes = completer.CompleteAll(segments);
    for (size_t i = 0; i < volumes.size(); ++i) {
      const std::optional<Pose> X_CF = VolumeFrame(volumes[i]);
      if (!X_CF) continue;
      AppendVolumeDescriptor(volumes[i], *X_CF, 0, book.side_m, book.values);
      book.X_FO.push_back(X_CF->inverse() * rendered[i].instances.at(0).X_CO);
    }
    if (on_share) on_share(static_cast<double>(first + count) / options.views);
  }
  return book;
}

std::vector<Pose> NearestVolumes(const VolumeBook& book, const CompletedVolume& query,
                                 const Pose& X_CF, int count) {
  const auto entries = static_cast<Eigen::Index>(book.size());
  if (entries == 0) return {};
  std::vector<float> turned;
  for (int turn = 0; turn < kDescriptorTurns; ++turn) {
    const double angle_rad = 2 * std::numbers::pi * turn / kDescriptorTurns;
    AppendVolumeDescriptor(query, X_CF, angle_rad, book.side_m, turned);
  }
  const Eigen::Map<const Rows> rows(turned.data(), kDescriptorTurns, kDescriptorValues);
  const Eigen::Map<const Rows> known(book.values.data(), entries, kDescriptorValues);
  const Eigen::MatrixXf products = known * rows.transpose();
  const Eigen::VectorXf known_norms = known.rowwise().squaredNorm();
  const Eigen::VectorXf row_norms = rows.rowwise().squaredNorm();
  struct Found {
    float squared;
    int entry, turn;
  };
  std::vector<Found> found;
  for (int entry = 0; entry < entries; ++entry) {
    int turn = 0;
    const float squared =
        (row_norms.transpose() - 2 * products.row(entry)).minCoeff(&turn) + known_norms[entry];
    found.push_back({squared, entry, turn});
  }
  const size_t kept = std::min<size_t>(count, found.size());
  std::partial_sort(found.begin(), found.begin() + static_cast<std::ptrdiff_t>(kept), found.end(),
                    [](const Found& a, const Found& b) {
                      return std::pair(a.squared, a.entry) < std::pair(b.squared, b.entry);
                    });
  std::vector<Pose> X_FO;
  for (size_t i = 0; i < kept; ++i) {
    // The turned grid of the query equals the grid of the entry.
    const double angle_rad = 2 * std::numbers::pi * found[i].turn / kDescriptorTurns;
    const Eigen::AngleAxisd R_FG(angle_rad, Eigen::Vector3d::UnitZ());
    X_FO.push_back(MakePose(R_FG.toRotationMatrix(), Eigen::Vector3d::Zero()) *
                   book.X_FO[found[i].entry]);
  }
  return X_FO;
}

std::string VolumeBookToBytes(const VolumeBook& book, uint64_t key) {
  std::vector<uint8_t> bytes;
  for (const float value : book.values) {
    bytes.push_back(static_cast<uint8_t>(std::lround(255 * std::clamp(value, 0.0f, 1.0f))));
  }
  std::vector<double> poses;
  for (const Pose& X_FO : book.X_FO) {
    const Eigen::Matrix4d matrix = X_FO.matrix();
    poses.insert(poses.end(), matrix.data(), matrix.data() + matrix.size());
  }
  BlockWriter writer;
  writer.Put(&key, sizeof key);
  writer.Put(&book.side_m, sizeof book.side_m);
  writer.Put(bytes);
  writer.Put(poses);
  return writer.body();
}

std::optional<VolumeBook> VolumeBookFromBytes(std::string_view content, uint64_t key) {
  constexpr size_t kValuesOfPose = 16;
  BlockReader reader(content);
  const std::vector<uint64_t> keys = reader.TakeAll<uint64_t>();
  const std::vector<double> sides_m = reader.TakeAll<double>();
  CheckInput(keys.size() == 1 && sides_m.size() == 1 && sides_m[0] > 0, "its head is damaged");
  if (keys[0] != key) return std::nullopt;
  VolumeBook book;
  book.side_m = sides_m[0];
  for (const uint8_t value : reader.TakeAll<uint8_t>()) {
    book.values.push_back(static_cast<float>(value) / 255);
  }
  const std::vector<double> poses = reader.TakeAll<double>();
  reader.RequireEnd();
  const size_t entries = poses.size() / kValuesOfPose;
  CheckInput(
      poses.size() == entries * kValuesOfPose && book.values.size() == entries * kDescriptorValues,
      "its descriptors and poses do not fit together");
  for (size_t entry = 0; entry < entries; ++entry) {
    Pose& X_FO = book.X_FO.emplace_back();
    X_FO.matrix() = Eigen::Map<const Eigen::Matrix4d>(poses.data() + entry * kValuesOfPose);
    CheckInput(X_FO.matrix().allFinite(), "a pose is not finite");
  }
  return book;
}

}  // namespace pickbed::perception
