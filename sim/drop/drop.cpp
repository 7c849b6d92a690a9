#include "sim/drop/drop.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <stdexcept>

#include "scenes/base/error.h"
#include "sim/drop/certificate.h"
#include "sim/drop/certified_scene.h"
#include "sim/drop/drop_layout.h"
#include "sim/drop/penetration.h"

namespace pickbed::sim {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

class Pouring {
 public:
  Pouring(const Bin& bin, const ObjectSet& objects, const DropOptions& options, Rng& rng);
  DropResult Run(const std::vector<int>& counts);

 private:
  void Pour(const std::vector<ObjectId>& kinds);
  void PlaceApart(const std::vector<ObjectId>& kinds);
  void PourLayers(const std::vector<RotatedObject>& instances);
  void AddLayer(const std::vector<Cell>& cells);
  void PourAgain(const std::vector<int>& taken_out);
  std::vector<int> Faulty() const;
  void Settle();
  void StepFor(double duration_s);  // also removes bodies that fell beside the bin
  double Top_m() const;             // of the highest instance
  bool InBin(int index) const;
  bool StepUntilStill(double window_s, double limit_diameters, double deadline_s,
                      double few_deadline_s);
  bool StepUntilCalm(bool may_pour_again);
  Movement MovementOf(int index) const;  // since the poses in still_X_WO_
  Movement LargestMovement() const;
  EnergySample Energy() const;
  std::vector<int> Poured() const;  // without the instances that were taken out
  Scene SceneOf(const std::vector<int>& indices) const;
  DropResult Result() const;

