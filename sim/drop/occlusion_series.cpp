#include "sim/drop/occlusion_series.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>
#include <stdexcept>

#include "scenes/base/error.h"
#include "scenes/base/ids_format.h"
#include "scenes/camera/depth_points.h"
#include "sim/drop/certified_scene.h"
#include "sim/drop/drop_layout.h"
#include "sim/render/visibility.h"

namespace pickbed::sim {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

RenderedImage IdsOf(SceneRenderer& renderer, const Scene& scene, const Camera& camera) {
  return renderer.renderer().RenderDepth(camera, renderer.InstancesOf(scene));
}

// Samples the disc uniformly, without sine and cosine, whose results depend on the C library.
Vector2d InUnitDisc(Rng& rng) {
  for (;;) {
    const double x = rng.Uniform(-1, 1), y = rng.Uniform(-1, 1);
    if (x * x + y * y <= 1) return {x, y};
  }
}

// The part of the target that is visible to the camera.
struct TargetView {
  double fraction = 0;
  std::vector<Vector3d> points_W;  // one per visible pixel
};

// Returns the top of the highest instance whose floor plan intersects the box.
double TopUnder_m(const Scene& scene, const ObjectSet& objects, const Eigen::AlignedBox2d& box_W) {
  double top_m = 0;
  for (const PosedObject& posed : scene.objects) {
    Eigen::AlignedBox3d instance_W = RotatedBox(*objects[posed.object], posed.X_WO.linear());
    instance_W.translate(posed.X_WO.translation());
    const Eigen::AlignedBox2d floor_plan(instance_W.min().head<2>(), instance_W.max().head<2>());
    if (floor_plan.intersects(box_W)) top_m = std::max(top_m, instance_W.max().z());
  }
  return top_m;
}

class Occluder {
 public:
  Occluder(SceneRenderer& renderer, const SettledScene& start, InstanceId target,
           const OcclusionSetup& setup, Rng& rng)
      : renderer_(renderer), setup_(setup), spec_(setup.spec), rng_(rng), scene_(start.scene) {
    const auto found =
        std::find_if(scene_.objects.begin(), scene_.objects.end(),
                     [&](const PosedObject& posed) { return posed.instance == target; });
    if (found == scene_.objects.end()) throw std::logic_error("the target is not in the scene");
    target_ = found - scene_.objects.begin();
    series_.target = target;
    series_.blockers.resize(spec_.bands.size());
    next_ = static_cast<int>(spec_.bands.size()) - 1;
    view_ = Observe(scene_);
    DrawLevel();
    Keep(start.certificate);
  }

  OcclusionSeries Run() {
    while (next_ >= 0) {
      BlockerCounts& counts = series_.blockers[next_];
      const bool may_go_on =
          blockers_ < spec_.max_blockers && counts.dropped < spec_.blocker_samples;
      const bool may_improve = view_.fraction > level_ && level_samples_ < spec_.level_samples;
      if (held_ && !(may_go_on && may_improve)) {
        Settle();
        continue;
      }
      if (!may_go_on) break;
      if (held_) ++level_samples_;
      TryBlocker(counts);
    }
    return std::move(series_);
  }

 private:
  void TryBlocker(BlockerCounts& counts);
  std::optional<PosedObject> DropBlocker();
  PosedObject TargetedBlocker();
  ObjectId RandomKind();
  TargetView Observe(const Scene& scene);
  void DrawLevel();                                // draws the target fraction of the next band
  void Keep(const SceneCertificate& certificate);  // holds the scene if it fits the band best
  void Settle();                                   // stores the held scene

