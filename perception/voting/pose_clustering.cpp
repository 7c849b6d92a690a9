#include "perception/voting/pose_clustering.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <span>
#include <unordered_map>

namespace pickbed::perception {
namespace {

// Grid of the kept hypotheses by the mean of their key points. The means of two poses within
// `reach` differ by at most `reach`, so eight cells of twice that size contain all near poses.
class KeptGrid {
 public:
  explicit KeptGrid(double reach_m) : cell_m_(2 * reach_m) {}

  void Add(const Eigen::Vector3f* keypoints_C, int count, int kept) {
    const int begin = static_cast<int>(points_.size());
    points_.insert(points_.end(), keypoints_C, keypoints_C + count);
    const Eigen::Array3i cell = (Mean(keypoints_C, count) / cell_m_).array().floor().cast<int>();
    const auto [head, added] = heads_.try_emplace(Key(cell), static_cast<int>(entries_.size()));
    entries_.push_back({kept, begin, added ? -1 : head->second});
    head->second = static_cast<int>(entries_.size()) - 1;
  }

  // Returns the best kept hypothesis with all key points within `reach_m`; -1 = none.
  int Find(const Eigen::Vector3f* keypoints_C, int count, float reach_m) const {
    int best = -1;
    const Eigen::Array3i low =
        (Mean(keypoints_C, count).array() / cell_m_ - 0.5).floor().cast<int>();
    for (int corner = 0; corner < 8; ++corner) {
      const auto head =
          heads_.find(Key(low + Eigen::Array3i(corner & 1, corner >> 1 & 1, corner >> 2)));
      if (head == heads_.end()) continue;
      for (int e = head->second; e >= 0; e = entries_[e].next) {
        const Entry& entry = entries_[e];
        if ((best < 0 || entry.kept < best) &&
            AllWithin(keypoints_C, points_.data() + entry.begin, count, reach_m)) {
          best = entry.kept;
        }
      }
    }
    return best;
  }

 private:
  struct Entry {
    int kept;   // rank among the kept hypotheses
    int begin;  // index of its first key point
    int next;   // next entry in the same cell; -1 = last
  };

  static Eigen::Vector3d Mean(const Eigen::Vector3f* p, int count) {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (int i = 0; i < count; ++i) sum += p[i].cast<double>();
    return sum / count;
  }

  static bool AllWithin(const Eigen::Vector3f* a, const Eigen::Vector3f* b, int count,
                        float reach_m) {
    for (int i = 0; i < count; ++i) {
      if ((a[i] - b[i]).squaredNorm() > reach_m * reach_m) return false;
    }
    return true;
  }

  // 20 bits per coordinate: 10,000 cells of 1 cm are 100 m.
  static uint64_t Key(const Eigen::Array3i& cell) {
    uint64_t key = 0;
    for (int axis = 0; axis < 3; ++axis) {
      key = key << 20 | (static_cast<uint64_t>(cell[axis]) & 0xfffff);
    }
    return key;
  }

  double cell_m_;
  std::unordered_map<uint64_t, int> heads_;
  std::vector<Entry> entries_;
  std::vector<Eigen::Vector3f> points_;
};

std::vector<int> BestFirst(const std::vector<RawHypothesis>& raw) {
  std::vector<int> order(raw.size());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(),
                   [&](int a, int b) { return raw[a].quick_score > raw[b].quick_score; });
  return order;
}

void Transform(const Pose& X_CO, std::span<const Eigen::Vector3d> points_O,
               std::vector<Eigen::Vector3f>& points_C) {
  points_C.clear();
  for (const Eigen::Vector3d& p : points_O) points_C.push_back((X_CO * p).cast<float>());
}

}  // namespace

std::vector<RawHypothesis> ClusterVotes(std::vector<RawHypothesis> raw,
                                        const std::vector<PoseDistance>& distances, double radius,
                                        int max_kept) {
  std::vector<RawHypothesis> kept;
  std::vector<KeptGrid> grids;  // one per object, because the radius depends on the diameter
  for (const PoseDistance& d : distances) grids.emplace_back(radius * d.diameter_m());
  std::vector<Eigen::Vector3f> points_C;
  for (const int i : BestFirst(raw)) {
    const RawHypothesis& h = raw[i];
    const PoseDistance& distance = distances.at(h.object);
    KeptGrid& grid = grids[h.object];
    const std::vector<Eigen::Vector3d>& variants_O = distance.symmetric_keypoints_O();
    const int n = distance.keypoints();
    Transform(h.X_CO, {variants_O.data(), static_cast<size_t>(n)}, points_C);
    const float reach_m = static_cast<float>(radius * distance.diameter_m());
    const int found = grid.Find(points_C.data(), n, reach_m);
    if (found >= 0) {
      kept[found].votes += h.votes;
    } else if (static_cast<int>(kept.size()) < max_kept) {
      Transform(h.X_CO, variants_O, points_C);
      for (size_t begin = 0; begin < variants_O.size(); begin += n) {
        grid.Add(points_C.data() + begin, n, static_cast<int>(kept.size()));
      }
      kept.push_back(h);
    }
  }
  return kept;
}

}  // namespace pickbed::perception
