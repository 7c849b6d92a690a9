#include "grasp/tolerance/tolerance_model.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "scenes/base/error.h"
#include "scenes/base/files.h"
#include "scenes/base/math.h"
#include "scenes/base/settings_tree.h"
#include "scenes/geometry/decompositions.h"

namespace pickbed::grasp {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr const char* kKind = "pickbed tolerance model 1";
constexpr int kTerms = 1 + 2 * 6 + 2 + 15;
using Terms = Eigen::Matrix<double, kTerms, 1>;
constexpr double kConstantRidge = 1e-6;  // keeps the constant finite if all samples succeed

PoseOffset Scaled(const PoseOffset& error_G, const ToleranceModel& model) {
  PoseOffset u;
  u << error_G.head<3>() / model.length_scale_m, error_G.tail<3>() / model.angle_scale_rad;
  return u;
}

// Terms: 1; |u| and u^2 of each coordinate; u and u|u| of the approach z; |u_i u_j| of each pair.
Terms TermsOf(const PoseOffset& u) {
  Terms terms;
  int k = 0;
  terms[k++] = 1;
  for (int i = 0; i < 6; ++i) {
    terms[k++] = std::abs(u[i]);
    terms[k++] = u[i] * u[i];
  }
  terms[k++] = u[2];
  terms[k++] = u[2] * std::abs(u[2]);
  for (int i = 0; i < 6; ++i) {
    for (int j = i + 1; j < 6; ++j) terms[k++] = std::abs(u[i] * u[j]);
  }
  return terms;
}

double Probability(const ToleranceModel& model, const PoseOffset& error_G) {
  const Eigen::Map<const Terms> weights(model.weights.data());
  return Logistic(weights.dot(TermsOf(Scaled(error_G, model))));
}

// Terms and outcomes (1 or 0) of the samples, one row per sample.
struct DesignRows {
  Eigen::MatrixXd terms;
  Eigen::VectorXd outcomes;
};

DesignRows RowsOf(const std::vector<ToleranceSample>& samples, const ToleranceModel& model) {
  DesignRows rows{Eigen::MatrixXd(samples.size(), kTerms), Eigen::VectorXd(samples.size())};
  for (size_t i = 0; i < samples.size(); ++i) {
    rows.terms.row(i) = TermsOf(Scaled(samples[i].error_G, model)).transpose();
    rows.outcomes[i] = samples[i].success ? 1 : 0;
  }
  return rows;
}

// log sigmoid(x) = -log(1 + exp(-x)), without overflow.
double LogLikelihood(const DesignRows& rows, const Terms& w) {
  const Eigen::ArrayXd margin = (rows.terms * w).array() * (2 * rows.outcomes.array() - 1);
  return (margin.min(0.0) - (-margin.abs()).exp().log1p()).sum();
}

// Newton's method on the log likelihood minus `ridge` times half the squared coefficients (without
// the constant). The objective is concave, so halving a step until the value grows is safe.
Terms Fit(const DesignRows& rows, double ridge, const ToleranceFitOptions& options) {
  Terms penalty = Terms::Constant(ridge);
  penalty[0] = kConstantRidge;
  const auto value = [&](const Terms& w) {
    return LogLikelihood(rows, w) - 0.5 * w.dot(penalty.cwiseProduct(w));
  };
  Terms w = Terms::Zero();
  for (int step = 0; step < options.max_steps; ++step) {
    const Eigen::VectorXd p = (rows.terms * w).unaryExpr(&Logistic);
    const Eigen::VectorXd gradient =
        rows.terms.transpose() * (rows.outcomes - p) - penalty.cwiseProduct(w);
    const Eigen::VectorXd variance = p.array() * (1 - p.array());
    Eigen::MatrixXd hessian = rows.terms.transpose() * variance.asDiagonal() * rows.terms;
    hessian.diagonal() += penalty;
    Terms change = SolveSymmetric(hessian, gradient);
    const double before = value(w);
    while (value(w + change) < before && change.cwiseAbs().maxCoeff() > options.converged) {
      change *= 0.5;
    }
    w += change;
    if (change.cwiseAbs().maxCoeff() < options.converged) break;
  }
  return w;
}

// First and second moments of the surface by area. A triangle (a, b, c) with center m has the
// second moment (a a' + b b' + c c' + 9 m m') / 12.
void SurfaceMoments(const TriangleMesh& mesh, Vector3d& mean, Matrix3d& covariance) {
  double area = 0;
  Vector3d first = Vector3d::Zero();
  Matrix3d second = Matrix3d::Zero();
  for (const auto& triangle : mesh.triangles) {
    const Vector3d a = mesh.vertices[triangle[0]];
    const Vector3d b = mesh.vertices[triangle[1]], c = mesh.vertices[triangle[2]];
    const double weight = 0.5 * (b - a).cross(c - a).norm();
    const Vector3d center = (a + b + c) / 3;
    area += weight;
    first += weight * center;
    second += weight / 12 *
              (a * a.transpose() + b * b.transpose() + c * c.transpose() +
               9 * center * center.transpose());
  }
  CheckInput(area > 0, "a mesh without area has no surface that a pose error moves");
  mean = first / area;
  covariance = second / area - mean * mean.transpose();
}

// Mean squared displacement of the surface.
double SquaredMotion(const ToleranceModel& model, const Pose& X) {
  const Matrix3d D = X.linear() - Matrix3d::Identity();
  // The first term is the trace of D * covariance * D^T.
  return (D * model.surface_covariance_O).cwiseProduct(D).sum() +
         (D * model.surface_mean_O + X.translation()).squaredNorm();
}

// Largest error of the entries of a stored rotation, which are written with all digits.
constexpr double kMaxRotationError = 1e-6;

void VisitPose(SettingsVisitor& v, Pose& X) {
  const Range any{-1e6, 1e6};
  Vector3d x = X.linear().col(0), z = X.linear().col(2), p = X.translation();
  v.Vector3("x", x, any, "x axis of G in O");
  v.Vector3("z", z, any, "z axis of G in O");
  v.Vector3("p_m", p, any, "origin of G in O, m");
  Matrix3d R;
  R << x, z.cross(x), z;
  X = MakePose(R, p);
}

}  // namespace

