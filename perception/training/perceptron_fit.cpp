#include "perception/training/perceptron_fit.h"

#include <fmt/format.h>
#include <torch/nn/modules/linear.h>
#include <torch/optim/adamw.h>
#include <torch/types.h>
#include <torch/utils.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "perception/networks/eigen_tensors.h"
#include "scenes/base/error.h"

namespace pickbed::perception {
namespace {

struct Perceptron : torch::nn::Module {
  Perceptron(int inputs, const PerceptronOptions& options) : options(options) {
    Add(inputs, options.first);
    Add(options.first, options.second);
    Add(options.second, 1);
  }
  void Add(int64_t inputs, int64_t outputs) {
    layers.push_back(register_module("layer" + std::to_string(layers.size()),
                                     torch::nn::Linear(inputs, outputs)));
  }
  at::Tensor forward(at::Tensor x) {
    x = torch::dropout(x, options.input_dropout, is_training());
    for (size_t i = 0; i + 1 < layers.size(); ++i) {
      x = torch::dropout(torch::relu(layers[i](x)), options.dropout, is_training());
    }
    return layers.back()(x).squeeze(1);
  }
  const PerceptronOptions& options;
  std::vector<torch::nn::Linear> layers;
};

// Share of the largest learning rate at a share of the steps.
double RateAt(double share) {
  constexpr double kRise = 1.0 / 3;
  if (share < kRise) return (share + 0.01) / (kRise + 0.01);
  return (1 + std::cos(std::numbers::pi * (share - kRise) / (1 - kRise))) / 2;
}

}  // namespace

void PerceptronOptions::Visit(SettingsVisitor& v) {
  v.Integer("first", first, {1, 4096}, "units of the first hidden layer");
  v.Integer("second", second, {1, 4096}, "units of the second hidden layer");
  v.Integer("epochs", epochs, {1, 100000}, "passes over the examples");
  v.Integer("batch", batch, {1, 1e6}, "examples in a step");
  v.Real("learning_rate", learning_rate, {1e-6, 1}, "largest learning rate of AdamW");
  v.Real("weight_decay", weight_decay, {0, 1}, "weight decay of AdamW");
  v.Real("dropout", dropout, {0, 0.95}, "share of the hidden units that a step leaves out");
  v.Real("input_dropout", input_dropout, {0, 0.95}, "share of the inputs that a step leaves out");
}

FittedPerceptron FitPerceptron(const PerceptronExamples& examples, const PerceptronOptions& options,
                               uint64_t seed) {
  CheckSettings("PerceptronOptions", options);
  const int64_t count = static_cast<int64_t>(examples.label.size());
  const int64_t ones = std::count(examples.label.begin(), examples.label.end(), 1);
  CheckInput(ones > 0 && ones < count,
             fmt::format("a perceptron needs examples of both labels, but {} of {} have label 1",
                         ones, count));
  at::set_num_threads(1);
  torch::manual_seed(seed);
  const at::Tensor raw = torch::tensor(at::ArrayRef<float>(examples.values))
                             .reshape({count, int64_t{examples.inputs}});
  const at::Tensor mean = raw.mean(0), scale = raw.std(0, false) + 1e-3;
  const at::Tensor x = ((raw - mean) / scale).clamp(-options.max_input, options.max_input);
  const at::Tensor y = torch::tensor(at::ArrayRef<uint8_t>(examples.label)).to(torch::kFloat);

  Perceptron net(examples.inputs, options);
  torch::optim::AdamW adam(
      net.parameters(),
      torch::optim::AdamWOptions(options.learning_rate).weight_decay(options.weight_decay));
  const int64_t batch = std::min<int64_t>(options.batch, count);
  const int64_t steps = options.epochs * (count / batch);
  int64_t step = 0;
  for (int epoch = 0; epoch < options.epochs; ++epoch) {
    const at::Tensor order = torch::randperm(count, torch::kLong);
    for (int64_t first = 0; first + batch <= count; first += batch, ++step) {
      for (torch::optim::OptimizerParamGroup& group : adam.param_groups()) {
        static_cast<torch::optim::AdamWOptions&>(group.options())
            .lr(options.learning_rate * RateAt(static_cast<double>(step) / steps));
      }
      const at::Tensor rows = order.slice(0, first, first + batch);
      adam.zero_grad();
      torch::binary_cross_entropy_with_logits(net.forward(x.index_select(0, rows)),
                                              y.index_select(0, rows))
          .backward();
      adam.step();
    }
  }
  FittedPerceptron fitted{ToVector(mean), ToVector(scale), {}};
  for (const torch::nn::Linear& layer : net.layers) {
    fitted.layers.push_back({ToMatrix(layer->weight), ToVector(layer->bias)});
  }
  return fitted;
}

}  // namespace pickbed::perception
