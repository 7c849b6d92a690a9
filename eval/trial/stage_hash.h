#pragma once

// 64-bit hashes of the results of each stage of an attempt. A rerun uses them to find the first
// stage that differs. All bits of all numbers count; times do not. Equal hashes mean equal bytes,
// except for one chance in 2^64. Like results, hashes are compared only on one kind of CPU.

#include <array>
#include <bit>
#include <cstdint>
#include <string_view>
#include <type_traits>

#include "eval/layer.h"
#include "scenes/base/ids.h"
#include "scenes/geometry/pose.h"
#include "scenes/image/image.h"

namespace pickbed::scenes {
struct Scene;
}

namespace pickbed::eval {

struct AttemptRecord;
struct Observation;

// In the order in which an attempt reaches them.
enum class TrialStage { kScene, kImage, kHypotheses, kGrasp, kOutcome };
inline constexpr std::array<TrialStage, 5> kTrialStages{TrialStage::kScene, TrialStage::kImage,
                                                        TrialStage::kHypotheses, TrialStage::kGrasp,
                                                        TrialStage::kOutcome};
const char* StageName(TrialStage stage);  // "scene", "image", ...

// Hashes of one attempt, by stage; 0 = the stage was not reached, or the record has no hashes.
struct StageHashes {
  std::array<uint64_t, kTrialStages.size()> values{};
  uint64_t& operator[](TrialStage stage) { return values[static_cast<size_t>(stage)]; }
  uint64_t operator[](TrialStage stage) const { return values[static_cast<size_t>(stage)]; }
  friend bool operator==(const StageHashes&, const StageHashes&) = default;
};

// Hashes eight bytes per step, because an attempt has millions of bytes. A step is xor,
// multiplication and a shift that mixes the high bits into the low bits. Each step is a bijection
// of the state, so no input is lost.
class StateHash {
 public:
  template <typename T>
  StateHash& Add(const T& number) {
    static_assert(std::is_arithmetic_v<T> || std::is_enum_v<T>);
    if constexpr (std::is_floating_point_v<T>) {
      // Adding 0.0 turns -0 into 0, because the store does not distinguish them.
      return AddWord(std::bit_cast<uint64_t>(static_cast<double>(number) + 0.0));
    } else {
      return AddWord(static_cast<uint64_t>(number));
    }
  }
  template <typename Kind>
  StateHash& Add(Id<Kind> id) {
    return Add(int{id});
  }
  StateHash& Add(const Eigen::Vector3d& v) { return Add(v.x()).Add(v.y()).Add(v.z()); }
  StateHash& Add(const Pose& X);
  StateHash& Add(std::string_view text) { return AddBytes(text.data(), text.size()); }
  template <typename T>
  StateHash& Add(const Image<T>& image) {
    return Add(image.width()).Add(image.height()).AddBytes(image.data(), image.size() * sizeof(T));
  }

  uint64_t value() const;  // never 0

 private:
  StateHash& AddWord(uint64_t word) {
    state_ = (state_ ^ word) * 0x9e3779b97f4a7c15ull;
    state_ ^= state_ >> 32;
    return *this;
  }
  StateHash& AddBytes(const void* data, size_t size);

  uint64_t state_ = 0;
};

// Bin, instances and their poses.
uint64_t HashOf(const Scene& scene);
// Intrinsics, color, depth, true instance ids and visible fractions.
uint64_t HashOf(const Observation& view);
// Object, pose and score of each hypothesis.
uint64_t HashOfHypotheses(const AttemptRecord& record);
// The chosen grasp, if any, and the reasons why others were rejected.
uint64_t HashOfGrasp(const AttemptRecord& record);
// All measurements of the physics simulation, the success verdicts and the failure reason.
uint64_t HashOfOutcome(const AttemptRecord& record);

}  // namespace pickbed::eval
