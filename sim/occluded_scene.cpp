#include "sim/occluded_scene.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>
#include <stdexcept>

#include "sim/layout.h"
#include "sim/visibility.h"

namespace pickbed {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

RenderedImage IdsOf(SceneRenderer& renderer, const Scene& scene, const Camera& camera) {
  return renderer.renderer().RenderDepth(camera, renderer.InstancesOf(scene));
}

// Evenly over the disc, without a libm's sine.
Vector2d InUnitDisc(Rng& rng) {
  for (;;) {
    const double x = rng.Uniform(-1, 1), y = rng.Uniform(-1, 1);
    if (x * x + y * y <= 1) return {x, y};
  }
}

// What the camera sees of the target.
struct TargetView {
  double fraction = 0;
  std::vector<Vector3d> points_W;  // one a pixel
};

// The highest of the parts under or beside a box that comes from above.
double TopUnder_m(const Scene& scene, const ObjectSet& objects, const Eigen::AlignedBox2d& box_W) {
  double top_m = 0;
  for (const PosedObject& posed : scene.objects) {
    Eigen::AlignedBox3d part_W = TurnedBox(*objects[posed.object], posed.X_WO.linear());
    part_W.translate(posed.X_WO.translation());
    const Eigen::AlignedBox2d floor_plan(part_W.min().head<2>(), part_W.max().head<2>());
    if (floor_plan.intersects(box_W)) top_m = std::max(top_m, part_W.max().z());
  }
  return top_m;
}

class Occluder {
 public:
  Occluder(SceneRenderer& renderer, const SettledScene& start, int target,
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
    view_ = Look(scene_);
    DrawLevel();
    Keep(start.certificate);
  }

  OcclusionSeries Run() {
    while (next_ >= 0) {
      BlockerCounts& counts = series_.blockers[next_];
      const bool may_go_on = blockers_ < spec_.max_blockers && counts.dropped < spec_.tries;
      const bool may_improve = view_.fraction > level_ && level_tries_ < spec_.level_tries;
      if (held_ && !(may_go_on && may_improve)) {
        Settle();
        continue;
      }
      if (!may_go_on) break;
      if (held_) ++level_tries_;
      TryBlocker(counts);
    }
    return std::move(series_);
  }

 private:
  void TryBlocker(BlockerCounts& counts);
  std::optional<PosedObject> DropBlocker();
  PosedObject AimedBlocker();
  int RandomKind();
  TargetView Look(const Scene& scene);
  void DrawLevel();                                // of the next band
  void Keep(const SceneCertificate& certificate);  // holds the scene where it fills a band
  void Settle();                                   // files what is held

