#pragma once

// Reduces the triangles of a mesh and keeps it within a given distance of the original surface.
//
// Half-edges are collapsed in the order of Garland and Heckbert's quadric error ("Surface
// Simplification Using Quadric Error Metrics", SIGGRAPH 1997). The order is a heuristic, but the
// deviation is measured. Every original vertex, edge midpoint and face center is assigned to its
// nearest triangle. A collapse is allowed only if these points stay within the tolerance.
//
// All edges in a plane have the same error. Without a further rule, their order follows the vertex
// indices, and single vertices get hundreds of triangles, which is slow. `length_weight` adds
// length^4 to the error, so that short edges collapse first and triangles stay compact.

#include <Eigen/Core>
#include <tuple>
#include <vector>

namespace pickbed::scenes {

// Simplifies one mesh in steps of increasing tolerance.
class EdgeCollapse {
 public:
  // Vertices (m) at the same place must be joined, except `locked` ones. A locked vertex is never
  // moved or removed. A `length_weight` of w makes an edge of length l cost as much as a deviation
  // of sqrt(w) l on an area of l^2.
  EdgeCollapse(std::vector<Eigen::Vector3d> vertices, std::vector<Eigen::Vector3i> triangles,
               std::vector<bool> locked, double length_weight = 0);

  // Collapses edges until each further collapse would move the surface by more than the tolerance.
  // Tolerances must increase from call to call.
  void ReduceTo(double tolerance_m);

  // Returns the remaining triangles with the indices of the original vertices.
  std::vector<Eigen::Vector3i> Triangles() const;

 private:
  struct Candidate {
    double cost;
    int from, to;
    int from_version, to_version;
    // Reversed, so that the top of the heap is the cheapest. Indices break ties, which makes the
    // result reproducible.
    bool operator<(const Candidate& o) const {
      return std::tie(cost, from, to) > std::tie(o.cost, o.from, o.to);
    }
  };

  void AddQuadrics();
  void AddTrackedPoints();
  std::vector<int> NeighborsOf(int vertex) const;
  bool IsBoundaryEdge(int a, int b) const;
  bool KeepsTopology(int from, int to) const;
  Candidate MakeCandidate(int from, int to) const;
  bool TryCollapse(int from, int to, double tolerance_m);

  std::vector<Eigen::Vector3d> vertices_;
  std::vector<Eigen::Vector3i> triangles_;
  double length_weight_;
  std::vector<bool> alive_;   // of triangles
  std::vector<bool> locked_;  // of vertices
  std::vector<bool> boundary_;
  std::vector<int> version_;  // of vertices; changes when the surface around the vertex changes
  std::vector<std::vector<int>> triangles_of_;  // vertex -> alive triangles
  std::vector<Eigen::Matrix4d> quadrics_;
  std::vector<Eigen::Vector3d> tracked_;               // points of the original surface
  std::vector<std::vector<int>> tracked_of_triangle_;  // triangle -> the points nearest to it
};

}  // namespace pickbed::scenes