  SceneRenderer& renderer_;
  const OcclusionSetup& setup_;
  const OcclusionSpec& spec_;
  Rng& rng_;
  Scene scene_;        // current scene
  TargetView view_;    // view of the current scene
  size_t target_ = 0;  // index into the scene's objects
  int next_ = 0;       // band to fill next
  int blockers_ = 0;   // in the current scene
  double level_ = 0;   // wanted visible fraction in the next band
  int level_samples_ = 0;
  std::optional<OccludedScene> held_;  // scene of the next band nearest to level_
  OcclusionSeries series_;
};

// Runs the cheap checks first: two thirds of the blockers hide too little or too much.
void Occluder::TryBlocker(BlockerCounts& counts) {
  ++counts.dropped;
  const std::optional<PosedObject> blocker = DropBlocker();
  if (!blocker) {
    ++counts.refused;
    return;
  }
  Scene scene = scene_;
  scene.objects.push_back(*blocker);
  TargetView view = Observe(scene);
  if (view.fraction < spec_.Inner(next_).min) {
    ++counts.jumped;
    return;
  }
  if (view.fraction > view_.fraction - spec_.min_hidden) {
    ++counts.useless;
    return;
  }
  DropOptions options = setup_.drop;
  options.wake_diameters = spec_.movement_diameters;
  const SceneCertificate certificate = CertifyRest(scene, setup_.objects, options);
  if (!Faults(certificate).empty()) {
    ++counts.refused;
    return;
  }
  ++counts.kept;
  ++blockers_;
  scene_ = std::move(scene);
  view_ = std::move(view);
  Keep(certificate);
}

// The level of the most visible band cannot exceed the initial visible fraction.
void Occluder::DrawLevel() {
  const VisibleBand band = spec_.Inner(next_);
  level_ = rng_.Uniform(band.min, std::max(band.min, std::min(band.max, view_.fraction)));
}

void Occluder::Keep(const SceneCertificate& certificate) {
  if (spec_.BandOf(view_.fraction) != next_) return;
  const auto off = [&](double fraction) { return std::abs(fraction - level_); };
  if (held_ && off(held_->visible_fraction) <= off(view_.fraction)) return;
  held_ = OccludedScene{next_, view_.fraction, blockers_, scene_, certificate};
}

void Occluder::Settle() {
  series_.scenes.push_back(std::move(*held_));
  held_.reset();
  level_samples_ = 0;
  if (--next_ >= 0) DrawLevel();
}

TargetView Occluder::Observe(const Scene& scene) {
  const std::vector<RenderInstance> instances = renderer_.InstancesOf(scene);
  const RenderedImage image = renderer_.renderer().RenderDepth(setup_.camera, instances);
  TargetView view;
  view.fraction =
      VisibleFractions(renderer_.renderer(), setup_.camera, {&instances[target_], 1}, image.ids)[0];
  const uint16_t id = instances[target_].id;
  ForEachDepthPoint(setup_.camera.intrinsics, image.depth_m,
                    [&](int u, int v, const Vector3d& p_C) {
                      if (image.ids(u, v) == id)
                        view.points_W.push_back(setup_.camera.X_WC() * p_C);
                    });
  return view;
}

ObjectId Occluder::RandomKind() {
  int left = rng_.Index(std::accumulate(setup_.counts.begin(), setup_.counts.end(), 0));
  ObjectId kind{0};
  for (; left >= setup_.counts[kind]; ++kind) left -= setup_.counts[kind];
  return kind;
}

// Returns a random object above a random visible point of the target. When it has come to rest on
// that point, its center is on the line of sight, up to the random scatter.
PosedObject Occluder::TargetedBlocker() {
  const Bin& bin = scene_.bin;
  const double clearance_m = setup_.drop.clearance_m;
  const ObjectId kind = RandomKind();
  const RotatedObject rotated =
      TurnAtRandom(setup_.objects, kind, bin, clearance_m, setup_.drop.turn_attempts, rng_);
  const double diameter_m = setup_.objects[kind]->diameter_m;
  const Vector3d seen_W = view_.points_W[rng_.Index(static_cast<int>(view_.points_W.size()))];
  const Vector3d to_eye_W = (setup_.camera.X_WC().translation() - seen_W).normalized();
  const double lift_m = 0.5 * rotated.box.sizes().z();
  // A camera that looks along the floor sees an instance one diameter in front of the point.
  const double along_m = std::min(lift_m / std::max(to_eye_W.z(), 1e-6), diameter_m);
  const Vector2d center = (seen_W + along_m * to_eye_W).head<2>() +
                          spec_.scatter_diameters * diameter_m * InUnitDisc(rng_);

  const Vector2d half = 0.5 * bin.inner_size_m.head<2>() - Vector2d::Constant(clearance_m);
  const Vector2d low = -half - rotated.box.min().head<2>(),
                 high = half - rotated.box.max().head<2>();
  const Vector2d place = (center - rotated.box.center().head<2>()).cwiseMin(high).cwiseMax(low);
  const Eigen::AlignedBox2d floor_plan(place + rotated.box.min().head<2>(),
                                       place + rotated.box.max().head<2>());
  const double bottom_m = TopUnder_m(scene_, setup_.objects, floor_plan) + clearance_m;
  int next = 0;
  for (const PosedObject& posed : scene_.objects) next = std::max(next, posed.instance + 1);
  return {InstanceId(next), kind,
          MakePose(rotated.R_WO, {place.x(), place.y(), bottom_m - rotated.box.min().z()})};
}

// Returns nullopt if the blocker fell out of the bin or did not come to rest in time.
std::optional<PosedObject> Occluder::DropBlocker() {
  const DropOptions& drop = setup_.drop;
  PosedObject blocker = TargetedBlocker();
  const ObjectModel& model = *setup_.objects[blocker.object];
  PhysicsWorld world(PhysicsFor(setup_.objects, drop.physics));
  world.AddBin(scene_.bin);
  for (const PosedObject& posed : scene_.objects) {
    world.AddInstance(*setup_.objects[posed.object], posed.X_WO, BodyMode::kStatic);
  }
  const int index = world.AddInstance(model, blocker.X_WO);
  const Eigen::AlignedBox3d box_O = RotatedBox(model, Eigen::Matrix3d::Identity());
  Pose since_X_WO = blocker.X_WO;
  double since_s = 0;
  while (!world.AllAsleep() && world.time_s() < since_s + drop.calm_s) {
    const double next_s = world.time_s() + drop.check_interval_s;
    while (world.time_s() < next_s) world.Step();
    const Pose X_WO = world.X_WO(index);
    if (world.BlewUp() || world.time_s() > drop.max_s) return std::nullopt;
    if ((X_WO * model.mass.com_O).z() < -drop.fallen_m) return std::nullopt;
    Movement movement;
    movement.Include(box_O, model.diameter_m, since_X_WO, X_WO);
    if (movement.diameters <= drop.calm_diameters) continue;
    since_X_WO = X_WO;
    since_s = world.time_s();
  }
  blocker.X_WO = world.X_WO(index);
  if (!scene_.bin.Holds(blocker.X_WO * model.mass.com_O)) return std::nullopt;
  return blocker;
}

}  // namespace