  const Bin& bin_;
  Bin shaft_;  // pouring region: the bin, or a shaft over its center
  const ObjectSet& objects_;
  const DropOptions& options_;
  Rng& rng_;
  PhysicsWorld world_;
  std::vector<Eigen::AlignedBox3d> boxes_O_;  // indexed by object
  std::vector<ObjectId> object_of_instance_;
  std::vector<bool> taken_out_;  // by index in the world; another instance was poured instead
  std::vector<EnergySample> energy_;
  std::vector<Pose> still_X_WO_;  // by index: poses when a body last moved by more than the limit
  std::vector<int> movers_;       // bodies that moved by more than the limit at that time
  Movement movement_;             // since then
  bool at_rest_ = false;
  int without_place_ = 0;  // instances without room (Arrangement::kPacked)
};

// The shaft is wide enough for each object, in any rotation about the vertical.
Bin ShaftOver(const Bin& bin, const ObjectSet& objects, const DropOptions& options) {
  Bin shaft = bin;
  if (options.arrangement != Arrangement::kHeap) return shaft;
  double widest_m = 0;
  for (const auto& object : objects) widest_m = std::max(widest_m, object->diameter_m);
  const double min_m = widest_m + 2 * options.clearance_m;
  for (int axis = 0; axis < 2; ++axis) {
    const double size_m = bin.inner_size_m[axis];
    shaft.inner_size_m[axis] = std::min(size_m, std::max(options.shaft_share * size_m, min_m));
  }
  return shaft;
}

Pouring::Pouring(const Bin& bin, const ObjectSet& objects, const DropOptions& options, Rng& rng)
    : bin_(bin),
      shaft_(ShaftOver(bin, objects, options)),
      objects_(objects),
      options_(options),
      rng_(rng),
      world_(PhysicsFor(objects, options.physics)) {
  world_.AddBin(bin);
  for (const auto& object : objects) {
    boxes_O_.push_back(RotatedBox(*object, Eigen::Matrix3d::Identity()));
  }
}

DropResult Pouring::Run(const std::vector<int>& counts) {
  std::vector<ObjectId> kinds;
  for (size_t i = 0; i < counts.size(); ++i) {
    kinds.insert(kinds.end(), counts[i], ObjectId(i));
  }
  for (size_t i = kinds.size(); i > 1; --i) {  // Fisher-Yates shuffle
    std::swap(kinds[i - 1], kinds[rng_.Index(static_cast<int>(i))]);
  }
  if (options_.arrangement == Arrangement::kPacked) {
    PlaceApart(kinds);
  } else {
    world_.AddFunnel(shaft_, options_.funnel_m);
    Pour(kinds);
  }
  Settle();
  return Result();
}

void Pouring::Pour(const std::vector<ObjectId>& kinds) {
  std::vector<RotatedObject> instances;
  for (const ObjectId kind : kinds) {
    instances.push_back(
        TurnAtRandom(objects_, kind, shaft_, options_.clearance_m, options_.turn_attempts, rng_));
  }
  PourLayers(instances);
}

void Pouring::PlaceApart(const std::vector<ObjectId>& kinds) {
  const std::vector<PlacedInstance> placed =
      PlaceUpright(objects_, kinds, bin_, options_.clearance_m, options_.place_attempts, rng_);
  for (const PlacedInstance& instance : placed) {
    world_.AddInstance(*objects_[instance.object], instance.X_WO);
    object_of_instance_.push_back(instance.object);
    taken_out_.push_back(false);
  }
  without_place_ = static_cast<int>(kinds.size() - placed.size());
}

void Pouring::PourLayers(const std::vector<RotatedObject>& instances) {
  for (size_t poured = 0; poured < instances.size();) {
    const std::vector<Cell> cells = PackLayer(instances, poured, shaft_, options_.clearance_m);
    AddLayer(cells);
    poured += cells.size();
    StepFor(options_.layer_interval_s);
  }
}

// The whole layer is mirrored and shifted at random, so that no corner of the bin is preferred.
void Pouring::AddLayer(const std::vector<Cell>& cells) {
  const Vector2d inner = shaft_.inner_size_m.head<2>();
  Vector2d used = Vector2d::Zero();
  for (const Cell& cell : cells) {
    used = used.cwiseMax(cell.low + cell.instance->box.sizes().head<2>());
  }
  const Vector2d slack = (inner - used).cwiseMax(0) - Vector2d::Constant(options_.clearance_m);
  const Vector2d shift(rng_.Uniform() * std::max(0.0, slack.x()),
                       rng_.Uniform() * std::max(0.0, slack.y()));
  const bool mirror_x = rng_.Index(2) == 1, mirror_y = rng_.Index(2) == 1;
  const double bottom_m = Top_m() + options_.clearance_m;
  for (const Cell& cell : cells) {
    const Eigen::AlignedBox3d& box = cell.instance->box;
    Vector2d low = cell.low + shift;
    if (mirror_x) low.x() = inner.x() - low.x() - box.sizes().x();
    if (mirror_y) low.y() = inner.y() - low.y() - box.sizes().y();
    low -= 0.5 * inner;
    const Vector3d p_WO = Vector3d(low.x(), low.y(), bottom_m) - box.min();
    world_.AddInstance(*objects_[cell.instance->object], MakePose(cell.instance->R_WO, p_WO));
    object_of_instance_.push_back(cell.instance->object);
    taken_out_.push_back(false);
  }
}

// Takes these instances out and pours new ones of their kinds.
void Pouring::PourAgain(const std::vector<int>& taken_out) {
  std::vector<ObjectId> kinds;
  for (const int index : taken_out) {
    taken_out_[index] = true;
    world_.RemoveInstance(index);
    kinds.push_back(object_of_instance_[index]);
  }
  Pour(kinds);
}

// The upper instance of each overlapping pair, and all instances that have not come to rest.
// Instances that fell beside the bin are not among them, because the certificate reports them.
std::vector<int> Pouring::Faulty() const {
  std::set<int> faulty;
  std::vector<int> poured = Poured();
  const auto fell = [&](int index) { return world_.body(index).body == nullptr; };
  poured.erase(std::remove_if(poured.begin(), poured.end(), fell), poured.end());
  const auto height_m = [&](int index) {
    return (world_.X_WO(index) * objects_[object_of_instance_[index]]->mass.com_O).z();
  };
  const double limit_m = CertificateLimits().penetration_m;
  for (const Overlap& overlap : OverlapsDeeperThan(limit_m, SceneOf(poured), objects_)) {
    const int first = poured[overlap.first];
    const int second = overlap.second < 0 ? first : poured[overlap.second];
    faulty.insert(height_m(first) < height_m(second) ? second : first);
  }
  for (const int index : movers_) {
    if (!at_rest_ && !fell(index)) faulty.insert(index);
  }
  return {faulty.begin(), faulty.end()};
}

// Steps until all instances are calm, at most for half of max_s. Returns whether they are. If they
// may be poured again, a few that still move after a quarter of max_s end it: a single rocking
// instance would keep all others waiting.
bool Pouring::StepUntilCalm(bool may_pour_again) {
  const double start_s = world_.time_s();
  const double patience_s = may_pour_again ? 0.25 * options_.max_s : options_.max_s;
  return StepUntilStill(options_.calm_s, options_.calm_diameters, start_s + 0.5 * options_.max_s,
                        start_s + patience_s);
}

// Faulty instances are poured again. Once all instances are calm, the funnel is removed. Instances
// that leaned on it wake up and settle again or fall out. Then contacts are forgotten, and the
// scene must come to rest again while it is kept awake, as in a world rebuilt from its poses. Each
// stage has its share of max_s.
void Pouring::Settle() {
  const int rounds = options_.arrangement == Arrangement::kPacked ? 0 : options_.pour_again_rounds;
  double start_s = world_.time_s();
  at_rest_ = StepUntilCalm(rounds > 0);
  for (int round = 1; round <= rounds && !world_.BlewUp(); ++round) {
    const std::vector<int> faulty = Faulty();
    if (faulty.empty()) break;
    PourAgain(faulty);
    start_s = world_.time_s();
    at_rest_ = StepUntilCalm(round < rounds);
  }
  if (world_.RemoveFunnel() > 0) {
    const double deadline_s = start_s + 0.75 * options_.max_s;
    at_rest_ = StepUntilStill(options_.calm_s, options_.calm_diameters, deadline_s, deadline_s);
  }
  if (options_.wake_s == 0) return;
  world_.ForgetContacts();
  world_.ForbidSleep();
  const double deadline_s = start_s + options_.max_s;
  at_rest_ = StepUntilStill(options_.wake_s, options_.wake_diameters, deadline_s, deadline_s);
}

// Steps until all instances sleep, or until none moves by more than `limit_diameters` for
// `window_s`. Returns whether this happened before the deadline. After `few_deadline_s`, it gives
// up as soon as at most one of ten instances moves by more.
bool Pouring::StepUntilStill(double window_s, double limit_diameters, double deadline_s,
                             double few_deadline_s) {
  constexpr size_t kPerMover = 10;
  still_X_WO_.clear();
  double since_s = 0;
  while (!world_.BlewUp()) {
    movement_ = LargestMovement();
    if (still_X_WO_.empty() || movement_.diameters > limit_diameters) {
      since_s = world_.time_s();
      movers_.clear();
      for (size_t i = 0; i < still_X_WO_.size(); ++i) {
        const int index = static_cast<int>(i);
        if (MovementOf(index).diameters > limit_diameters) movers_.push_back(index);
      }
      const bool is_late = since_s >= few_deadline_s;
      if (is_late && !movers_.empty() && kPerMover * movers_.size() <= Poured().size()) {
        return false;
      }
      still_X_WO_.clear();
      for (int i = 0; i < world_.instance_count(); ++i) still_X_WO_.push_back(world_.X_WO(i));
    }
    if (world_.AllAsleep() || world_.time_s() >= since_s + window_s) return true;
    if (world_.time_s() >= deadline_s) return false;
    StepFor(options_.check_interval_s);
  }
  return false;
}

Movement Pouring::MovementOf(int index) const {
  Movement movement;
  const ObjectId object = object_of_instance_[index];
  movement.Include(boxes_O_[object], objects_[object]->diameter_m, still_X_WO_[index],
                   world_.X_WO(index));
  return movement;
}

Movement Pouring::LargestMovement() const {
  Movement largest;
  for (size_t i = 0; i < still_X_WO_.size(); ++i) {
    const Movement movement = MovementOf(static_cast<int>(i));
    largest.m = std::max(largest.m, movement.m);
    largest.diameters = std::max(largest.diameters, movement.diameters);
  }
  return largest;
}

void Pouring::StepFor(double duration_s) {
  const double end_s = world_.time_s() + duration_s;
  if (options_.on_wait) options_.on_wait();
  while (world_.time_s() < end_s) world_.Step();
  for (const int i : Poured()) {
    const ObjectModel& model = *objects_[object_of_instance_[i]];
    if ((world_.X_WO(i) * model.mass.com_O).z() < -options_.fallen_m) world_.RemoveInstance(i);
  }
  energy_.push_back(Energy());
}

EnergySample Pouring::Energy() const {
  EnergySample sample{world_.time_s(), 0, 0};
  for (const int i : Poured()) {
    const MassProperties& mass = objects_[object_of_instance_[i]]->mass;
    const Pose X_WO = world_.X_WO(i);
    const Twist V_WO = world_.V_WO(i);
    const Vector3d spin_O = X_WO.linear().transpose() * V_WO.angular_W;
    sample.kinetic_j += 0.5 * mass.mass_kg * V_WO.linear_W.squaredNorm() +
                        0.5 * spin_O.dot(mass.inertia_com_O * spin_O);
    sample.potential_j -=
        mass.mass_kg * options_.physics.gravity_W.dot(Vector3d(X_WO * mass.com_O));
  }
  return sample;
}

double Pouring::Top_m() const {
  double top_m = 0;
  for (const int i : Poured()) {
    const Pose X_WO = world_.X_WO(i);
    const ObjectModel& model = *objects_[object_of_instance_[i]];
    top_m = std::max(top_m, X_WO.translation().z() + RotatedBox(model, X_WO.linear()).max().z());
  }
  return top_m;
}

bool Pouring::InBin(int index) const {
  const ObjectModel& model = *objects_[object_of_instance_[index]];
  return bin_.Holds(world_.X_WO(index) * model.mass.com_O);
}

std::vector<int> Pouring::Poured() const {
  std::vector<int> poured;
  for (int i = 0; i < world_.instance_count(); ++i) {
    if (!taken_out_[i]) poured.push_back(i);
  }
  return poured;
}

Scene Pouring::SceneOf(const std::vector<int>& indices) const {
  Scene scene;
  scene.bin = bin_;
  for (const int index : indices) {
    const InstanceId instance(scene.objects.size());
    scene.objects.push_back({instance, object_of_instance_[index], world_.X_WO(index)});
  }
  return scene;
}

DropResult Pouring::Result() const {
  DropResult result;
  SceneCertificate& certificate = result.certificate;
  certificate.at_rest = at_rest_;
  certificate.simulated_s = world_.time_s();
  certificate.blew_up = world_.BlewUp();
  certificate.wake_movement_m = movement_.m;
  certificate.wake_movement_diameters = movement_.diameters;
  certificate.energy = energy_;
  certificate.instances_outside = without_place_;
  std::vector<int> in_bin;
  for (const int i : Poured()) {
    if (!InBin(i)) {
      ++certificate.instances_outside;
      continue;
    }
    in_bin.push_back(i);
    const Twist V_WO = world_.V_WO(i);
    certificate.max_speed_mps = std::max(certificate.max_speed_mps, V_WO.linear_W.norm());
    certificate.max_spin_radps = std::max(certificate.max_spin_radps, V_WO.angular_W.norm());
  }
  result.scene = SceneOf(in_bin);
  certificate.deepest_penetration_m = DeepestPenetration(result.scene, objects_);
  return result;
}

}  // namespace

