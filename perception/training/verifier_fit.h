#pragma once

// Trains the verifier network (pose_features.h), which separates right from wrong poses.

#include <cstdint>
#include <vector>

#include "perception/verify/pose_features.h"
#include "scenes/base/settings.h"

namespace pickbed::perception {

struct VerifierOptions {
  int hidden = 24;
  int iterations = 2500;  // steps of Adam
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

// Minimises the unweighted cross-entropy, so that the output estimates P(right). Throws InputError
// if the training examples are all right or all wrong.
TrainedNetwork TrainVerifier(const VerifierExamples& examples, const VerifierOptions& options,
                             uint64_t seed);

// Returns the probability that a right example scores above a wrong one; ties count half. It is 0.5
// if there are no right or no wrong examples.
double AreaUnderRoc(const std::vector<double>& scores, const std::vector<uint8_t>& right);

}  // namespace pickbed::perception
