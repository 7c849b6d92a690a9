#pragma once

// 64-bit hashes of what each stage of a look made, so that a rerun can tell where it first went
// another way. All bits of all numbers count; times do not. Equal hashes mean equal bytes but for
// one chance in 2^64. They are compared on one kind of CPU only, as results are.

#include <array>
#include <bit>
#include <cstdint>
#include <string_view>
#include <type_traits>

#include "scenes/image.h"
#include "scenes/pose.h"

namespace pickbed {

struct PickRecord;
struct Scene;
struct View;

// In the order in which a look reaches them.
enum class TrialStage { kScene, kImage, kHypotheses, kGrasp, kOutcome };
inline constexpr std::array<TrialStage, 5> kTrialStages{TrialStage::kScene, TrialStage::kImage,
                                                        TrialStage::kHypotheses, TrialStage::kGrasp,
                                                        TrialStage::kOutcome};
const char* StageName(TrialStage stage);  // "scene", "image", ...

// Of one look; 0 = not reached, or of a record that has none.
struct StageHashes {
  std::array<uint64_t, kTrialStages.size()> values{};
  uint64_t& operator[](TrialStage stage) { return values[static_cast<size_t>(stage)]; }
  uint64_t operator[](TrialStage stage) const { return values[static_cast<size_t>(stage)]; }
  friend bool operator==(const StageHashes&, const StageHashes&) = default;
};

// Takes eight bytes a step, since a look has millions: xor, multiplication and a shift that brings
// the high bits down again. Each step is a bijection, so that nothing that went in is forgotten.
class StateHash {
 public:
  template <typename T>
  StateHash& Add(const T& number) {
    static_assert(std::is_arithmetic_v<T> || std::is_enum_v<T>);
    if constexpr (std::is_floating_point_v<T>) {
      // The store does not tell -0 from 0.
      return AddWord(std::bit_cast<uint64_t>(static_cast<double>(number) + 0.0));
    } else {
      return AddWord(static_cast<uint64_t>(number));
    }
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

// Bin and parts, with their poses.
uint64_t HashOf(const Scene& scene);
// Colour, depth, true ids and visible fractions.
uint64_t HashOf(const View& view);
// What was believed: part, pose and score of each hypothesis.
uint64_t HashOfHypotheses(const PickRecord& record);
// The grasp that was chosen, or that there was none, and why others were rejected.
uint64_t HashOfGrasp(const PickRecord& record);
// All that physics measured, and the verdict.
uint64_t HashOfOutcome(const PickRecord& record);

}  // namespace pickbed
