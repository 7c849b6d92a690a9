#include "perception/segments/edge_contraction.h"

#include <map>
#include <numeric>
#include <queue>
#include <stdexcept>
#include <tuple>

namespace pickbed::perception {
namespace {

// An edge in the queue. It is outdated if the edge has another weight by now.
struct Entry {
  double weight = 0;
  int a = 0, b = 0;
  bool operator<(const Entry& other) const {
    return std::tie(weight, other.a, other.b) < std::tie(other.weight, a, b);
  }
};

int RootOf(std::vector<int>& parent, int node) {
  while (parent[node] != node) node = parent[node] = parent[parent[node]];
  return node;
}

}  // namespace

std::vector<int> ContractEdges(int nodes, const std::vector<WeightedEdge>& edges) {
  std::vector<std::map<int, double>> weights(nodes);  // by node, to each neighbor
  for (const WeightedEdge& edge : edges) {
    if (edge.a < 0 || edge.b < 0 || edge.a >= nodes || edge.b >= nodes || edge.a == edge.b) {
      throw std::logic_error("an edge needs two different nodes of the graph");
    }
    weights[edge.a][edge.b] += edge.weight;
    weights[edge.b][edge.a] += edge.weight;
  }
  std::priority_queue<Entry> queue;
  const auto push = [&](int a, int b, double weight) {
    if (weight > 0) queue.push({weight, std::min(a, b), std::max(a, b)});
  };
  for (int a = 0; a < nodes; ++a) {
    for (const auto& [b, weight] : weights[a]) {
      if (a < b) push(a, b, weight);
    }
  }
  std::vector<int> parent(nodes);
  std::iota(parent.begin(), parent.end(), 0);
  while (!queue.empty()) {
    const Entry entry = queue.top();
    queue.pop();
    if (parent[entry.a] != entry.a || parent[entry.b] != entry.b) continue;
    const auto known = weights[entry.a].find(entry.b);
    if (known == weights[entry.a].end() || known->second != entry.weight) continue;
    // The node with fewer neighbors moves, so that the whole work is nearly linear.
    const bool keeps_a = weights[entry.a].size() >= weights[entry.b].size();
    const int kept = keeps_a ? entry.a : entry.b, moved = keeps_a ? entry.b : entry.a;
    weights[kept].erase(moved);
    weights[moved].erase(kept);
    for (const auto& [other, weight] : weights[moved]) {
      weights[other].erase(moved);
      weights[other][kept] += weight;
      const double sum = weights[kept][other] += weight;
      push(kept, other, sum);
    }
    weights[moved].clear();
    parent[moved] = kept;
  }
  std::vector<int> number(nodes, -1), groups(nodes);
  int count = 0;
  for (int i = 0; i < nodes; ++i) {
    int& of_root = number[RootOf(parent, i)];
    if (of_root < 0) of_root = count++;
    groups[i] = of_root;
  }
  return groups;
}

}  // namespace pickbed::perception
