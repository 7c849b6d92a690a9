#pragma once

// Fewer triangles within a known distance of the original surface.
//
// Half-edge collapses in the order of Garland and Heckbert's quadric error ("Surface Simplification
// Using Quadric Error Metrics", SIGGRAPH 1997). The order is a guess; whether a collapse is allowed
// is measured: every original vertex, edge midpoint and face centre is kept with the triangle that
// it is nearest to, and must stay within the tolerance.

#include <Eigen/Core>
#include <tuple>
#include <vector>

namespace pickbed {

class EdgeCollapse {
 public:
  // Vertices at equal places must be joined, except where `locked`: those never move or vanish.
  EdgeCollapse(std::vector<Eigen::Vector3d> vertices, std::vector<Eigen::Vector3i> triangles,
               std::vector<bool> locked);

  // Collapses until no edge can go without moving the surface by more than this. Tolerances must
  // rise from call to call.
  void ReduceTo(double tolerance_m);

  // What is left, by the original vertices' indices.
  std::vector<Eigen::Vector3i> Triangles() const;

 private:
  struct Candidate {
    double cost;
    int from, to;
    int from_version, to_version;
    // For a heap whose top is the cheapest; indices decide ties, so that results repeat.
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
  std::vector<bool> alive_;   // of triangles
  std::vector<bool> locked_;  // of vertices
  std::vector<bool> boundary_;
  std::vector<int> version_;  // of vertices: changes when the surface around one does
  std::vector<std::vector<int>> triangles_of_;  // vertex -> alive triangles
  std::vector<Eigen::Matrix4d> quadrics_;
  std::vector<Eigen::Vector3d> tracked_;               // points of the original surface
  std::vector<std::vector<int>> tracked_of_triangle_;  // the tracked points nearest to it
};

}  // namespace pickbed