Pose ToPose(const PoseOffset& error) {
  const double angle = error.tail<3>().norm();
  Matrix3d R = Matrix3d::Identity();
  if (angle > 0) R = Eigen::AngleAxisd(angle, error.tail<3>() / angle).toRotationMatrix();
  return MakePose(R, error.head<3>());
}

PoseOffset ToPoseOffset(const Pose& X) {
  const Eigen::AngleAxisd turn(X.linear());
  PoseOffset error;
  error << X.translation(), turn.angle() * turn.axis();
  return error;
}

std::vector<Pose> InverseSymmetries(const SymmetrySet& symmetries) {
  std::vector<Pose> inverses;
  for (const Pose& S : SymmetryTransforms(symmetries)) inverses.push_back(S.inverse());
  return inverses;
}

void ToleranceFitOptions::Visit(SettingsVisitor& v) {
  v.Real("length_scale_m", length_scale_m, {1e-4, 1},
         "position error with a scaled coordinate of 1, m");
  v.Real("angle_scale_rad", angle_scale_rad, {1e-3, 3},
         "rotation error with a scaled coordinate of 1, rad");
  v.RenamedKey("least_ridge", "min_ridge");
  v.Real("min_ridge", min_ridge, {1e-6, 1e6}, "smallest weight of the squared coefficients");
  v.Real("ridge_factor", ridge_factor, {1, 1000}, "factor between two tried weights");
  v.Integer("ridges", ridges, {1, 100}, "number of tried weights");
  v.Integer("folds", folds, {2, 1000}, "number of cross-validation folds of the grasps");
  v.Integer("max_steps", max_steps, {1, 10000}, "maximum number of steps of Newton's method");
  v.Real("converged", converged, {1e-15, 1}, "largest change of a coefficient at convergence");
}

ToleranceModel EmptyToleranceModel(const ObjectModel& model, const std::string& gripper,
                                   std::vector<Pose> X_OG, const ToleranceFitOptions& options) {
  CheckSettings("ToleranceFitOptions", options);
  ToleranceModel tolerance;
  tolerance.object = model.name;
  tolerance.gripper = gripper;
  tolerance.length_scale_m = options.length_scale_m;
  tolerance.angle_scale_rad = options.angle_scale_rad;
  tolerance.X_OG = std::move(X_OG);
  tolerance.symmetries_O = model.symmetries_O;
  tolerance.symmetry_inverses_O = InverseSymmetries(model.symmetries_O);
  SurfaceMoments(model.mesh_O, tolerance.surface_mean_O, tolerance.surface_covariance_O);
  tolerance.weights.assign(kTerms, 0);
  return tolerance;
}

