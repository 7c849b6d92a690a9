#pragma once

// Trains the verifier network (pose_features.h), which separates right from wrong poses.

#include <cstdint>
#include <vector>

#include "perception/verify/pose_features.h"
#include "scenes/base/settings.h"

namespace pickbed::perception {

struct VerifierOptions {
  int hidden = 24;        // hidden units of all networks together
  int networks = 3;       // networks whose logits are averaged; each has its share of the units
  int iterations = 2500;  // steps of Adam, of each network
  int batch = 1024;       // examples in a step, drawn with replacement
  double learning_rate = 0.01;
  double weight_decay = 1e-4;
  void Visit(SettingsVisitor& v);
};

// Labelled examples.
struct VerifierExamples {
  std::vector<VerifyFeatures> features;
  std::vector<uint8_t> right;  // 1 = the pose is right
  size_t held_out_from = 0;    // examples from here on are used only for the AUC; 0 = none
};

// A network and its quality.
struct TrainedNetwork {
  VerifierNetwork network;
  double auc = 0;  // area under the ROC curve on the held-out examples; 0.5 = useless
};

// A verifier and its quality.
struct TrainedVerifier {
  Verifier verifier;
  double auc = 0;  // of the network for known backgrounds
};

// Trains several small networks with the unweighted cross-entropy, so that each output estimates
// P(right). They differ in their first weights and in the order of the examples. The mean of their
// logits varies less between seeds than the logit of one network (Hansen and Salamon, "Neural
// Network Ensembles", IEEE TPAMI 1990). It is itself a network with one hidden layer.
// Throws InputError if the training examples are all right or all wrong.
TrainedNetwork TrainVerifier(const VerifierExamples& examples, const VerifierOptions& options,
                             uint64_t seed);

// Returns the network whose logit is the mean of the logits of two networks.
VerifierNetwork MeanNetwork(const VerifierNetwork& a, const VerifierNetwork& b);

// Returns the probability that a right example scores above a wrong one; ties count half. It is 0.5
// if there are no right or no wrong examples.
double AreaUnderRoc(const std::vector<double>& scores, const std::vector<uint8_t>& right);

}  // namespace pickbed::perception
