#include "scenes/geometry/symmetry_finder.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>

#include "scenes/base/math.h"
#include "scenes/geometry/decompositions.h"
#include "scenes/geometry/mesh_query.h"

namespace pickbed::scenes {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using std::numbers::pi;

constexpr double kAlike = 0.15;  // moments may be equal if they differ by less than this share
constexpr double kLoose = 5;     // tolerance of the first check, as a multiple of the tolerance
constexpr int kFirstCheckStride = 25;              // over the samples, for the first check
constexpr int kRoughStride = 15, kFineStride = 3;  // over the samples, for the refinement
constexpr double kGridStep_rad = Radians(5);
constexpr double kSameAxis_rad = Radians(5);
constexpr double kSnap_rad = Radians(1);  // an axis is set to a coordinate axis within this angle
constexpr double kOutlierShare = 0.003;
// Tolerances as a multiple of the tolerance. The first is for products of checked rotations,
// because errors of the factors add up. The second is for the exact form of a group, because a
// rotation of a thread moves its flanks along the axis.
constexpr double kGroupTolerance = 2, kExactTolerance = 3;
// A turned part with dents: three quarters of the surface are within the tolerance after any
// rotation, all but a twentieth within the second distance and all within the third, as multiples
// of the tolerance.
constexpr double kSoundShare = 0.75, kDentShare = 0.05, kDeepShare = 0.01;
constexpr double kDentTolerance = 3, kDeepestDent = 8;
constexpr size_t kLargestGroup = 120;
constexpr std::array kPrimes{2, 3, 5, 7, 11, 13, 17, 19, 23, 29, 31, 37, 41, 43, 47, 53, 59};
// Test rotations in rad. No discrete symmetry of an order below 100 contains them.
constexpr std::array kQuarterRotations{0.37, 0.91, 1.43, 1.97, 2.39, 2.83};

struct Axis {
  Vector3d direction;
  Vector3d point;
  int order = 0;  // 0 = continuous
};

bool SameDirection(const Vector3d& a, const Vector3d& b) {
  return std::abs(a.dot(b)) > std::cos(kSameAxis_rad);
}

class Finder {
 public:
  Finder(const TriangleMesh& mesh, const SymmetryOptions& options);
  SymmetrySet Find();

 private:
  std::vector<Vector3d> CandidateDirections() const;
  bool Maps(const Pose& S, double tolerance_m, int stride) const;
  Pose FinallyRefined(Pose S, int stride) const;
  std::optional<Axis> Accept(const Vector3d& direction, double angle_rad) const;
  bool HasOrder(const Axis& axis, int order) const;
  bool TurnsFreely(const Axis& axis) const;
  std::optional<Axis> Continuous(const Vector3d& direction) const;
  bool MapsWithDents(const Pose& S) const;
  Axis LineOfNormals(const Vector3d& first_direction) const;
  std::optional<Axis> ContinuousWithDents(const Vector3d& direction) const;
  std::optional<Axis> Discrete(const Vector3d& direction, int highest_prime) const;
  std::vector<Pose> Group(const std::vector<Axis>& axes) const;
  Vector3d SnappedPoint(const Vector3d& point) const;
  std::vector<Pose> ExactGroup(const std::vector<Pose>& group) const;
  SymmetrySet OfRevolution(const Axis& axis) const;

