#include "sim/drop.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <stdexcept>

#include "scenes/check.h"
#include "sim/penetration.h"

namespace pickbed {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

// Of a part about its origin in some orientation.
Eigen::AlignedBox3d TurnedBox(const ObjectModel& model, const Eigen::Matrix3d& R_WO) {
  Eigen::AlignedBox3d box;
  for (const ConvexPiece& piece : model.convex_parts_O) {
    for (const Vector3d& p_O : piece.vertices_O) box.extend(Vector3d(R_WO * p_O));
  }
  return box;
}

// Axes of O ordered by the part's extent along them: 0 is the longest.
std::array<int, 3> AxesByExtent(const Vector3d& size) {
  std::array<int, 3> axes{0, 1, 2};
  std::stable_sort(axes.begin(), axes.end(), [&](int a, int b) { return size[a] > size[b]; });
  return axes;
}

void RequireFits(const ObjectModel& model, const Bin& bin) {
  const Vector3d size = TurnedBox(model, Eigen::Matrix3d::Identity()).sizes();
  const auto [longest, middle, shortest] = AxesByExtent(size);
  const Vector2d inner = bin.inner_size_m.head<2>();
  if (size[longest] <= inner.maxCoeff() && size[middle] <= inner.minCoeff()) return;
  throw InputError(fmt::format(
      "part '{}' is {:.3f} x {:.3f} x {:.3f} m and does not fit into the bin's {:.3f} x {:.3f} m "
      "floor: take a larger bin or check the mesh's unit",
      model.name, size[longest], size[middle], size[shortest], inner.x(), inner.y()));
}

// Longest axis of the part along the bin's longer side, middle one along its shorter side.
Eigen::Matrix3d LyingFlat(const ObjectModel& model, const Bin& bin) {
  const Vector3d size = TurnedBox(model, Eigen::Matrix3d::Identity()).sizes();
  const auto [longest, middle, shortest] = AxesByExtent(size);
  const bool x_is_longer = bin.inner_size_m.x() >= bin.inner_size_m.y();
  const Vector3d along = x_is_longer ? Vector3d::UnitX() : Vector3d::UnitY();
  const Vector3d across = x_is_longer ? Vector3d::UnitY() : Vector3d::UnitX();
  Eigen::Matrix3d R_WO;
  R_WO.col(longest) = along;
  R_WO.col(middle) = across;
  R_WO.col(shortest) = Vector3d::Zero();
  R_WO.col(shortest) = R_WO.col((shortest + 1) % 3).cross(R_WO.col((shortest + 2) % 3));
  return R_WO;
}

struct TurnedPart {
  int object = 0;
  Eigen::Matrix3d R_WO;
  Eigen::AlignedBox3d box;  // about the origin of O
};

// A random orientation in which the part fits between the walls.
TurnedPart TurnAtRandom(const ObjectSet& objects, int object, const Bin& bin,
                        const DropOptions& options, Rng& rng) {
  const ObjectModel& model = *objects[object];
  const Vector2d room = bin.inner_size_m.head<2>() - Vector2d::Constant(2 * options.clearance_m);
  for (int attempt = 0; attempt < options.turn_attempts; ++attempt) {
    const Eigen::Matrix3d R_WO = rng.Rotation().toRotationMatrix();
    const Eigen::AlignedBox3d box = TurnedBox(model, R_WO);
    if ((box.sizes().head<2>().array() <= room.array()).all()) return {object, R_WO, box};
  }
  const Eigen::Matrix3d R_WO = LyingFlat(model, bin);
  return {object, R_WO, TurnedBox(model, R_WO)};
}

struct Cell {
  const TurnedPart* part;
  Vector2d low;  // corner with smallest x and y
};

// Fills one layer with the parts from `first` on, row by row. Returns the cells; the first part
// always gets one, so that pouring comes to an end.
std::vector<Cell> PackLayer(const std::vector<TurnedPart>& parts, size_t first, const Bin& bin,
                            double clearance_m) {
  const Vector2d inner = bin.inner_size_m.head<2>();
  std::vector<Cell> cells;
  double x = clearance_m, y = clearance_m, row_depth = 0;
  for (size_t i = first; i < parts.size(); ++i) {
    const Vector2d size = parts[i].box.sizes().head<2>() + Vector2d::Constant(clearance_m);
    if (x + size.x() > inner.x()) {
      x = clearance_m;
      y += row_depth;
      row_depth = 0;
    }
    if (!cells.empty() && y + size.y() > inner.y()) break;
    cells.push_back({&parts[i], {x, y}});
    x += size.x();
    row_depth = std::max(row_depth, size.y());
  }
  return cells;
}

class Pouring {
 public:
  Pouring(const Bin& bin, const ObjectSet& objects, const DropOptions& options, Rng& rng)
      : bin_(bin), objects_(objects), options_(options), rng_(rng), world_(options.physics) {
    world_.AddBin(bin);
    world_.AddFunnel(bin, options.funnel_m);
  }
  DropResult Run(const std::vector<int>& counts);

