#include "perception/completion/nearest_shape.h"

#include "perception/completion/network_completer.h"

namespace pickbed::perception {
namespace {

constexpr int kBlock = 4;  // cells along each axis of a block
constexpr int kBlocks = kInputCells / kBlock;
constexpr uint64_t kSeed = 11;
constexpr int kViewsPerShape = 4;

// Returns the channels averaged over blocks.
std::vector<int8_t> Coarse(const std::vector<int8_t>& channels) {
  std::vector<int> sums(kInputChannels * kBlocks * kBlocks * kBlocks, 0);
  size_t cell = 0;
  for (int channel = 0; channel < kInputChannels; ++channel) {
    for (int z = 0; z < kInputCells; ++z) {
      for (int y = 0; y < kInputCells; ++y) {
        for (int x = 0; x < kInputCells; ++x, ++cell) {
          const int block = (z / kBlock * kBlocks + y / kBlock) * kBlocks + x / kBlock;
          sums[channel * kBlocks * kBlocks * kBlocks + block] += channels[cell];
        }
      }
    }
  }
  std::vector<int8_t> coarse(sums.size());
  for (size_t i = 0; i < sums.size(); ++i) {
    coarse[i] = static_cast<int8_t>(sums[i] / (kBlock * kBlock * kBlock));
  }
  return coarse;
}

int64_t Difference(const std::vector<int8_t>& a, const std::vector<int8_t>& b) {
  int64_t sum = 0;
  for (size_t i = 0; i < a.size(); ++i) {
    const int difference = a[i] - b[i];
    sum += difference * difference;
  }
  return sum;
}

}  // namespace

NearestShape::NearestShape(const std::vector<const ShapeFamilyRow*>& families, int count, int cells)
    : cells_(cells) {
  Rng rng(kSeed);
  for (int i = 0; i < count; ++i) {
    if (i % kViewsPerShape == 0) {
      const ShapeFamilyRow& family = *families[solids_.size() % families.size()];
      solids_.push_back(SolidOf(SampleShape(family, ShapeSplit::kSeen, rng.Next()).solid));
    }
    const RandomView drawn = DrawView(*solids_.back(), {}, {}, rng);
    const CompletionInput input(drawn.view);
    entries_.push_back(
        {static_cast<int>(solids_.size()) - 1, drawn.X_CO, input.cube(), Coarse(input.Channels())});
  }
}

CompletedVolume NearestShape::Complete(const SegmentView& view) {
  const CompletionInput input(view);
  const std::vector<int8_t> channels = input.Channels();
  std::vector<int8_t> turned(channels.size());
  const Entry* nearest = nullptr;
  int nearest_turn = 0;
  int64_t smallest = INT64_MAX;
  for (int turn = 0; turn < kCubeTurns; ++turn) {
    TurnChannels(channels, turn, turned.data());
    const std::vector<int8_t> coarse = Coarse(turned);
    for (const Entry& entry : entries_) {
      const int64_t difference = Difference(coarse, entry.coarse);
      if (difference >= smallest) continue;
      smallest = difference;
      nearest = &entry;
      nearest_turn = turn;
    }
  }
  CompletedVolume volume = EmptyVolume(input.cube(), cells_);
  std::vector<Eigen::Vector3f> points_O;
  points_O.reserve(volume.occupancy.size());
  const Eigen::Isometry3f X_OC = nearest->X_CO.inverse().cast<float>();
  for (int z = 0; z < cells_; ++z) {
    for (int y = 0; y < cells_; ++y) {
      for (int x = 0; x < cells_; ++x) {
        Eigen::Vector3f share =
            (Eigen::Vector3f(x, y, z) + Eigen::Vector3f::Constant(0.5f)) / cells_;
        if (nearest_turn & 1) share.x() = 1 - share.x();
        if (nearest_turn & 2) share.y() = 1 - share.y();
        if (nearest_turn & 4) std::swap(share.x(), share.y());
        points_O.push_back(X_OC * (nearest->cube.origin_C + nearest->cube.side_m * share));
      }
    }
  }
  std::vector<uint8_t> inside(points_O.size());
  solids_[nearest->solid]->Inside(points_O, inside);
  std::copy(inside.begin(), inside.end(), volume.occupancy.begin());
  return volume;
}

}  // namespace pickbed::perception
