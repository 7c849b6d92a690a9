#pragma once

// The completion network, without libtorch types. There are two kinds (completion_net.h).
//
// implicit: a 3D U-Net over the channels of CompletionInput and a 2D U-Net over its image, and a
// perceptron that decodes the probability of single points (implicit decoder, as in Peng et al.,
// "Convolutional Occupancy Networks", ECCV 2020). The image has the details of thin walls, which
// the volume lacks (features at the pixel of a point, as in Saito et al., "PIFu", ICCV 2019).
//
//   channels 4 x 32^3 -> space to depth 32 x 16^3 -> 16^3, 8^3, 4^3 (+ bottleneck) -> 8^3 -> 16^3
//   image 5 x 64^2 -> 64^2, 32^2, 16^2, 8^2 -> 16^2 -> 32^2 -> 64^2
//   features at the point and at its pixel, positions, facts -> two hidden layers -> probability
//
// vae: a variational auto-encoder of 32^3 volumes of whole shapes (Kingma and Welling,
// "Auto-Encoding Variational Bayes", ICLR 2014). A completion starts from the observed cells. It
// then repeats rounds: reconstruct the volume, with a random sample of the code, and clamp the
// observed cells to what was seen.
//
// On the CPU the result of a point does not depend on the number of threads.

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "perception/completion/completion_input.h"
#include "perception/completion_networks/network_options.h"

namespace pickbed::perception {

// Input of one training step.
struct CompletionBatch {
  int count = 0;                 // views
  int points = 0;                // queries for each view
  std::vector<int8_t> channels;  // count x CompletionInput::Channels()
  std::vector<float> images;     // count x CompletionInput::ImageChannels()
  std::vector<float> queries;    // count x points x kQueryValues
  std::vector<float> inside;     // count x points, 1 = the point is inside the object
  // count x kInputCells^3, 127 = the center of the cell is inside; empty if not needed
  std::vector<int8_t> volumes;
};

// Points of a view (m, in C) whose probabilities are asked for.
struct NetworkQuery {
  const CompletionInput* input;
  std::span<const Eigen::Vector3f> points_C;
};

class CompletionNetwork {
 public:
  // Draws new weights from `seed`. `device` is cpu or cuda. Throws InputError for cuda without a
  // device.
  explicit CompletionNetwork(const CompletionNetworkOptions& options, uint64_t seed = 0,
                             const std::string& device = "cpu");
  ~CompletionNetwork();
  CompletionNetwork(CompletionNetwork&&) noexcept;
  CompletionNetwork& operator=(CompletionNetwork&&) noexcept;

  // Returns whether a network with these options needs CompletionBatch::volumes to train.
  static bool NeedsVolumes(const CompletionNetworkOptions& options);
  const CompletionNetworkOptions& options() const;

  // Makes one Adam step on the loss of the kind and returns the loss as it was before the step. It
  // is the mean cross-entropy of all points (implicit), or of all cells plus the divergence of the
  // code (vae). Each of the `replicas` (from 1) takes a nearly equal part of the views in a thread
  // of its own, and normalizes over this part. Their gradients and the statistics of their
  // normalizations are averaged over the views.
  double TrainStep(const CompletionBatch& batch, double learning_rate, int replicas = 1);

  // Returns the probability of each query of a batch; `inside` is not used.
  std::vector<float> Probabilities(const CompletionBatch& batch) const;

  // Returns the probability that the object contains each point in C (m): the mean over `turns` (1
  // to kCubeTurns) turned copies of the view.
  std::vector<float> Probabilities(const CompletionInput& input,
                                   std::span<const Eigen::Vector3f> points_C, int turns = 1) const;
  // Returns the same for each query. The views are encoded together.
  std::vector<std::vector<float>> Probabilities(std::span<const NetworkQuery> queries,
                                                int turns = 1) const;

  // All weights, and the means and variances of the normalizations, in the order of the modules.
  std::vector<float> Weights() const;
  std::vector<float> Statistics() const;
  // Throws InputError if the numbers of values do not fit this network.
  void SetWeights(std::span<const float> weights, std::span<const float> statistics);

  // Weights, statistics and Adam state, for a checkpoint. RestoreTrainingState throws InputError
  // for bytes of another network or damaged bytes.
  std::string TrainingState() const;
  void RestoreTrainingState(const std::string& bytes);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

// Returns the values of a query at a point in C (m): kQueryValues.
void AppendQuery(const CompletionInput& input, const Eigen::Vector3f& p_C,
                 std::vector<float>& queries);

}  // namespace pickbed::perception