 private:
  void PourLayers(const std::vector<TurnedPart>& parts);
  void AddLayer(const std::vector<Cell>& cells);
  void Settle();
  void StepFor(double duration_s);  // and takes out what fell beside the bin
  double Top_m() const;             // of the highest part
  bool InBin(int part) const;
  bool StepUntilStill(double window_s, double limit_diameters, double deadline_s);
  struct Movement {
    double m = 0, diameters = 0;
  };
  Movement LargestMovement(const std::vector<Pose>& since_X_WO) const;
  EnergySample Energy() const;
  DropResult Result() const;

  const Bin& bin_;
  const ObjectSet& objects_;
  const DropOptions& options_;
  Rng& rng_;
  PhysicsWorld world_;
  std::vector<int> object_of_part_;
  std::vector<EnergySample> energy_;
  Movement movement_;  // since the last restlessness
  bool at_rest_ = false;
};

DropResult Pouring::Run(const std::vector<int>& counts) {
  std::vector<int> kinds;
  for (size_t i = 0; i < counts.size(); ++i) {
    kinds.insert(kinds.end(), counts[i], static_cast<int>(i));
  }
  for (size_t i = kinds.size(); i > 1; --i) {  // Fisher and Yates
    std::swap(kinds[i - 1], kinds[rng_.Index(static_cast<int>(i))]);
  }
  std::vector<TurnedPart> parts;
  for (const int kind : kinds) {
    parts.push_back(TurnAtRandom(objects_, kind, bin_, options_, rng_));
  }
  PourLayers(parts);
  Settle();
  return Result();
}

void Pouring::PourLayers(const std::vector<TurnedPart>& parts) {
  for (size_t poured = 0; poured < parts.size();) {
    const std::vector<Cell> cells = PackLayer(parts, poured, bin_, options_.clearance_m);
    AddLayer(cells);
    poured += cells.size();
    StepFor(options_.layer_interval_s);
  }
}

// The layer as a whole is mirrored and shifted at random, so that no corner is favoured.
void Pouring::AddLayer(const std::vector<Cell>& cells) {
  const Vector2d inner = bin_.inner_size_m.head<2>();
  Vector2d used = Vector2d::Zero();
  for (const Cell& cell : cells) {
    used = used.cwiseMax(cell.low + cell.part->box.sizes().head<2>());
  }
  const Vector2d slack = (inner - used).cwiseMax(0) - Vector2d::Constant(options_.clearance_m);
  const Vector2d shift(rng_.Uniform() * std::max(0.0, slack.x()),
                       rng_.Uniform() * std::max(0.0, slack.y()));
  const bool mirror_x = rng_.Index(2) == 1, mirror_y = rng_.Index(2) == 1;
  const double bottom_m = Top_m() + options_.clearance_m;
  for (const Cell& cell : cells) {
    const Eigen::AlignedBox3d& box = cell.part->box;
    Vector2d low = cell.low + shift;
    if (mirror_x) low.x() = inner.x() - low.x() - box.sizes().x();
    if (mirror_y) low.y() = inner.y() - low.y() - box.sizes().y();
    low -= 0.5 * inner;
    const Vector3d p_WO = Vector3d(low.x(), low.y(), bottom_m) - box.min();
    world_.AddPart(*objects_[cell.part->object], MakePose(cell.part->R_WO, p_WO));
    object_of_part_.push_back(cell.part->object);
  }
}

// The funnel goes when all are calm for the first time; parts that leaned on it wake and settle
// again or fall out. Then contacts are forgotten and the pile, kept awake, has to come to rest
// anew, as it would in a world rebuilt from its poses. Each stage has its share of the time.
void Pouring::Settle() {
  const double start_s = world_.time_s();
  const auto deadline_s = [&](double share) { return start_s + share * options_.max_s; };
  at_rest_ = StepUntilStill(options_.calm_s, options_.calm_diameters, deadline_s(0.5));
  if (world_.RemoveFunnel() > 0) {
    at_rest_ = StepUntilStill(options_.calm_s, options_.calm_diameters, deadline_s(0.75));
  }
  if (options_.wake_s == 0) return;
  world_.ForgetContacts();
  world_.ForbidSleep();
  at_rest_ = StepUntilStill(options_.wake_s, options_.wake_diameters, deadline_s(1));
}

// Until all sleep, or until for `window_s` no part has moved by more than `limit_diameters`.
// Returns whether that came before the deadline.
bool Pouring::StepUntilStill(double window_s, double limit_diameters, double deadline_s) {
  std::vector<Pose> since_X_WO;
  double since_s = 0;
  while (!world_.BlewUp()) {
    movement_ = LargestMovement(since_X_WO);
    if (since_X_WO.empty() || movement_.diameters > limit_diameters) {
      since_s = world_.time_s();
      since_X_WO.clear();
      for (int i = 0; i < world_.part_count(); ++i) since_X_WO.push_back(world_.X_WO(i));
    }
    if (world_.AllAsleep() || world_.time_s() >= since_s + window_s) return true;
    if (world_.time_s() >= deadline_s) return false;
    StepFor(options_.check_interval_s);
  }
  return false;
}

// By a bound for any point of a part, its diameter around its origin.
Pouring::Movement Pouring::LargestMovement(const std::vector<Pose>& since_X_WO) const {
  Movement largest;
  for (size_t i = 0; i < since_X_WO.size(); ++i) {
    const Pose X_WO = world_.X_WO(static_cast<int>(i));
    const double diameter_m = objects_[object_of_part_[i]]->diameter_m;
    const double moved_m =
        (X_WO.translation() - since_X_WO[i].translation()).norm() +
        0.5 * diameter_m * RotationAngleRad(X_WO.linear(), since_X_WO[i].linear());
    largest.m = std::max(largest.m, moved_m);
    largest.diameters = std::max(largest.diameters, moved_m / diameter_m);
  }
  return largest;
}

void Pouring::StepFor(double duration_s) {
  const double end_s = world_.time_s() + duration_s;
  while (world_.time_s() < end_s) world_.Step();
  for (int i = 0; i < world_.part_count(); ++i) {
    if (world_.X_WO(i).translation().z() < -options_.fallen_m) world_.RemovePart(i);
  }
  energy_.push_back(Energy());
}

EnergySample Pouring::Energy() const {
  EnergySample sample{world_.time_s(), 0, 0};
  for (int i = 0; i < world_.part_count(); ++i) {
    const MassProperties& mass = objects_[object_of_part_[i]]->mass;
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
  for (int i = 0; i < world_.part_count(); ++i) {
    const Pose X_WO = world_.X_WO(i);
    const ObjectModel& model = *objects_[object_of_part_[i]];
    top_m = std::max(top_m, X_WO.translation().z() + TurnedBox(model, X_WO.linear()).max().z());
  }
  return top_m;
}

bool Pouring::InBin(int part) const {
  const ObjectModel& model = *objects_[object_of_part_[part]];
  const Vector3d p_W = world_.X_WO(part) * model.mass.com_O;
  const Vector2d half = 0.5 * bin_.inner_size_m.head<2>();
  return (p_W.head<2>().cwiseAbs().array() <= half.array()).all() && p_W.z() > 0;
}

DropResult Pouring::Result() const {
  DropResult result;
  result.scene.bin = bin_;
  SceneCertificate& certificate = result.certificate;
  certificate.at_rest = at_rest_;
  certificate.simulated_s = world_.time_s();
  certificate.blew_up = world_.BlewUp();
  certificate.wake_movement_m = movement_.m;
  certificate.wake_movement_diameters = movement_.diameters;
  certificate.energy = energy_;
  for (int i = 0; i < world_.part_count(); ++i) {
    if (!InBin(i)) {
      ++certificate.parts_outside;
      continue;
    }
    const Twist V_WO = world_.V_WO(i);
    certificate.max_speed_mps = std::max(certificate.max_speed_mps, V_WO.linear_W.norm());
    certificate.max_spin_radps = std::max(certificate.max_spin_radps, V_WO.angular_W.norm());
    const int instance = static_cast<int>(result.scene.objects.size());
    result.scene.objects.push_back({instance, object_of_part_[i], world_.X_WO(i)});
  }
  certificate.deepest_penetration_m = DeepestPenetration(result.scene, objects_);
  return result;
}

}  // namespace

DropResult DropParts(const Bin& bin, const ObjectSet& objects, const std::vector<int>& counts,
                     Rng& rng, const DropOptions& options) {
  if (counts.size() != objects.size()) throw std::logic_error("one count for each object");
  for (size_t i = 0; i < objects.size(); ++i) {
    if (counts[i] == 0) continue;
    if (objects[i]->convex_parts_O.empty()) {
      throw std::logic_error("part '" + objects[i]->name + "' has no convex pieces");
    }
    RequireFits(*objects[i], bin);
  }
  return Pouring(bin, objects, options, rng).Run(counts);
}

}  // namespace pickbed