void BlockerCounts::Add(const BlockerCounts& other) {
  dropped += other.dropped;
  kept += other.kept;
  refused += other.refused;
  jumped += other.jumped;
  useless += other.useless;
}

std::vector<double> VisibleFractionsIn(SceneRenderer& renderer, const Scene& scene,
                                       const Camera& camera) {
  return renderer.VisibleFractions(scene, camera, IdsOf(renderer, scene, camera).ids);
}

std::vector<InstanceId> PossibleTargets(SceneRenderer& renderer, const Scene& scene,
                                        const std::vector<ObjectId>& wanted,
                                        const OcclusionSetup& setup) {
  const std::vector<double> fractions = VisibleFractionsIn(renderer, scene, setup.camera);
  const double minimum = setup.spec.Inner(static_cast<int>(setup.spec.bands.size()) - 1).min;
  std::vector<InstanceId> targets;
  for (size_t i = 0; i < fractions.size(); ++i) {
    const PosedObject& posed = scene.objects[i];
    const bool is_wanted = std::find(wanted.begin(), wanted.end(), posed.object) != wanted.end();
    if (is_wanted && fractions[i] > 0 && fractions[i] >= minimum) {
      targets.push_back(posed.instance);
    }
  }
  return targets;
}

OcclusionSeries OccludeTarget(SceneRenderer& renderer, const SettledScene& start, InstanceId target,
                              const OcclusionSetup& setup, Rng& rng) {
  setup.spec.Validate();
  return Occluder(renderer, start, target, setup, rng).Run();
}

