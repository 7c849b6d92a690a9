#include "eval/export/pick_animation.h"

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>

#include "eval/draw/gif.h"
#include "eval/draw/outline.h"
#include "eval/export/scene_glb.h"
#include "scenes/base/files.h"
#include "scenes/base/ids_format.h"
#include "scenes/image/srgb.h"
#include "sim/render/picture.h"

namespace pickbed::eval {
namespace {

constexpr double kFrame_s = 1.0 / 12;
constexpr double kFreeMargin = 0.02;  // of the image, at each side
constexpr uint16_t kHandId = 0xfff0;  // above the ids of instances
const Eigen::Vector3f kHandColor{0.030f, 0.033f, 0.038f};
// The table on which an object is set down.
const Eigen::Vector3f kSetDownTableColor{0.342f, 0.319f, 0.285f};

Pose Shifted(const Eigen::Vector3d& by) { return Pose(Eigen::Translation3d(by)); }

// All boxes of the hand at an opening.
std::vector<AxisAlignedBox> HandBoxes(const Gripper& gripper, double opening_m) {
  std::vector<AxisAlignedBox> boxes = gripper.Boxes(opening_m);
  const std::vector<AxisAlignedBox> soft = gripper.SoftBoxes();
  boxes.insert(boxes.end(), soft.begin(), soft.end());
  return boxes;
}

// Meshes of the boxes, each with its center at the origin.
std::vector<TriangleMesh> CenteredMeshes(const std::vector<AxisAlignedBox>& boxes) {
  std::vector<TriangleMesh> meshes;
  for (const AxisAlignedBox& box : boxes) {
    meshes.push_back(BoxesMesh({{Eigen::Vector3d::Zero(), box.half_size}}));
  }
  return meshes;
}

Eigen::Vector4f SrgbOf(const Eigen::Vector3f& linear, float alpha) {
  return {SrgbOfLinear(linear.x()), SrgbOfLinear(linear.y()), SrgbOfLinear(linear.z()), alpha};
}

// Color of an object in the GLB file, which holds no textures.
Eigen::Vector4f ColorOf(const ObjectModel& object) {
  const sim::PictureMaterial material = sim::PictureMaterialOf(object);
  if (material.color.x() >= 0) return SrgbOf(material.color, 1);
  const Rgb8 c = object.mesh_O.base_color;
  return {c.r / 255.0f, c.g / 255.0f, c.b / 255.0f, 1};
}

bool Moves(const PickMotion& motion, size_t position) {
  const Pose& first = motion.frames.front().X_WO[position];
  return std::any_of(motion.frames.begin(), motion.frames.end(), [&](const MotionFrame& frame) {
    return !frame.X_WO[position].isApprox(first, 1e-6);
  });
}

// A camera in front of the bin and above it, which sees the bin and all of the pick.
Camera MovieCamera(const PickMotion& motion, const ObjectSet& objects, const Gripper& gripper,
                   const MovieOptions& options) {
  std::vector<Eigen::Vector3d> seen_W;
  const auto see = [&](const Bounds& bounds, const Pose& X_WB) {
    const Eigen::Matrix<double, 3, 8> corners = bounds.Corners();
    for (const auto& corner : corners.colwise()) seen_W.push_back(X_WB * corner);
  };
  see(MeshBounds(BinMesh(motion.scene.bin)), Pose::Identity());
  for (const MotionFrame& frame : motion.frames) {
    for (const AxisAlignedBox& box : HandBoxes(gripper, frame.opening_m)) {
      see({box.center - box.half_size, box.center + box.half_size}, frame.X_WG);
    }
  }
  for (size_t i = 0; i < motion.scene.objects.size(); ++i) {
    if (!Moves(motion, i)) continue;
    const Bounds bounds = MeshBounds(objects[motion.scene.objects[i].object]->mesh_O);
    for (const MotionFrame& frame : motion.frames) see(bounds, frame.X_WO[i]);
  }
  return CameraAround(seen_W, {0.22, -0.78, 0.72}, kFreeMargin, options.width_px, options.height_px,
                      1.35 * options.width_px);
}

}  // namespace

std::string PickGlb(const PickMotion& motion, const ObjectSet& objects, const Gripper& gripper) {
  constexpr int kMaxFaces = 3000;  // of an object; a scan can have a hundred times as many
  ShownMeshes meshes(objects, kMaxFaces);
  const TriangleMesh bin = BinMesh(motion.scene.bin);
  std::vector<GlbPart> glb_parts{{"bin", &bin, Pose::Identity(), {0.40f, 0.46f, 0.55f, 0.35f}}};
  for (size_t i = 0; i < motion.scene.objects.size(); ++i) {
    const PosedObject& posed = motion.scene.objects[i];
    const ObjectModel& model = *objects[posed.object];
    GlbPart& glb_part =
        glb_parts.emplace_back(GlbPart{fmt::format("{} {}", posed.instance, model.name),
                                       &meshes.Of(posed.object), posed.X_WO, ColorOf(model)});
    if (!Moves(motion, i)) continue;
    for (const MotionFrame& frame : motion.frames) glb_part.track_W.push_back(frame.X_WO[i]);
  }
  TriangleMesh table;
  if (motion.table_W) {
    table = BoxesMesh({*motion.table_W});
    glb_parts.push_back({"table", &table, Pose::Identity(), SrgbOf(kSetDownTableColor, 1)});
  }
  const std::vector<TriangleMesh> hand =
      CenteredMeshes(HandBoxes(gripper, motion.frames.front().opening_m));
  std::vector<std::vector<Pose>> tracks_W(hand.size());
  for (const MotionFrame& frame : motion.frames) {
    const std::vector<AxisAlignedBox> boxes = HandBoxes(gripper, frame.opening_m);
    for (size_t b = 0; b < boxes.size(); ++b) {
      tracks_W[b].push_back(frame.X_WG * Shifted(boxes[b].center));
    }
  }
  for (size_t b = 0; b < hand.size(); ++b) {
    const Pose X_W = tracks_W[b].front();
    glb_parts.push_back(
        {fmt::format("hand {}", b), &hand[b], X_W, SrgbOf(kHandColor, 1), std::move(tracks_W[b])});
  }
  return GlbBytes(glb_parts, {}, motion.frame_s);
}

struct PickMovie::Impl {
  Impl(const ObjectSet& used_objects, const Bin& bin, const Gripper& used_gripper,
       const MovieOptions& used_options)
      : objects(used_objects),
        gripper(used_gripper),
        options(used_options),
        renderer(objects, bin),
        pictures(renderer, objects) {}