// Selects the ridge with the best prediction of left-out grasps (Hastie et al. 2009, sec. 7.10).
void FitTolerance(const std::vector<ToleranceSample>& samples, const ToleranceFitOptions& options,
                  ToleranceModel& model) {
  CheckSettings("ToleranceFitOptions", options);
  CheckInput(!samples.empty(), "no executed grasps to fit a tolerance model to");
  double best_ridge = options.min_ridge;
  double best_value = -std::numeric_limits<double>::infinity();
  double ridge = options.min_ridge;
  for (int i = 0; i < options.ridges; ++i, ridge *= options.ridge_factor) {
    double value = 0;
    for (int fold = 0; fold < options.folds; ++fold) {
      std::vector<ToleranceSample> seen, left_out;
      for (const ToleranceSample& sample : samples) {
        (sample.grasp % options.folds == fold ? left_out : seen).push_back(sample);
      }
      const DesignRows rows = RowsOf(left_out, model);
      value += LogLikelihood(rows, Fit(RowsOf(seen, model), ridge, options));
    }
    if (value > best_value) {
      best_value = value;
      best_ridge = ridge;
    }
  }
  const Terms w = Fit(RowsOf(samples, model), best_ridge, options);
  model.weights.assign(w.data(), w.data() + kTerms);
}

Pose NearestError(const ToleranceModel& model, const Pose& X_OE) {
  Pose nearest = X_OE;
  double minimum = std::numeric_limits<double>::infinity();
  for (const Pose& inverse : model.symmetry_inverses_O) {
    const Pose X = inverse * X_OE;
    const double motion = SquaredMotion(model, X);
    if (motion >= minimum) continue;
    minimum = motion;
    nearest = X;
  }
  return nearest;
}

double SuccessProbability(const ToleranceModel& model, const Pose& X_OE, const Pose& X_OG) {
  const Pose X = NearestError(model, X_OE);
  return Probability(model, ToPoseOffset(X_OG.inverse() * X * X_OG));
}

double SuccessProbability(const ToleranceModel& model, const Pose& X_OE) {
  const Pose X = NearestError(model, X_OE);
  double sum = 0;
  for (const Pose& X_OG : model.X_OG) {
    sum += Probability(model, ToPoseOffset(X_OG.inverse() * X * X_OG));
  }
  return sum / static_cast<double>(model.X_OG.size());
}

const std::vector<std::string>& ToleranceTerms() {
  static const std::vector<std::string> terms = [] {
    const std::array<std::string, 6> u{"x", "y", "z", "rx", "ry", "rz"};
    std::vector<std::string> names{"1"};
    for (const std::string& a : u) {
      names.push_back(fmt::format("abs({})", a));
      names.push_back(fmt::format("{}**2", a));
    }
    names.insert(names.end(), {"z", "z*abs(z)"});
    for (size_t i = 0; i < u.size(); ++i) {
      for (size_t k = i + 1; k < u.size(); ++k) {
        names.push_back(fmt::format("abs({}*{})", u[i], u[k]));
      }
    }
    return names;
  }();
  return terms;
}

