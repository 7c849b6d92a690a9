#pragma once

// Sets of wrenches that a hand can exert on an object. Two queries: whether the set resists a given
// load, and how large a load it resists in the worst direction.
//
// A wrench is (force, torque), six dimensionless numbers. Forces are divided by the weight of the
// object. Torques are about its center of mass and divided by the weight times a radius that the
// caller gives. The set is the Minkowski sum of the wrenches of each contact region. So each region
// may push with its full force independently of the others (Ferrari and Canny 1992, equation 7: the
// metric with bounded single forces).

#include <Eigen/Core>
#include <vector>

#include "grasp/layer.h"

namespace pickbed::grasp {

using Wrench = Eigen::Matrix<double, 6, 1>;
using Wrenches = Eigen::Matrix<double, 6, Eigen::Dynamic>;  // one wrench per column

// Set of sums: for each region one convex combination of its columns and zero, plus `offset`.
struct WrenchSet {
  std::vector<Wrenches> regions;
  Wrench offset = Wrench::Zero();

  // Returns the wrench of the set that is furthest along `direction`.
  Wrench Support(const Wrench& direction) const;
};

// Friction cone at a point with a bounded normal force.
struct ContactCone {
  Eigen::Vector3d point;   // from the center of mass, m
  Eigen::Vector3d inward;  // unit, into the object
  double force = 1;        // maximum normal force, in weights of the object
  double friction = 0.5;
};

// Inner linearization of the cone: `edges` (3 or more) wrenches on its rim at full force, one per
// column. Torques are divided by `radius_m`.
Wrenches ConeEdges(const ContactCone& cone, int edges, double radius_m);

// Tolerances of DepthOfZero.
struct WrenchDepthOptions {
  double tolerance = 1e-3;       // gap between the bounds, relative to the upper bound
  int max_facets = 40000;        // the search stops here and returns the current bounds
  double flat_share = 1e-6;      // of the set size; a thinner set resists nothing
  double coplanar_share = 1e-9;  // of the set size; points this close to a facet are coplanar
};

// Epsilon of Ferrari and Canny: radius of the largest ball around zero inside the set; 0 if zero is
// outside. A polytope grows inside the set, always at its facet nearest to zero. It ends
// when that facet belongs to the set (expanding polytope, van den Bergen 2001, in six dimensions).
// This needs no linear programs and no enumeration of the whole hull.
struct WrenchDepth {
  double lower = 0;  // lower bound of the radius
  double upper = 0;  // upper bound of the radius
};
// Computes both bounds. Their gap is within the tolerance of `options`, unless the limit of facets
// is reached.
WrenchDepth DepthOfZero(const WrenchSet& set, const WrenchDepthOptions& options = {});

// Returns true if the set balances `load`, which means that -load is in the set within `tolerance`.
// Finds the nearest point of the set (Wolfe 1976, "Finding the nearest point in a polytope").
bool Balances(const WrenchSet& set, const Wrench& load, double tolerance = 1e-6);

}  // namespace pickbed::grasp