  const ObjectSet& objects;
  const Gripper& gripper;
  MovieOptions options;
  sim::SceneRenderer renderer;
  sim::PictureRenderer pictures;
  std::vector<int> hand;  // mesh handles of its boxes

  // Returns the mesh handle of the table and its pose. All picks share one table.
  sim::RenderInstance Table(const AxisAlignedBox& table_W) {
    if (!table_mesh || table_half_size_m != table_W.half_size) {
      table_mesh = renderer.renderer().AddMesh(CenteredMeshes({table_W}).front());
      table_half_size_m = table_W.half_size;
    }
    return {*table_mesh, Shifted(table_W.center), kHandId + 1};
  }

 private:
  std::optional<int> table_mesh;
  Eigen::Vector3d table_half_size_m = Eigen::Vector3d::Zero();
};

void MovieOptions::Validate() const {
  const auto within = [](const char* name, double value, double low, double high) {
    if (value >= low && value <= high) return;
    throw std::logic_error(fmt::format("MovieOptions::{} is {}", name, value));
  };
  within("width_px", width_px, 16, 4096);
  within("height_px", height_px, 16, 4096);
  within("every", every, 1, 100);
  within("speed", speed, 0.1, 10);
  within("threads", threads, 1, 1024);
}

PickMovie::PickMovie(const ObjectSet& objects, const Bin& bin, const Gripper& gripper,
                     const MovieOptions& options)
    : impl_((options.Validate(), new Impl(objects, bin, gripper, options))) {
  for (const TriangleMesh& mesh : CenteredMeshes(HandBoxes(gripper, gripper.MaxOpening_m()))) {
    impl_->hand.push_back(impl_->renderer.renderer().AddMesh(mesh));
  }
}

PickMovie::~PickMovie() = default;

std::string PickMovie::Gif(const PickMotion& motion) {
  const sim::PictureMaterial hand_material{sim::Finish::kPlastic, kHandColor};
  const sim::PictureMaterial table_material{sim::Finish::kMatte, kSetDownTableColor};
  const Camera camera = MovieCamera(motion, impl_->objects, impl_->gripper, impl_->options);
  Scene scene = motion.scene;
  std::vector<Image<Rgb8>> pictures;
  for (size_t f = 0; f < motion.frames.size(); f += impl_->options.every) {
    const MotionFrame& frame = motion.frames[f];
    for (size_t i = 0; i < scene.objects.size(); ++i) scene.objects[i].X_WO = frame.X_WO[i];
    std::vector<sim::PictureInstance> more;
    const std::vector<AxisAlignedBox> boxes = HandBoxes(impl_->gripper, frame.opening_m);
    for (size_t b = 0; b < boxes.size(); ++b) {
      more.push_back(
          {{impl_->hand[b], frame.X_WG * Shifted(boxes[b].center), kHandId}, hand_material});
    }
    if (motion.table_W) more.push_back({impl_->Table(*motion.table_W), table_material});
    const sim::PictureOptions effort{.scale = 1, .samples = 2, .threads = impl_->options.threads};
    pictures.push_back(impl_->pictures.Render(scene, camera, effort, more).color);
  }
  return GifBytes(pictures, impl_->options.every * motion.frame_s / impl_->options.speed);
}

PickAnimation::PickAnimation(const std::filesystem::path& folder, bool with_gif, int attempt)
    : folder_(folder), with_gif_(with_gif), only_(attempt) {}

std::string PickAnimationName(int attempt) {
  return fmt::format("attempt_{:02}_pick.glb", attempt);
}

PickAnimation::~PickAnimation() = default;

void PickAnimation::OnStage(TrialStage stage, const AttemptState& attempt) {
  const int number = attempt.record.attempt;
  if (stage == TrialStage::kGrasp) {
    wanted_ = only_ < 0 || only_ == number;
    motion_ = {attempt.scene, {}, kFrame_s, std::nullopt};
  }
  if (stage != TrialStage::kOutcome || !wanted_ || motion_.frames.empty()) return;
  MakeFolder(folder_);
  if (objects_.empty()) objects_ = attempt.cell.TrueObjects(attempt.bin_index);
  WriteFileAtomically(folder_ / PickAnimationName(number),
                      PickGlb(motion_, objects_, *attempt.gripper));
  ++written_;
  if (!with_gif_) return;
  if (movie_hand_ != attempt.gripper) {
    movie_ = std::make_unique<PickMovie>(objects_, motion_.scene.bin, *attempt.gripper);
    movie_hand_ = attempt.gripper;
  }
  WriteFileAtomically(folder_ / fmt::format("attempt_{:02}_pick.gif", number),
                      movie_->Gif(motion_));
}

MotionListener PickAnimation::ListenToMotion() {
  if (!wanted_) return {};
  return [this, next_s = 0.0](const MotionState& state) mutable {
    if (state.table_W != nullptr) motion_.table_W = *state.table_W;
    if (state.time_s < next_s) return;
    next_s += kFrame_s;
    MotionFrame& frame = motion_.frames.emplace_back();
    for (int i = 0; i < state.world.instance_count(); ++i) {
      frame.X_WO.push_back(state.world.PoseOf(i));
    }
    frame.X_WG = state.hand.X_WG();
    frame.opening_m = state.hand.opening_m();
  };
}

}  // namespace pickbed::eval
