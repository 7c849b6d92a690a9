#pragma once

// Fits a perceptron with rectified hidden layers to labelled examples: it estimates the probability
// of label 1.

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "perception/layer.h"
#include "scenes/base/settings.h"

namespace pickbed::perception {

struct PerceptronOptions {
  int first = 64;               // units of the first hidden layer
  int second = 32;              // units of the second one
  int epochs = 20;              // passes over the examples
  int batch = 256;              // examples in a step
  double learning_rate = 2e-3;  // largest one of AdamW
  double weight_decay = 0.01;
  double dropout = 0.4;        // share of the hidden units that a step leaves out
  double input_dropout = 0.2;  // share of the inputs that a step leaves out
  // Limit of the standardised inputs. Not a setting: the program that uses the fit must apply the
  // same limit.
  double max_input = 4;
  void Visit(SettingsVisitor& v);
};

struct PerceptronExamples {
  int inputs = 0;              // values of an example
  std::vector<float> values;   // examples x inputs
  std::vector<uint8_t> label;  // 0 or 1
};

// Input i of the first layer is (value - mean) / scale, clamped to [-max_input, max_input].
struct FittedPerceptron {
  struct Layer {
    Eigen::MatrixXf weights;  // outputs x inputs
    Eigen::VectorXf bias;
  };
  Eigen::VectorXf mean, scale;
  std::vector<Layer> layers;  // the last has one output, the log odds
};

// Minimises the mean cross-entropy with AdamW (Loshchilov and Hutter, "Decoupled Weight Decay
// Regularization", ICLR 2019). The learning rate rises linearly in the first third of the steps,
// then falls along a cosine to zero. The same seed and examples give the same result on one kind of
// CPU. Throws InputError without examples of both labels.
FittedPerceptron FitPerceptron(const PerceptronExamples& examples, const PerceptronOptions& options,
                               uint64_t seed);

}  // namespace pickbed::perception