  SceneRenderer& renderer_;
  const OcclusionSetup& setup_;
  const OcclusionSpec& spec_;
  Rng& rng_;
  Scene scene_;        // so far
  TargetView view_;    // of it
  size_t target_ = 0;  // index in the scene's objects
  int next_ = 0;       // band to be filled
  int blockers_ = 0;   // in the scene
  double level_ = 0;   // fraction that the next band's scene should have
  int level_tries_ = 0;
  std::optional<OccludedScene> held_;  // of the next band's scenes the nearest to that
  OcclusionSeries series_;
};

// The cheap questions come first: two thirds of the blockers hide too little or too much.
void Occluder::TryBlocker(BlockerCounts& counts) {
  ++counts.dropped;
  const std::optional<PosedObject> blocker = DropBlocker();
  if (!blocker) {
    ++counts.refused;
    return;
  }
  Scene scene = scene_;
  scene.objects.push_back(*blocker);
  TargetView view = Look(scene);
  if (view.fraction < spec_.Inner(next_).least) {
    ++counts.jumped;
    return;
  }
  if (view.fraction > view_.fraction - spec_.least_hidden) {
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

// No more can be seen of the most visible band than of the start.
void Occluder::DrawLevel() {
  const VisibleBand band = spec_.Inner(next_);
  level_ = rng_.Uniform(band.least, std::max(band.least, std::min(band.most, view_.fraction)));
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
  level_tries_ = 0;
  if (--next_ >= 0) DrawLevel();
}

TargetView Occluder::Look(const Scene& scene) {
  const std::vector<RenderInstance> instances = renderer_.InstancesOf(scene);
  const RenderedImage image = renderer_.renderer().RenderDepth(setup_.camera, instances);
  TargetView view;
  view.fraction =
      VisibleFractions(renderer_.renderer(), setup_.camera, {&instances[target_], 1}, image.ids)[0];
  const uint16_t id = instances[target_].id;
  for (int y = 0; y < image.ids.height(); ++y) {
    const uint16_t* row = image.ids.row(y);
    for (int x = 0; x < image.ids.width(); ++x) {
      if (row[x] != id) continue;
      view.points_W.push_back(setup_.camera.X_WC *
                              BackProject(setup_.camera.intrinsics, x, y, image.depth_m(x, y)));
    }
  }
  return view;
}

int Occluder::RandomKind() {
  int left = rng_.Index(std::accumulate(setup_.counts.begin(), setup_.counts.end(), 0));
  int kind = 0;
  while (left >= setup_.counts[kind]) left -= setup_.counts[kind++];
  return kind;
}

// A random part over a random point of what is still in view of the target: its middle on the line
// of sight when it has come to lie on that point, give or take the scatter.
PosedObject Occluder::AimedBlocker() {
  const Bin& bin = scene_.bin;
  const double clearance_m = setup_.drop.clearance_m;
  const int kind = RandomKind();
  const TurnedPart part =
      TurnAtRandom(setup_.objects, kind, bin, clearance_m, setup_.drop.turn_attempts, rng_);
  const double diameter_m = setup_.objects[kind]->diameter_m;
  const Vector3d seen_W = view_.points_W[rng_.Index(static_cast<int>(view_.points_W.size()))];
  const Vector3d to_eye_W = (setup_.camera.X_WC.translation() - seen_W).normalized();
  const double lift_m = 0.5 * part.box.sizes().z();
  // A camera that looks along the floor sees a part that lies one diameter before the point.
  const double along_m = std::min(lift_m / std::max(to_eye_W.z(), 1e-6), diameter_m);
  const Vector2d middle = (seen_W + along_m * to_eye_W).head<2>() +
                          spec_.scatter_diameters * diameter_m * InUnitDisc(rng_);

  const Vector2d half = 0.5 * bin.inner_size_m.head<2>() - Vector2d::Constant(clearance_m);
  const Vector2d low = -half - part.box.min().head<2>(), high = half - part.box.max().head<2>();
  const Vector2d place = (middle - part.box.center().head<2>()).cwiseMin(high).cwiseMax(low);
  const Eigen::AlignedBox2d floor_plan(place + part.box.min().head<2>(),
                                       place + part.box.max().head<2>());
  const double bottom_m = TopUnder_m(scene_, setup_.objects, floor_plan) + clearance_m;
  int instance = 0;
  for (const PosedObject& posed : scene_.objects) instance = std::max(instance, posed.instance + 1);
  return {instance, kind,
          MakePose(part.R_WO, {place.x(), place.y(), bottom_m - part.box.min().z()})};
}

// Nothing when the blocker fell out of the bin or found no rest in time.
std::optional<PosedObject> Occluder::DropBlocker() {
  const DropOptions& drop = setup_.drop;
  PosedObject blocker = AimedBlocker();
  const ObjectModel& model = *setup_.objects[blocker.object];
  PhysicsWorld world(PhysicsFor(setup_.objects, drop.physics));
  world.AddBin(scene_.bin);
  for (const PosedObject& posed : scene_.objects) {
    world.AddPart(*setup_.objects[posed.object], posed.X_WO, BodyMode::kStatic);
  }
  const int part = world.AddPart(model, blocker.X_WO);
  const Eigen::AlignedBox3d box_O = TurnedBox(model, Eigen::Matrix3d::Identity());
  Pose since_X_WO = blocker.X_WO;
  double since_s = 0;
  while (!world.AllAsleep() && world.time_s() < since_s + drop.calm_s) {
    const double next_s = world.time_s() + drop.check_interval_s;
    while (world.time_s() < next_s) world.Step();
    const Pose X_WO = world.X_WO(part);
    if (world.BlewUp() || world.time_s() > drop.max_s) return std::nullopt;
    if ((X_WO * model.mass.com_O).z() < -drop.fallen_m) return std::nullopt;
    Movement movement;
    movement.Include(box_O, model.diameter_m, since_X_WO, X_WO);
    if (movement.diameters <= drop.calm_diameters) continue;
    since_X_WO = X_WO;
    since_s = world.time_s();
  }
  blocker.X_WO = world.X_WO(part);
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

std::vector<int> PossibleTargets(SceneRenderer& renderer, const Scene& scene,
                                 const std::vector<int>& wanted, const OcclusionSetup& setup) {
  const std::vector<double> fractions = VisibleFractionsIn(renderer, scene, setup.camera);
  const double least = setup.spec.Inner(static_cast<int>(setup.spec.bands.size()) - 1).least;
  std::vector<int> targets;
  for (size_t i = 0; i < fractions.size(); ++i) {
    const PosedObject& posed = scene.objects[i];
    const bool is_wanted = std::find(wanted.begin(), wanted.end(), posed.object) != wanted.end();
    if (is_wanted && fractions[i] > 0 && fractions[i] >= least) {
      targets.push_back(posed.instance);
    }
  }
  return targets;
}

OcclusionSeries OccludeTarget(SceneRenderer& renderer, const SettledScene& start, int target,
                              const OcclusionSetup& setup, Rng& rng) {
  return Occluder(renderer, start, target, setup, rng).Run();
}

}  // namespace pickbed