Arrangement ArrangementFromName(const std::string& name) {
  if (name == "pile") return Arrangement::kPile;
  if (name == "packed") return Arrangement::kPacked;
  if (name == "heap") return Arrangement::kHeap;
  throw InputError(UnknownNameMessage("arrangement", name, {"pile", "packed", "heap"}));
}

void DropOptions::Visit(SettingsVisitor& v) {
  const Range seconds{0, 1000}, length{0, 1000}, diameters{0, 10};
  v.Real("shaft_share", shaft_share, {0.01, 1},
         "width of the shaft that forms a heap, over the floor width");
  v.Integer("place_attempts", place_attempts, {1, 1000000},
            "maximum number of positions tried for an instance");
  v.Real("layer_interval_s", layer_interval_s, {0.001, 1000}, "time between two dropped layers, s");
  v.Real("max_s", max_s, seconds, "maximum simulated time after the last layer, s");
  v.Real("clearance_m", clearance_m, {0, 1}, "distance between instances of a layer, m");
  v.Real("funnel_m", funnel_m, length, "height of the walls while the bin is filled, m");
  v.Real("check_interval_s", check_interval_s, {0.001, 100}, "time between checks for rest, s");
  v.Real("fallen_m", fallen_m, length, "depth below the floor at which bodies are removed, m");
  v.Integer("turn_attempts", turn_attempts, {1, 1000000},
            "maximum number of orientations tried for an instance");
  v.Integer("pour_again_rounds", pour_again_rounds, {0, 1000},
            "maximum number of times that instances that overlap or keep moving are poured again");
  v.Real("calm_s", calm_s, seconds, "time without movement after which a scene is calm, s");
  v.Real("calm_diameters", calm_diameters, diameters, "maximum movement during calm_s, diameters");
  v.Real("wake_s", wake_s, seconds,
         "time awake without movement after which a scene is at rest, s; 0 = calm is sufficient");
  v.Real("wake_diameters", wake_diameters, diameters, "maximum movement during wake_s, diameters");
}

DropResult DropInstances(const Bin& bin, const ObjectSet& objects, const std::vector<int>& counts,
                         Rng& rng, const DropOptions& options) {
  CheckSettings("DropOptions", options);
  if (counts.size() != objects.size()) throw std::logic_error("one count for each object");
  for (size_t i = 0; i < objects.size(); ++i) {
    if (counts[i] == 0) continue;
    if (objects[i]->convex_pieces_O.empty()) {
      throw std::logic_error("object '" + objects[i]->name + "' has no convex pieces");
    }
    RequireFits(*objects[i], bin);
  }
  return Pouring(bin, objects, options, rng).Run(counts);
}

}  // namespace pickbed::sim
