#pragma once

// Evenly spread directions: viewing directions, support directions and directions of extreme
// vertices.

#include <Eigen/Core>
#include <vector>

namespace pickbed::scenes {

// Returns `count` unit vectors that are spread evenly over the sphere, from +z to -z (Fibonacci
// lattice; Gonzalez, "Measurement of areas on a sphere using Fibonacci and latitude-longitude
// lattices", Mathematical Geosciences 2010).
std::vector<Eigen::Vector3d> SphereDirections(int count);

}  // namespace pickbed::scenes
