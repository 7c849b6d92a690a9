#pragma once

// Descriptor network, behind an interface without libtorch types. It describes patches, trains on
// batches, and reads and writes its weights as plain values. It runs on the device that
// torch_runtime.h selects. On the CPU the result for a patch does not depend on the threads.

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "perception/features/codebook.h"
#include "perception/networks/doumanoglou.h"
#include "perception/networks/kehl.h"
#include "perception/networks/losses.h"
#include "scenes/base/settings.h"

namespace pickbed::perception {

struct NetworkOptions {
  std::string kind = "convolutional";   // a row of PatchNetworkTable()
  int descriptor = 32;                  // length of the descriptor
  AutoencoderOptions autoencoder = {};  // for kind autoencoder
  RegressionOptions regression = {};    // for kind siamese_regression
  void Visit(SettingsVisitor& v);
};

// Returns the channels of the network's input patches. Throws InputError for an unknown kind.
PatchChannels ChannelsOf(const NetworkOptions& options);

// Input of one training step. Row i of `anchors` and row i of `codes` show the same object in
// nearly the same pose.
struct TrainingBatch {
  int count = 0;
  std::vector<int8_t> anchors;       // count patches from clutter scenes, see patch.h
  std::vector<int8_t> codes;         // count patches from isolated views
  std::vector<float> pose_distance;  // count x count, anchor i to code j, diameters
  // For networks that regress poses, see pose_targets.h. Rows are the anchors, then the codes.
  int variants = 0;              // symmetric poses per row
  std::vector<int64_t> objects;  // object index of each row
  std::vector<float> rotations;  // rows x variants x 4, quaternions w x y z
  std::vector<float> centers;    // rows x 3, centers of mass in the patch frame, patch sides
};

// A network that maps patches to descriptors and, for some kinds, regresses object poses.
class DescriptorNetwork {
 public:
  // Draws new weights from `seed`. `object_count` is the number of objects whose poses it
  // regresses. Throws InputError for an unknown kind.
  DescriptorNetwork(const NetworkOptions& options, uint64_t seed, int object_count = 1);
  ~DescriptorNetwork();
  DescriptorNetwork(DescriptorNetwork&&) noexcept;
  DescriptorNetwork& operator=(DescriptorNetwork&&) noexcept;

  const NetworkOptions& options() const;
  int length() const { return options().descriptor; }
  double MultiplyAdds() const;  // number of operations to describe one patch
  PatchChannels channels() const { return ChannelsOf(options()); }
  bool regresses() const;    // true: Regress() may be called
  int object_count() const;  // number of objects whose poses it regresses

  // Describes count patches (see patch.h). Returns count x length values. Rows have unit norm,
  // except for networks that regress.
  std::vector<float> Describe(std::span<const int8_t> patches, int threads = 1) const;

  // Regresses poses. Returns count x object_count x kPoseValues values, see pose_targets.h.
  std::vector<float> Regress(std::span<const int8_t> patches, int threads = 1) const;

  // Makes one Adam step on the network's own loss and returns the loss before the step.
  // `loss` is used only by networks that are trained by comparing descriptors.
  double TrainStep(const TrainingBatch& batch, const LossOptions& loss, double learning_rate);

  std::vector<float> Weights() const;
  // Throws InputError if the number of weights does not fit this network.
  void SetWeights(std::span<const float> weights);

  // Weights and Adam state, for a checkpoint. RestoreTrainingState throws InputError for bytes of
  // another network or damaged bytes.
  std::string TrainingState() const;
  void RestoreTrainingState(const std::string& bytes);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

// Returns the network's functions for CandidateFinder. The network must outlive them.
PatchVoter VoterOf(const DescriptorNetwork& network, int threads = 1);

// Measures the multiply-adds per second of libtorch's product of two 512 x 512 float matrices
// (SGEMM) on one CPU thread, the best of several runs. It is the reference for a network's speed.
double SgemmRate();

}  // namespace pickbed::perception
