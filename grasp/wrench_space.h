#pragma once

// Sets of wrenches that a hand can put on a part, and two questions about them: does the set hold a
// given load, and how large a load from the worst direction does it hold.
//
// A wrench is (force, torque), six numbers without unit: forces are divided by the part's weight,
// torques (about its centre of mass) by that weight times a radius that the caller states. The set
// is the Minkowski sum of what each contact region can give by itself, so that each may push with
// all of its force whatever the others do (Ferrari and Canny 1992, equation 7: the metric with
// bounded single forces).

#include <Eigen/Core>
#include <vector>

namespace pickbed {

using Wrench = Eigen::Matrix<double, 6, 1>;
using Wrenches = Eigen::Matrix<double, 6, Eigen::Dynamic>;  // one a column

// All sums of one convex combination of each region's columns and zero, moved by `offset`.
struct WrenchSet {
  std::vector<Wrenches> regions;
  Wrench offset = Wrench::Zero();

  // The wrench of the set that goes furthest along `direction`.
  Wrench Support(const Wrench& direction) const;
};

// A friction cone at a point, of contacts that push with up to `force`: its edges at full force.
struct ContactCone {
  Eigen::Vector3d point;   // from the centre of mass, m
  Eigen::Vector3d inward;  // unit, into the part
  double force = 1;        // normal, in weights of the part
  double friction = 0.5;
};

// `edges` (3 or more) wrenches on the rim of the cone, as columns: its linearisation from inside.
Wrenches ConeEdges(const ContactCone& cone, int edges, double radius_m);

struct WrenchDepthOptions {
  double tolerance = 1e-3;       // gap between the bounds, as a share of the upper one
  int max_facets = 40000;        // after which the bounds are returned as they stand
  double flat_share = 1e-6;      // of the set's size; sets thinner than that hold nothing
  double coplanar_share = 1e-9;  // of the set's size; points this near to a facet's plane are in it
};

// The radius of the largest ball about zero inside the set: Ferrari and Canny's epsilon. 0 when
// zero is outside. A polytope is grown inside the set, always at its facet nearest to zero, until
// that facet is one of the set's own (the expanding polytope of van den Bergen 2001, in six
// dimensions). No linear programs and no enumeration of the whole hull.
struct WrenchDepth {
  double lower = 0;  // the radius is at least this
  double upper = 0;  // and at most this
};
WrenchDepth DepthOfZero(const WrenchSet& set, const WrenchDepthOptions& options = {});

// Whether `load` can be balanced, that is -load lies in the set (to `tolerance`): by the point of
// the set nearest to it (Wolfe 1976, "Finding the nearest point in a polytope").
bool Balances(const WrenchSet& set, const Wrench& load, double tolerance = 1e-6);

}  // namespace pickbed
