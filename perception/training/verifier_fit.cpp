#include "perception/training/verifier_fit.h"

#include <torch/nn/modules/linear.h>
#include <torch/optim/adam.h>
#include <torch/types.h>
#include <torch/utils.h>

#include <algorithm>
#include <numeric>

#include "perception/networks/eigen_tensors.h"
#include "scenes/base/error.h"

namespace pickbed::perception {
namespace {

at::Tensor FeatureTensor(const VerifierExamples& examples) {
  const int64_t count = static_cast<int64_t>(examples.features.size());
  at::Tensor x = torch::empty({count, kVerifyFeatures});
  std::copy_n(examples.features.data()->data(), count * kVerifyFeatures, x.data_ptr<float>());
  return x;
}

struct VerifierModule : torch::nn::Module {
  explicit VerifierModule(int hidden) {
    first = register_module("first", torch::nn::Linear(kVerifyFeatures, hidden));
    last = register_module("last", torch::nn::Linear(hidden, 1));
  }
  at::Tensor forward(const at::Tensor& x) { return last(torch::tanh(first(x))).squeeze(1); }
  torch::nn::Linear first{nullptr}, last{nullptr};
};

void Fit(VerifierModule& net, const at::Tensor& x, const at::Tensor& y,
         const VerifierOptions& options) {
  torch::optim::Adam adam(
      net.parameters(),
      torch::optim::AdamOptions(options.learning_rate).weight_decay(options.weight_decay));
  for (int i = 0; i < options.iterations; ++i) {
    // The learning rate decays linearly to zero over the second half.
    const double share = static_cast<double>(i) / options.iterations;
    for (torch::optim::OptimizerParamGroup& group : adam.param_groups()) {
      static_cast<torch::optim::AdamOptions&>(group.options())
          .lr(options.learning_rate * std::min(1.0, 2.0 * (1.0 - share)));
    }
    const at::Tensor rows =
        torch::randint(x.size(0), {std::min<int64_t>(options.batch, x.size(0))}, torch::kLong);
    adam.zero_grad();
    torch::binary_cross_entropy_with_logits(net.forward(x.index_select(0, rows)),
                                            y.index_select(0, rows))
        .backward();
    adam.step();
  }
}

}  // namespace

void VerifierOptions::Visit(SettingsVisitor& v) {
  v.Integer("hidden", hidden, {1, 1024}, "number of hidden units of all networks together");
  v.Integer("networks", networks, {1, 1024},
            "number of networks whose logits are averaged; at most one per hidden unit");
  v.Integer("iterations", iterations, {1, 1000000}, "number of steps of each network");
  v.Integer("batch", batch, {1, 1000000}, "examples per step");
  v.Real("learning_rate", learning_rate, {1e-6, 1}, "learning rate of Adam");
  v.Real("weight_decay", weight_decay, {0, 1}, "weight decay of Adam");
}

TrainedNetwork TrainVerifier(const VerifierExamples& examples, const VerifierOptions& options,
                             uint64_t seed) {
  CheckSettings("VerifierOptions", options);
  const int64_t count = static_cast<int64_t>(examples.features.size());
  const int64_t kept =
      examples.held_out_from > 0 ? static_cast<int64_t>(examples.held_out_from) : count;
  const auto right = std::count(examples.right.begin(), examples.right.begin() + kept, 1);
  CheckInput(right > 0 && right < kept,
             "the verifier needs right and wrong poses for training, but has " +
                 std::to_string(right) + " right of " + std::to_string(kept) +
                 "; raise clutter_scenes, or train the network that proposes them longer");
  at::set_num_threads(1);
  torch::manual_seed(seed);
  const at::Tensor all = FeatureTensor(examples);
  const at::Tensor x = all.slice(0, 0, kept);
  const at::Tensor mean = x.mean(0), scale = x.std(0, false).clamp_min(1e-3);
  const at::Tensor y = torch::tensor(at::ArrayRef<uint8_t>(examples.right)).to(torch::kFloat);
  TrainedNetwork trained;
  VerifierNetwork& network = trained.network;
  network.mean = ToVector(mean);
  network.scale = ToVector(scale);
  network.w1.resize(options.hidden, kVerifyFeatures);
  network.b1.resize(options.hidden);
  network.w2.resize(options.hidden);
  const int networks = std::min(options.networks, options.hidden);
  const auto share = 1 / static_cast<float>(networks);
  for (int n = 0; n < networks; ++n) {
    const int first = options.hidden * n / networks;
    const int units = options.hidden * (n + 1) / networks - first;
    VerifierModule net(units);
    Fit(net, (x - mean) / scale, y.slice(0, 0, kept), options);
    network.w1.block(first, 0, units, kVerifyFeatures) = ToMatrix(net.first->weight);
    network.b1.segment(first, units) = ToVector(net.first->bias);
    network.w2.segment(first, units) = share * ToVector(net.last->weight.flatten());
    network.b2 += share * net.last->bias.item<float>();
  }
  std::vector<double> scores;
  for (int64_t i = kept; i < count; ++i) {
    scores.push_back(network.Logit(examples.features[i]));
  }
  trained.auc = AreaUnderRoc(scores, {examples.right.begin() + kept, examples.right.end()});
  return trained;
}

VerifierNetwork MeanNetwork(const VerifierNetwork& a, const VerifierNetwork& b) {
  // The units of `b` get the standardised inputs x of `a`, and f = scale_a x + mean_a, so
  // (f - mean_b) / scale_b = scale_a / scale_b x + (mean_a - mean_b) / scale_b.
  const Eigen::Index units_a = a.b1.size(), units_b = b.b1.size();
  VerifierNetwork mean{a.mean, a.scale, {}, {}, {}, 0.5f * (a.b2 + b.b2)};
  mean.w1.resize(units_a + units_b, a.w1.cols());
  mean.w1 << a.w1, b.w1 * a.scale.cwiseQuotient(b.scale).asDiagonal();
  mean.b1.resize(units_a + units_b);
  mean.b1 << a.b1, b.b1 + b.w1 * (a.mean - b.mean).cwiseQuotient(b.scale);
  mean.w2.resize(units_a + units_b);
  mean.w2 << 0.5f * a.w2, 0.5f * b.w2;
  return mean;
}

double AreaUnderRoc(const std::vector<double>& scores, const std::vector<uint8_t>& right) {
  std::vector<size_t> order(scores.size());
  std::iota(order.begin(), order.end(), size_t{0});
  std::sort(order.begin(), order.end(), [&](size_t a, size_t b) { return scores[a] < scores[b]; });
  double pairs = 0, wrong_below = 0;
  for (size_t first = 0; first < order.size();) {
    size_t last = first;
    double ties_right = 0, ties_wrong = 0;
    for (; last < order.size() && scores[order[last]] == scores[order[first]]; ++last) {
      (right[order[last]] ? ties_right : ties_wrong) += 1;
    }
    pairs += ties_right * (wrong_below + 0.5 * ties_wrong);
    wrong_below += ties_wrong;
    first = last;
  }
  const double all_right = static_cast<double>(std::count(right.begin(), right.end(), 1));
  return all_right > 0 && wrong_below > 0 ? pairs / (all_right * wrong_below) : 0.5;
}

}  // namespace pickbed::perception