void ToleranceModel::Visit(SettingsVisitor& v) {
  std::string kind = kKind;
  v.Text("kind", kind, {kKind}, "kind of the file");
  v.Text("object", object, {}, "name of the object");
  v.Text("gripper", gripper, {}, "name of the gripper");
  v.Real("length_scale_m", length_scale_m, {1e-4, 1},
         "position error with a scaled coordinate of 1, m");
  v.Real("angle_scale_rad", angle_scale_rad, {1e-3, 3},
         "rotation error with a scaled coordinate of 1, rad");
  const Range any{-1e6, 1e6};
  v.List(
      "weights", weights.size(), [&](size_t size) { weights.resize(size); },
      [&](size_t i, SettingsVisitor& w) {
        std::string term = i < kTerms ? ToleranceTerms()[i] : "";
        w.Text("term", term, {term},
               "term as an expression in x y z rx ry rz, the scaled error in G; in a fixed order");
        w.Real("w", weights[i], {-1e9, 1e9}, "weight of the term");
      },
      "weights of the logistic regression");
  v.Vector3("surface_mean_m", surface_mean_O, any, "center of the surface in the object frame, m");
  for (int i = 0; i < 3; ++i) {
    Vector3d column = surface_covariance_O.col(i);
    const char* keys[] = {"surface_covariance_x_m2", "surface_covariance_y_m2",
                          "surface_covariance_z_m2"};
    v.Vector3(keys[i], column, any,
              "column of the covariance of the surface in the object frame, m^2");
    surface_covariance_O.col(i) = column;
  }
  v.List(
      "symmetry_turns", symmetries_O.discrete_O.size(),
      [&](size_t size) { symmetries_O.discrete_O.resize(size, Pose::Identity()); },
      [&](size_t i, SettingsVisitor& w) { VisitPose(w, symmetries_O.discrete_O[i]); },
      "symmetric equivalents of the object pose, in the object frame");
  v.List(
      "symmetry_axes", symmetries_O.continuous_O.size(),
      [&](size_t size) { symmetries_O.continuous_O.resize(size); },
      [&](size_t i, SettingsVisitor& w) {
        w.Vector3("axis", symmetries_O.continuous_O[i].axis_O, any,
                  "direction of the axis in the object frame");
        w.Vector3("offset_m", symmetries_O.continuous_O[i].offset_O, any,
                  "point on the axis in the object frame, m");
      },
      "axes of continuous rotational symmetry");
  v.List(
      "grasps", X_OG.size(), [&](size_t size) { X_OG.resize(size, Pose::Identity()); },
      [&](size_t i, SettingsVisitor& w) { VisitPose(w, X_OG[i]); },
      "grasps over which the probability of a hypothesis is averaged");
}

namespace {

// Files of an earlier version have no names of the terms. But all weights have one, or none has.
void RequireAllTerms(const std::filesystem::path& file) {
  const SettingsTree tree = ReadSettingsTree(file);
  const SettingsTree* const weights = tree.Find("weights");
  if (weights == nullptr) return;
  const auto terms = std::ranges::count_if(
      weights->items, [](const SettingsTree& weight) { return weight.Find("term") != nullptr; });
  CheckInput(terms == 0 || terms == std::ssize(weights->items),
             fmt::format("{}: only {} of {} weights have a term; make the file again with `pickbed "
                         "tolerance OBJECT GRIPPER`",
                         weights->place, terms, weights->items.size()));
}

}  // namespace

void WriteToleranceModel(const std::filesystem::path& file, const ToleranceModel& model) {
  ToleranceModel copy = model;
  WriteFileAtomically(file, WriteSettings([&](SettingsVisitor& v) { copy.Visit(v); }));
}

ToleranceModel ReadToleranceModel(const std::filesystem::path& file) {
  ToleranceModel model;
  ReadSettingsFile(file, [&](SettingsVisitor& v) { model.Visit(v); });
  RequireAllTerms(file);
  CheckInput(model.weights.size() == kTerms && !model.X_OG.empty(),
             fmt::format("{}: is not a tolerance model: it has {} weights of {} and {} grasps; "
                         "make one with `pickbed tolerance OBJECT GRIPPER`",
                         file.string(), model.weights.size(), kTerms, model.X_OG.size()));
  const auto is_pose = [](const Pose& X) { return X.linear().isUnitary(kMaxRotationError); };
  CheckInput(std::ranges::all_of(model.X_OG, is_pose) &&
                 std::ranges::all_of(model.symmetries_O.discrete_O, is_pose),
             fmt::format("{}: x and z of a grasp or of a symmetry_turn are no unit vectors at a "
                         "right angle; make it again with `pickbed tolerance OBJECT GRIPPER`",
                         file.string()));
  const auto has_axis = [](const ContinuousSymmetry& symmetry) {
    return std::abs(symmetry.axis_O.norm() - 1) < kMaxRotationError;
  };
  CheckInput(std::ranges::all_of(model.symmetries_O.continuous_O, has_axis),
             fmt::format("{}: an axis of symmetry_axes is no unit vector; make it again with "
                         "`pickbed tolerance OBJECT GRIPPER`",
                         file.string()));
  model.symmetry_inverses_O = InverseSymmetries(model.symmetries_O);
  return model;
}

}  // namespace pickbed::grasp
