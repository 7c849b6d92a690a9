#pragma once

// The descriptor network behind a header that is free of libtorch: describes patches, learns from
// batches, and gives its state as bytes. On the CPU what is computed for a patch depends on no
// thread, so that results repeat; where torch_device.h finds CUDA it runs there. Weights come and
// go as plain values.

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "perception/networks/doumanoglou.h"
#include "perception/networks/kehl.h"
#include "perception/patch_voter.h"
#include "perception/torch_losses.h"
#include "scenes/settings.h"

namespace pickbed {

struct NetworkOptions {
  std::string kind = "convolutional";   // a row of PatchNetworkTable()
  int descriptor = 32;                  // length of the descriptor
  AutoencoderOptions autoencoder = {};  // of kind autoencoder
  RegressionOptions regression = {};    // of kind siamese_regression
  void Visit(SettingsVisitor& v);
};

// Of the patches that such a network sees. Throws InputError for an unknown kind.
PatchChannels ChannelsOf(const NetworkOptions& options);

// Row i of anchors and codes shows nearly the same pose of the same part.
struct TrainingBatch {
  int count = 0;
  std::vector<int8_t> anchors;       // count patches from piles, see patch.h
  std::vector<int8_t> codes;         // count patches from isolated views
  std::vector<float> pose_distance;  // count x count, anchor i to code j, diameters
  // For networks that regress, see pose_targets.h; rows: the anchors, then their codes.
  int variants = 0;              // symmetric poses of a row
  std::vector<int64_t> parts;    // of each row
  std::vector<float> rotations;  // rows x variants x 4
  std::vector<float> middles;    // rows x 3
};

class DescriptorNetwork {
 public:
  // Fresh weights drawn from `seed`. Throws InputError for an unknown kind. parts: of which a
  // network that regresses gives poses.
  DescriptorNetwork(const NetworkOptions& options, uint64_t seed, int parts = 1);
  ~DescriptorNetwork();
  DescriptorNetwork(DescriptorNetwork&&) noexcept;
  DescriptorNetwork& operator=(DescriptorNetwork&&) noexcept;

  const NetworkOptions& options() const;
  int length() const { return options().descriptor; }
  double MultiplyAdds() const;                                      // to describe one patch
  PatchChannels channels() const { return ChannelsOf(options()); }  // of the patches that it sees
  bool regresses() const;                                           // Regress() may be called
  int parts() const;                                                // whose poses it regresses

  // count x length values, of count patches of patch.h; rows of unit length but of networks that
  // regress.
  std::vector<float> Describe(std::span<const int8_t> patches, int threads = 1) const;

  // count x parts x kPoseValues values, see pose_targets.h.
  std::vector<float> Regress(std::span<const int8_t> patches, int threads = 1) const;

  // One step of Adam on the network's own loss; returns the loss before it. `loss`: of networks
  // that are taught by comparing descriptors.
  double TrainStep(const TrainingBatch& batch, const LossOptions& loss, double learning_rate);

  // The weights one after the other.
  std::vector<float> Weights() const;
  // Throws InputError when the number does not fit this network.
  void SetWeights(std::span<const float> weights);

  // Weights and the state of Adam, for a checkpoint. Restore throws InputError for foreign bytes.
  std::string TrainingState() const;
  void RestoreTrainingState(const std::string& bytes);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

// The network, which must outlive it, for CandidateFinder.
PatchVoter VoterOf(const DescriptorNetwork& network, int threads = 1);

// Multiply-adds a second of libtorch's product of two float matrices of 512 x 512 (SGEMM) on one
// thread of the CPU, the best of some: the measure of a network's speed.
double SgemmRate();

}  // namespace pickbed