namespace {

// Returns the first `maximum` targets of a random order.
std::vector<InstanceId> DrawnTargets(std::vector<InstanceId> targets, int maximum, Rng& rng) {
  for (size_t i = targets.size(); i > 1; --i) {  // Fisher-Yates shuffle
    std::swap(targets[i - 1], targets[rng.Index(static_cast<int>(i))]);
  }
  const size_t kept = std::min(targets.size(), static_cast<size_t>(maximum));
  targets.erase(targets.begin() + kept, targets.end());
  return targets;
}

// Bands are filled from the most visible one on, so all bands after the first empty one are empty
// too.
void AddToAccounts(const OcclusionSeries& series, std::vector<BandAccount>& bands) {
  for (size_t i = 0; i < bands.size(); ++i) bands[i].blockers.Add(series.blockers[i]);
  const size_t empty = bands.size() - series.scenes.size();
  if (empty > 0) ++bands[empty - 1].given_up;
}

bool DropsAny(const std::vector<ObjectId>& wanted, const std::vector<int>& counts) {
  return std::any_of(wanted.begin(), wanted.end(),
                     [&](ObjectId object) { return counts[object] > 0; });
}

}  // namespace

MadeSeries MakeOcclusionSeries(SceneRenderer& renderer, const SceneRequest& request,
                               const std::vector<ObjectId>& wanted, const OcclusionSetup& setup) {
  setup.spec.Validate();
  CheckInput(DropsAny(wanted, request.counts),
             "an occlusion trial has no object that can be its target; raise the count of one that "
             "is not a distractor");
  const OcclusionSpec& spec = setup.spec;
  MadeSeries made;
  made.bands.resize(spec.bands.size());
  std::vector<RefusedScene> refused;
  for (int scene = 0; scene < spec.scenes; ++scene) {
    SceneRequest attempt = request;
    if (scene > 0) attempt.stage = fmt::format("{}/scene_{}", request.stage, scene);
    SceneSamples samples = TryScene(attempt, setup.drop);
    for (RefusedScene& faulty : samples.refused) {
      refused.push_back({static_cast<int>(refused.size()), std::move(faulty.faults)});
    }
    if (!samples.made) continue;
    const CertifiedScene& start = *samples.made;
    if (made.start.scene.objects.empty()) made.start = start;
    Rng order = Rng::Derive(request.seed, request.bin_index, fmt::format("occlude/{}", scene));
    for (const InstanceId target :
         DrawnTargets(PossibleTargets(renderer, start.scene, wanted, setup), spec.targets, order)) {
      Rng rng =
          Rng::Derive(request.seed, request.bin_index, fmt::format("occlude/{}/{}", scene, target));
      OcclusionSeries series =
          OccludeTarget(renderer, {start.scene, start.certificate}, target, setup, rng);
      ++made.targets_tried;
      AddToAccounts(series, made.bands);
      if (series.scenes.size() <= made.series.scenes.size()) continue;
      made.series = std::move(series);
      made.start = start;
      if (made.series.scenes.size() == spec.bands.size()) break;
    }
    if (made.series.scenes.size() == spec.bands.size()) break;
  }
  made.start.refused = std::move(refused);
  for (const OccludedScene& scene : made.series.scenes) made.bands[scene.band].filled = true;
  return made;
}

}  // namespace pickbed::sim
