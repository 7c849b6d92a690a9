#include "perception/model/distance_field.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "scenes/base/error.h"

namespace pickbed::perception {
namespace {

// Nearest sample found so far for each node.
struct Nearest {
  std::vector<int> sample;  // -1 = none yet
  std::vector<float> squared_m2;
};

class Builder {
 public:
  Builder(const DistanceField& field, std::span<const Eigen::Vector3f> samples)
      : field_(field), samples_(samples) {
    const size_t nodes = static_cast<size_t>(field.size.prod());
    nearest_.sample.assign(nodes, -1);
    nearest_.squared_m2.assign(nodes, std::numeric_limits<float>::max());
  }

  // Offers each sample to the corners of its cell.
  void Seed() {
    for (size_t s = 0; s < samples_.size(); ++s) {
      const Eigen::Vector3i cell =
          ((samples_[s] - field_.origin_O) / field_.cell_m).array().floor().cast<int>();
      for (int corner = 0; corner < 8; ++corner) {
        Offer(cell + Eigen::Vector3i(corner & 1, corner >> 1 & 1, corner >> 2),
              static_cast<int>(s));
      }
    }
  }

  // One pass over all nodes in ascending or descending order. Each node takes over the samples of
  // the neighbours, of its 26, that were visited before it.
  void Sweep(int step) {
    const Eigen::Vector3i last = field_.size - Eigen::Vector3i::Ones();
    const auto coordinate = [&](int i, int axis) { return step > 0 ? i : last[axis] - i; };
    for (int k = 0; k <= last.z(); ++k) {
      for (int j = 0; j <= last.y(); ++j) {
        // Rows are visited in both x directions, so that a pass also propagates sideways.
        for (int i = 0; i <= last.x(); ++i) {
          Take({coordinate(i, 0), coordinate(j, 1), coordinate(k, 2)}, step, step);
        }
        for (int i = last.x(); i >= 0; --i) {
          Take({coordinate(i, 0), coordinate(j, 1), coordinate(k, 2)}, step, -step);
        }
      }
    }
  }

  std::vector<float> Distances() const {
    std::vector<float> d(nearest_.squared_m2.size());
    std::transform(nearest_.squared_m2.begin(), nearest_.squared_m2.end(), d.begin(),
                   [](float squared) { return std::sqrt(squared); });
    return d;
  }

 private:
  int Index(const Eigen::Vector3i& n) const {
    return n.x() + field_.size.x() * (n.y() + field_.size.y() * n.z());
  }

  void Offer(const Eigen::Vector3i& node, int sample) {
    if ((node.array() < 0).any() || (node.array() >= field_.size.array()).any()) return;
    const Eigen::Vector3f p = field_.origin_O + field_.cell_m * node.cast<float>();
    const float squared = (p - samples_[sample]).squaredNorm();
    const int i = Index(node);
    if (squared < nearest_.squared_m2[i]) {
      nearest_.squared_m2[i] = squared;
      nearest_.sample[i] = sample;
    }
  }

  // Offers to `node` the samples of its visited neighbours: in the slice before it in z, the row
  // before it in y, and the node before it in x.
  void Take(const Eigen::Vector3i& node, int step, int step_x) {
    int previous = nearest_.sample[Index(node)];
    const auto take_from = [&](int dx, int dy, int dz) {
      const Eigen::Vector3i from = node + Eigen::Vector3i(dx, dy, dz);
      if ((from.array() < 0).any() || (from.array() >= field_.size.array()).any()) return;
      const int sample = nearest_.sample[Index(from)];
      if (sample < 0 || sample == previous) return;
      Offer(node, sample);
      previous = sample;
    };
    take_from(-step_x, 0, 0);
    for (int dx = -1; dx <= 1; ++dx) take_from(dx, -step, 0);
    for (int dy = -1; dy <= 1; ++dy) {
      for (int dx = -1; dx <= 1; ++dx) take_from(dx, dy, -step);
    }
  }

  const DistanceField& field_;
  std::span<const Eigen::Vector3f> samples_;
  Nearest nearest_;
};

// Marks the nodes that a flood fill from the grid border does not reach. The fill moves along the
// grid axes and stops at nodes within one cell of the surface. It cannot cross the surface: of two
// neighbouring nodes on both sides of it, one is within half a cell.
std::vector<uint8_t> Enclosed(const DistanceField& field) {
  const Eigen::Array3i size = field.size;
  const auto index = [&](const Eigen::Array3i& n) {
    return n.x() + size.x() * (n.y() + size.y() * n.z());
  };
  std::vector<uint8_t> enclosed(field.distance_m.size());
  std::transform(field.distance_m.begin(), field.distance_m.end(), enclosed.begin(),
                 [&](float distance_m) { return distance_m > field.cell_m ? 1 : 0; });
  std::vector<Eigen::Array3i> open;
  const auto enter = [&](const Eigen::Array3i& n) {
    if (!enclosed[index(n)]) return;
    enclosed[index(n)] = 0;
    open.push_back(n);
  };
  for (int k = 0; k < size.z(); ++k) {
    for (int j = 0; j < size.y(); ++j) {
      for (int i = 0; i < size.x(); ++i) {
        const Eigen::Array3i n(i, j, k);
        if ((n == 0).any() || (n == size - 1).any()) enter(n);
      }
    }
  }
  while (!open.empty()) {
    const Eigen::Array3i n = open.back();
    open.pop_back();
    for (int axis = 0; axis < 3; ++axis) {
      for (const int step : {-1, 1}) {
        Eigen::Array3i next = n;
        next[axis] += step;
        if (next[axis] >= 0 && next[axis] < size[axis]) enter(next);
      }
    }
  }
  return enclosed;
}

}  // namespace

DistanceField MakeDistanceField(std::span<const Eigen::Vector3f> samples_O, double padding_m,
                                int nodes) {
  CheckInput(!samples_O.empty(), "a distance field needs at least one surface sample");
  CheckInput(nodes >= 4, "a distance field needs at least 4 nodes along its longest axis");
  CheckInput(std::all_of(samples_O.begin(), samples_O.end(),
                         [](const Eigen::Vector3f& p) { return p.allFinite(); }),
             "a sample of a distance field is not finite; repair the mesh");
  Eigen::Vector3f low = samples_O.front(), high = samples_O.front();
  for (const Eigen::Vector3f& p : samples_O) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  const float padding = static_cast<float>(padding_m);
  const Eigen::Vector3f extent = high - low + Eigen::Vector3f::Constant(2 * padding);
  CheckInput(extent.maxCoeff() > 0 && extent.allFinite(),
             "a distance field of one point needs a padding above 0");
  DistanceField field;
  field.cell_m = extent.maxCoeff() / static_cast<float>(nodes - 1);
  field.origin_O = low - Eigen::Vector3f::Constant(padding);
  field.size = (extent / field.cell_m).array().ceil().cast<int>().min(nodes - 1) + 1;
  Builder builder(field, samples_O);
  builder.Seed();
  builder.Sweep(1);
  builder.Sweep(-1);
  field.distance_m = builder.Distances();
  field.is_inside = Enclosed(field);
  return field;
}

}  // namespace pickbed::perception
