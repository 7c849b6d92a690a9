#pragma once

// Partition of a graph with attractive and repulsive edges.

#include <vector>

#include "perception/layer.h"

namespace pickbed::perception {

// An undirected edge between two nodes. A positive weight joins them, a negative one separates
// them.
struct WeightedEdge {
  int a = 0, b = 0;
  double weight = 0;
};

// Joins nodes by greedy additive edge contraction (Keuper et al., "Efficient decomposition of image
// and mesh graphs by lifted multicuts", ICCV 2015): the edge with the largest weight is contracted,
// parallel edges are added, until no weight is positive. Edges with equal weights are contracted in
// the order of their nodes, so the result is deterministic.
// - nodes: number of nodes
// - edges: edges between different nodes; parallel edges are added
// Returns the group of each node; groups are numbered from 0 in the order of their first nodes.
// Throws std::logic_error for an edge to an unknown node or to itself.
std::vector<int> ContractEdges(int nodes, const std::vector<WeightedEdge>& edges);

}  // namespace pickbed::perception