  MeshQuery query_;
  std::vector<Vector3d> points_, normals_;  // samples of the surface
  Vector3d centroid_ = Vector3d::Zero();
  Vector3d moments_;  // in ascending order
  Matrix3d principal_;
  double tolerance_m_;
  int max_order_;
};

Finder::Finder(const TriangleMesh& mesh, const SymmetryOptions& options)
    : query_(mesh),
      tolerance_m_(options.tolerance_diameters * Diameter(mesh)),
      max_order_(options.max_order) {
  double area = 0;
  Matrix3d second = Matrix3d::Zero();
  for (const Eigen::Vector3i& t : mesh.triangles) {
    const Vector3d &a = mesh.vertices[t[0]], &b = mesh.vertices[t[1]], &c = mesh.vertices[t[2]];
    const double twice_area = (b - a).cross(c - a).norm();
    const Vector3d sum = a + b + c;
    area += twice_area;
    centroid_ += twice_area * sum / 3;
    second += twice_area / 12 *
              (a * a.transpose() + b * b.transpose() + c * c.transpose() + sum * sum.transpose());
  }
  centroid_ /= area;
  second = second / area - centroid_ * centroid_.transpose();
  const SymmetricEigen3 principal = EigenOfSymmetric3(second);
  moments_ = principal.values;
  principal_ = principal.vectors;
  Rng rng(0);
  SurfaceSamples samples = SampleSurface(mesh, options.samples, rng);
  points_ = std::move(samples.points);
  normals_ = std::move(samples.normals);
}

// Returns the principal axes. It adds the half circle between two axes with similar moments, or the
// hemisphere if all three moments are similar.
std::vector<Vector3d> Finder::CandidateDirections() const {
  std::vector<Vector3d> directions;
  for (int k = 2; k >= 0; --k) directions.push_back(principal_.col(k));
  const auto alike = [&](int i, int j) { return moments_[j] - moments_[i] < kAlike * moments_[2]; };
  const int steps = static_cast<int>(std::lround(pi / kGridStep_rad));
  if (alike(0, 2)) {
    for (int tilt = 0; tilt <= steps / 2; ++tilt) {
      const double polar = tilt * kGridStep_rad;
      const int around = std::max(1, static_cast<int>(2 * steps * std::sin(polar)));
      for (int i = 0; i < around; ++i) {
        const double angle = 2 * pi * i / around;
        directions.emplace_back(std::sin(polar) * std::cos(angle),
                                std::sin(polar) * std::sin(angle), std::cos(polar));
      }
    }
    return directions;
  }
  for (int i = 0; i < 2; ++i) {
    if (!alike(i, i + 1)) continue;
    for (int s = 1; s < steps; ++s) {
      const double angle = s * kGridStep_rad;
      directions.push_back(std::cos(angle) * principal_.col(i) +
                           std::sin(angle) * principal_.col(i + 1));
    }
  }
  return directions;
}

bool Finder::Maps(const Pose& S, double tolerance_m, int stride) const {
  const double count = std::ceil(static_cast<double>(points_.size()) / stride);
  double left = kOutlierShare * count;
  for (size_t i = 0; i < points_.size(); i += stride) {
    if (query_.ClosestPoint(S * points_[i]).distance > tolerance_m && --left < 0) return false;
  }
  return true;
}

// Point-to-plane ICP of the rotated surface onto the surface, started near the solution.
Pose Finder::FinallyRefined(Pose S, int stride) const {
  constexpr int kRounds = 5;
  for (int round = 0; round < kRounds; ++round) {
    Eigen::Matrix<double, 6, 6> A = 1e-9 * Eigen::Matrix<double, 6, 6>::Identity();
    Eigen::Matrix<double, 6, 1> b = Eigen::Matrix<double, 6, 1>::Zero();
    for (size_t i = 0; i < points_.size(); i += stride) {
      const Vector3d p = S * points_[i];
      const SurfaceHit hit = query_.ClosestPoint(p);
      if (hit.distance > 2 * kLoose * tolerance_m_) continue;
      Eigen::Matrix<double, 6, 1> row;
      row << (p - centroid_).cross(hit.normal), hit.normal;
      A += row * row.transpose();
      b += row * hit.normal.dot(hit.point - p);
    }
    const Eigen::Matrix<double, 6, 1> x = SolveSymmetric(A, b);
    const double angle = x.head<3>().norm();
    if (!x.allFinite() || angle > 0.2) return S;
    const Vector3d axis = angle > 1e-12 ? Vector3d(x.head<3>() / angle) : Vector3d::UnitX();
    const Pose turn = TurnAbout({axis, centroid_}, angle);
    S = Translation(x.tail<3>()) * turn * S;
  }
  return S;
}

// Returns the refined axis near `direction` about which the rotation is a symmetry. Its order is
// not set.
std::optional<Axis> Finder::Accept(const Vector3d& direction, double angle_rad) const {
  const Pose first = TurnAbout({direction, centroid_}, angle_rad);
  if (!Maps(first, kLoose * tolerance_m_, kFirstCheckStride)) return std::nullopt;
  // Most candidates that pass the first check fail after a cheap refinement.
  const Pose rough = FinallyRefined(first, kRoughStride);
  if (!Maps(rough, 2 * tolerance_m_, kRoughStride)) return std::nullopt;
  const Pose finally_refined = FinallyRefined(rough, kFineStride);
  const Eigen::AngleAxisd turn(finally_refined.linear());
  if (std::abs(turn.angle() - angle_rad) > 0.1) return std::nullopt;
  Vector3d axis = turn.axis();
  if (axis.dot(direction) < 0) axis = -axis;
  const Vector3d on_axis = PointOnAxis(finally_refined);
  const Axis found{axis, on_axis + axis * axis.dot(centroid_ - on_axis), 0};
  const Pose exact = TurnAbout({found.direction, found.point}, angle_rad);
  if (!Maps(exact, tolerance_m_, 1)) return std::nullopt;
  return found;
}

bool Finder::TurnsFreely(const Axis& axis) const {
  return std::all_of(kQuarterRotations.begin(), kQuarterRotations.end(), [&](double angle_rad) {
    return Maps(TurnAbout({axis.direction, axis.point}, angle_rad), tolerance_m_, 1);
  });
}

std::optional<Axis> Finder::Continuous(const Vector3d& direction) const {
  for (const double angle_rad : {kQuarterRotations[0], kQuarterRotations[3]}) {
    const Pose turn = TurnAbout({direction, centroid_}, angle_rad);
    if (!Maps(turn, kLoose * tolerance_m_, kFirstCheckStride)) return std::nullopt;
  }
  const std::optional<Axis> axis = Accept(direction, kQuarterRotations[3]);
  if (!axis || !TurnsFreely(*axis)) return std::nullopt;
  return axis;
}

bool Finder::MapsWithDents(const Pose& S) const {
  size_t sound = 0, dents = 0, deep = 0;
  for (const Vector3d& p : points_) {
    const double distance = query_.ClosestPoint(S * p).distance;
    sound += distance <= tolerance_m_;
    dents += distance > kDentTolerance * tolerance_m_;
    deep += distance > kDeepestDent * tolerance_m_;
  }
  const auto count = static_cast<double>(points_.size());
  return sound >= kSoundShare * count && dents <= kDentShare * count && deep <= kDeepShare * count;
}

// Returns the line near `first_direction` that the normals of the surface meet, as the normals of a
// body of revolution meet its axis (Pottmann and Randrup 1998). Dents have little weight.
Axis Finder::LineOfNormals(const Vector3d& first_direction) const {
  constexpr int kRounds = 12;
  constexpr double kUsualSine = 0.05;  // larger deviations of a normal count less
  Axis line{first_direction, centroid_, 0};
  for (int round = 0; round < kRounds; ++round) {
    const Vector3d u = line.direction.unitOrthogonal(), v = line.direction.cross(u);
    Eigen::Matrix4d A = 1e-12 * Eigen::Matrix4d::Identity();
    Eigen::Vector4d b = Eigen::Vector4d::Zero();
    for (size_t i = 0; i < points_.size(); ++i) {
      const Vector3d arm = points_[i] - line.point;
      const double radius_m = line.direction.cross(arm).norm();
      if (radius_m < tolerance_m_) continue;
      const auto moment = [&](const Vector3d& axis) {
        return normals_[i].dot(axis.cross(arm)) / radius_m;
      };
      const double sine = moment(line.direction);
      const double weight = 1 / (1 + sine * sine / (kUsualSine * kUsualSine));
      const double shift_u = -normals_[i].dot(line.direction.cross(u)) / radius_m;
      const double shift_v = -normals_[i].dot(line.direction.cross(v)) / radius_m;
      // Shifts are in units of the tolerance, so that all unknowns have the same scale.
      const Eigen::Vector4d row(moment(u), moment(v), shift_u * tolerance_m_,
                                shift_v * tolerance_m_);
      A += weight * row * row.transpose();
      b -= weight * sine * row;
    }
    const Eigen::Vector4d x = SolveSymmetric(A, b);
    if (!x.allFinite()) break;
    line.direction = (line.direction + x[0] * u + x[1] * v).normalized();
    line.point += tolerance_m_ * (x[2] * u + x[3] * v);
  }
  line.point += line.direction * line.direction.dot(centroid_ - line.point);
  return line;
}

// Returns the axis of a body of revolution with dents, or with small features that break the
// symmetry.
std::optional<Axis> Finder::ContinuousWithDents(const Vector3d& first_direction) const {
  Axis axis = LineOfNormals(first_direction);
  if (!SameDirection(axis.direction, first_direction)) return std::nullopt;
  const bool turns_freely =
      std::all_of(kQuarterRotations.begin(), kQuarterRotations.end(), [&](double angle_rad) {
        return MapsWithDents(TurnAbout({axis.direction, axis.point}, angle_rad));
      });
  return turns_freely ? std::optional(axis) : std::nullopt;
}

// Checks all rotations of the order, because a small one may pass only because it is small.
bool Finder::HasOrder(const Axis& axis, int order) const {
  for (int i = 1; i <= order / 2; ++i) {
    if (!Maps(TurnAbout({axis.direction, axis.point}, 2 * pi * i / order), tolerance_m_, 1)) {
      return false;
    }
  }
  return true;
}

// Returns the axis with the highest order that holds. An axis of any order also has a prime order.
// Once the axis is refined for the prime order, its multiples need no further search.
std::optional<Axis> Finder::Discrete(const Vector3d& direction, int highest_prime) const {
  for (const int prime : kPrimes) {
    if (prime > std::min(highest_prime, max_order_)) break;
    std::optional<Axis> axis = Accept(direction, 2 * pi / prime);
    if (!axis || !HasOrder(*axis, prime)) continue;
    axis->order = prime;
    for (int order = 2 * prime; order <= max_order_; order += prime) {
      if (HasOrder(*axis, order)) axis->order = order;
    }
    return axis;
  }
  return std::nullopt;
}

// Returns all products of the axes' rotations that pass the check, without the identity.
std::vector<Pose> Finder::Group(const std::vector<Axis>& axes) const {
  std::vector<Pose> generators;
  for (const Axis& axis : axes) {
    for (int i = 1; i < axis.order; ++i) {
      generators.push_back(TurnAbout({axis.direction, axis.point}, 2 * pi * i / axis.order));
    }
  }
  const auto same = [](const Pose& a, const Pose& b) {
    return RotationAngleRad(a.linear(), b.linear()) < kSameAxis_rad;
  };
  std::vector<Pose> group{Pose::Identity()};
  for (size_t i = 0; i < group.size() && group.size() < kLargestGroup; ++i) {
    for (const Pose& generator : generators) {
      const Pose product = generator * group[i];
      const bool known = std::any_of(group.begin(), group.end(),
                                     [&](const Pose& other) { return same(product, other); });
      if (!known && Maps(product, kGroupTolerance * tolerance_m_, 1)) group.push_back(product);
    }
  }
  group.erase(group.begin());
  return group;
}

// Returns the direction of a coordinate axis if `direction` is near one.
Vector3d SnappedDirection(const Vector3d& direction) {
  for (int k = 0; k < 3; ++k) {
    if (std::abs(direction[k]) > std::cos(kSnap_rad)) {
      return Vector3d::Unit(k) * (direction[k] < 0 ? -1 : 1);
    }
  }
  return direction;
}

// Sets coordinates to 0 that are 0 within the tolerance.
Vector3d Finder::SnappedPoint(const Vector3d& point) const {
  return point.unaryExpr([&](double x) { return std::abs(x) < tolerance_m_ ? 0.0 : x; });
}

// Returns the group with exact fractions of a turn about one axis and exact half turns across it,
// all about one center, that is nearest to `group`. Meshes with a thread or with rounded
// coordinates have such a group only within the tolerance. Empty if the group is another one, or if
// the mesh does not allow the exact rotations.
std::vector<Pose> Finder::ExactGroup(const std::vector<Pose>& group) const {
  std::vector<Vector3d> axes;
  for (const Pose& X_OO : group) axes.push_back(Eigen::AngleAxisd(X_OO.linear()).axis());
  const auto shared = [&](const Vector3d& axis) {
    return std::count_if(axes.begin(), axes.end(),
                         [&](const Vector3d& other) { return SameDirection(axis, other); });
  };
  const auto main =
      std::max_element(axes.begin(), axes.end(),
                       [&](const Vector3d& a, const Vector3d& b) { return shared(a) < shared(b); });
  if (main == axes.end()) return {};
  const int order = static_cast<int>(shared(*main)) + 1;
  Vector3d direction = Vector3d::Zero(), across = Vector3d::Zero();
  // Least squares: the point nearest to all axes, and near the centroid along a single axis.
  constexpr double kPull = 1e-6;
  Matrix3d A = kPull * Matrix3d::Identity();
  Vector3d b = kPull * centroid_;
  for (size_t i = 0; i < group.size(); ++i) {
    const Matrix3d off_axis = Matrix3d::Identity() - axes[i] * axes[i].transpose();
    A += off_axis;
    b += off_axis * PointOnAxis(group[i]);
    if (SameDirection(*main, axes[i])) {
      direction += axes[i].dot(*main) < 0 ? -axes[i] : axes[i];
    } else if (across.isZero()) {
      across = axes[i];
    }
  }
  direction = SnappedDirection(direction.normalized());
  const Vector3d center = SnappedPoint(SolveSymmetric(A, b));
  std::vector<Pose> exact;
  for (int i = 1; i < order; ++i)
    exact.push_back(TurnAbout({direction, center}, 2 * pi * i / order));
  if (!across.isZero()) {
    across = SnappedDirection((across - direction * direction.dot(across)).normalized());
    for (int i = 0; i < order; ++i) {
      const Vector3d flip = TurnAbout({direction, Vector3d::Zero()}, pi * i / order) * across;
      exact.push_back(TurnAbout({flip, center}, pi));
    }
  }
  const bool holds = exact.size() == group.size() &&
                     std::all_of(exact.begin(), exact.end(), [&](const Pose& X_OO) {
                       return Maps(X_OO, kExactTolerance * tolerance_m_, 1);
                     });
  return holds ? exact : std::vector<Pose>();
}

// Returns the symmetries of a body of revolution, which may also be symmetric under a half turn
// across the axis.
SymmetrySet Finder::OfRevolution(const Axis& axis) const {
  SymmetrySet found;
  found.continuous_O.push_back({axis.direction, axis.point});
  const Pose flip = TurnAbout({axis.direction.unitOrthogonal(), axis.point}, pi);
  if (Maps(flip, tolerance_m_, 1)) found.discrete_O.push_back(flip);
  return found;
}

SymmetrySet Finder::Find() {
  const std::vector<Vector3d> directions = CandidateDirections();
  std::optional<Axis> revolution;
  for (const Vector3d& direction : directions) {
    if (revolution && SameDirection(revolution->direction, direction)) continue;
    const std::optional<Axis> axis = Continuous(direction);
    if (!axis) {
      if (revolution) break;  // another direction is not continuous, so there is only one axis
      continue;
    }
    if (revolution) {  // two axes: a ball
      return {{}, {{revolution->direction, centroid_}, {axis->direction, centroid_}}};
    }
    revolution = axis;
  }
  if (revolution) return OfRevolution(*revolution);
  std::vector<Axis> axes;
  for (const Vector3d& direction : directions) {
    const bool known = std::any_of(axes.begin(), axes.end(), [&](const Axis& axis) {
      return SameDirection(axis.direction, direction);
    });
    if (known) continue;
    // Other axes than the principal ones are two-fold axes across an axis of a higher order. If all
    // moments are similar, they are axes of the cube and the icosahedron, up to five-fold.
    const bool is_principal = &direction - directions.data() < 3;
    const bool all_alike = moments_[2] - moments_[0] < kAlike * moments_[2];
    const std::optional<Axis> axis = Discrete(direction, is_principal ? kPrimes.back()
                                                         : all_alike  ? 5
                                                                      : 2);
    if (axis && std::none_of(axes.begin(), axes.end(), [&](const Axis& other) {
          return SameDirection(other.direction, axis->direction);
        })) {
      axes.push_back(*axis);
    }
  }
  // A discrete axis means regular features, such as teeth or a hexagon, and not dents.
  for (int k = 0; k < 3; ++k) {
    const std::optional<Axis> axis = ContinuousWithDents(principal_.col(k));
    if (!axis) continue;
    const bool is_regular = std::any_of(axes.begin(), axes.end(), [&](const Axis& other) {
      return SameDirection(other.direction, axis->direction);
    });
    if (!is_regular) return OfRevolution(*axis);
  }
  const std::vector<Pose> group = Group(axes);
  const std::vector<Pose> exact = ExactGroup(group);
  return {exact.empty() ? group : exact, {}};
}

}  // namespace

SymmetrySet FindSymmetries(const TriangleMesh& mesh, const SymmetryOptions& options) {
  return Finder(mesh, options).Find();
}

}  // namespace pickbed::scenes
