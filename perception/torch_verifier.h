#pragma once

// Trains the verifier of verify.h: which features belong to a right pose.

#include <cstdint>
#include <vector>

#include "perception/verify.h"
#include "scenes/settings.h"

namespace pickbed {

struct VerifierOptions {
  int hidden = 24;
  int iterations = 2500;  // steps of Adam
  int batch = 1024;       // examples in a step, drawn with replacement
  double learning_rate = 0.01;
  double weight_decay = 1e-4;
  void Visit(SettingsVisitor& v);
};

struct VerifierExamples {
  std::vector<VerifyFeatures> features;
  std::vector<uint8_t> right;  // 1 = the pose is right
  size_t held_out_from = 0;    // from this one on they serve the figure alone; 0 = none
};

struct TrainedVerifier {
  Verifier verifier;
  double auc = 0;  // area under the ROC curve on the held-out examples; 0.5 = useless
};

// Cross-entropy, unweighted, so that the output is an estimate of P(right). Throws InputError when
// the examples are all right or all wrong.
TrainedVerifier TrainVerifier(const VerifierExamples& examples, const VerifierOptions& options,
                              uint64_t seed);

// Probability that a right example scores above a wrong one (ties count half).
double AreaUnderRoc(const std::vector<double>& scores, const std::vector<uint8_t>& right);

}  // namespace pickbed
