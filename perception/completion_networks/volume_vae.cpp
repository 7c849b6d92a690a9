#include <torch/nn/modules/linear.h>

#include <algorithm>
#include <cmath>

#include "perception/completion_networks/completion_net.h"
#include "perception/completion_networks/volume_blocks.h"
#include "perception/networks/fixed_layers.h"

namespace pickbed::perception {
namespace {

// Channels of CompletionInput.
constexpr int64_t kSeenSurface = 1, kKnownEmpty = 2;
constexpr uint64_t kSampleSeed = 7;    // of a completion
constexpr double kNotObserved = 0.5;   // value of such a cell
constexpr float kLogitMargin = 1e-4f;  // probabilities stay this far from 0 and 1

// Standard normal values, drawn on the CPU so that they are the same on every device.
at::Tensor Normal(at::IntArrayRef shape, uint64_t seed, const torch::Device& device) {
  const at::Generator generator = at::detail::createCPUGenerator(seed);
  return at::randn(shape, generator).to(device);
}

// Standard normal values of a row that are also the same on every CPU. libtorch draws less than 16
// values one by one, and more values with functions for the vector width of the CPU.
at::Tensor FixedNormalRow(int64_t size, uint64_t seed, const torch::Device& device) {
  constexpr int64_t kOneByOne = 8;
  const at::Generator generator = at::detail::createCPUGenerator(seed);
  at::Tensor values = torch::empty({size});
  for (at::Tensor& some : values.split(kOneByOne)) {
    some.copy_(at::randn(some.sizes(), generator));
  }
  return values.unsqueeze(0).to(device);
}

// Returns the log odds of probabilities, which stay kLogitMargin away from 0 and 1.
at::Tensor LogOdds(const at::Tensor& probabilities) {
  at::Tensor values = probabilities.cpu().contiguous().clone();
  float* const plain = values.data_ptr<float>();
  std::transform(plain, plain + values.numel(), plain, [](float value) {
    const float p = std::clamp(value, kLogitMargin, 1 - kLogitMargin);
    return std::log(p / (1 - p));
  });
  return values.to(probabilities.device());
}

at::Tensor Flipped(at::Tensor x, int turn) {
  if (turn & 1) x = x.flip(-1);
  if (turn & 2) x = x.flip(-2);
  return x;
}

// Turns a volume (... x z x y x x) as TurnChannels() does, and back.
at::Tensor Turned(const at::Tensor& x, int turn) {
  const at::Tensor flipped = Flipped(x, turn);
  return turn & 4 ? flipped.transpose(-1, -2) : flipped;
}
at::Tensor TurnedBack(const at::Tensor& x, int turn) {
  return Flipped(turn & 4 ? x.transpose(-1, -2) : x, turn);
}

// Returns the turn that aligns a view: the seen surface is longer along x than along y, and its
// long tails are at positive coordinates. `surface` is z x y x x.
int AligningTurn(const at::Tensor& surface) {
  const at::Tensor at_yx = surface.sum(0).to(torch::kDouble).cpu();
  const auto moments = [&](const at::Tensor& cells) {
    const at::Tensor plain = cells.contiguous();  // whole numbers, so that their sum is exact
    const double* const weight = plain.data_ptr<double>();
    const double total = std::max(plain.sum().item<double>(), 1.0);
    double mean = 0, spread = 0, skew = 0;
    for (int64_t i = 0; i < kInputCells; ++i) mean += weight[i] / total * static_cast<double>(i);
    for (int64_t i = 0; i < kInputCells; ++i) {
      const double off = static_cast<double>(i) - mean, share = weight[i] / total;
      spread += share * off * off;
      skew += share * off * off * off;
    }
    return std::pair(spread, skew);
  };
  const auto [spread_x, skew_x] = moments(at_yx.sum(0));
  const auto [spread_y, skew_y] = moments(at_yx.sum(1));
  return (skew_x < 0 ? 1 : 0) + (skew_y < 0 ? 2 : 0) + (spread_y > spread_x ? 4 : 0);
}

// Space to depth and back, 2 x 2 x 2 cells.
at::Tensor Packed(const at::Tensor& x) {
  const int64_t n = x.size(0), half = x.size(4) / 2;
  return x.view({n, 1, half, 2, half, 2, half, 2})
      .permute({0, 1, 3, 5, 7, 2, 4, 6})
      .reshape({n, 8, half, half, half});
}
at::Tensor Unpacked(const at::Tensor& x) {
  const int64_t n = x.size(0), half = x.size(4);
  return x.view({n, 1, 2, 2, 2, half, half, half})
      .permute({0, 1, 5, 2, 6, 3, 7, 4})
      .reshape({n, 1, 2 * half, 2 * half, 2 * half});
}

struct Observed {
  at::Tensor known;  // n x 1 x 32^3, 1 = observed
  at::Tensor value;  // 1 = seen surface, 0 = known to be empty
};

Observed ObservedIn(const at::Tensor& channels) {
  const at::Tensor surface = (channels.narrow(1, kSeenSurface, 1) > 0.5).to(torch::kFloat);
  const at::Tensor empty = (channels.narrow(1, kKnownEmpty, 1) > 0.5).to(torch::kFloat);
  return {torch::maximum(surface, empty), surface};
}

// Clamps the observed cells.
at::Tensor Clamped(const Observed& seen, const at::Tensor& volume) {
  return seen.known * seen.value + (1 - seen.known) * volume;
}

struct VolumeVae : CompletionNet {
  explicit VolumeVae(const CompletionNetworkOptions& o)
      : rounds(o.rounds), width_4(o.width_4), latent(o.bottleneck) {
    const auto add = [&](const char* name, int64_t in, int64_t out, int64_t stride) {
      return register_module(name, std::make_shared<VolumeBlock>(in, out, 3, stride));
    };
    const int64_t flat = 64 * static_cast<int64_t>(o.width_4);
    at_16 = add("at_16", 8, o.width_16, 1);
    down_8 = add("down_8", o.width_16, o.width_8, 2);
    down_4 = add("down_4", o.width_8, o.width_4, 2);
    code = register_module("code", torch::nn::Linear(flat, 2 * latent));
    expand = register_module("expand", torch::nn::Linear(latent, flat));
    up_4 = add("up_4", o.width_4, o.width_4, 1);
    up_8 = add("up_8", o.width_4, o.width_8, 1);
    up_16 = add("up_16", o.width_8, o.width_16, 1);
    last = register_module(
        "last", torch::nn::Conv3d(torch::nn::Conv3dOptions(o.width_16, 8, 3).padding(1)));
  }

  // Returns mean and logarithm of the variance of the code, each n x latent.
  std::pair<at::Tensor, at::Tensor> Code(const at::Tensor& volume) {
    const at::Tensor x =
        down_4->forward(down_8->forward(at_16->forward(Packed(volume)))).flatten(1);
    const std::vector<at::Tensor> halves = ApplyLinear(code, x).chunk(2, 1);
    return {halves[0], halves[1].clamp(-10, 10)};
  }
  // Returns logits, n x 1 x 32^3.
  at::Tensor Volume(const at::Tensor& z) {
    const at::Tensor x = torch::relu(ApplyLinear(expand, z)).view({z.size(0), width_4, 4, 4, 4});
    const at::Tensor y = up_8->forward(DoubledSize(up_4->forward(x)));
    return Unpacked(ApplyConvolution(last, up_16->forward(DoubledSize(y))));
  }

  // Reconstructs, samples and clamps. The result is the mean of the second half of the rounds, as
  // logits: n x 1 x 32^3.
  CompletionCode Encode(const CompletionViews& views) override {
    const at::Tensor& channels = views.channels;
    const int64_t n = channels.size(0);
    std::vector<int> turns;
    std::vector<at::Tensor> aligned;
    for (int64_t i = 0; i < n; ++i) {
      turns.push_back(AligningTurn(channels[i][kSeenSurface]));
      aligned.push_back(Turned(channels[i], turns.back()));
    }
    const Observed seen = ObservedIn(torch::stack(aligned).contiguous());
    at::Tensor x = Clamped(seen, torch::full_like(seen.value, kNotObserved));
    at::Tensor sum = torch::zeros_like(x);
    int added = 0;
    for (int round = 0; round < rounds; ++round) {
      const auto [mean, log_variance] = Code(x);
      const at::Tensor noise = FixedNormalRow(latent, kSampleSeed + round, channels.device());
      x = Clamped(seen, ApplyLogistic(Volume(mean + ApplyExponential(0.5 * log_variance) * noise)));
      if (2 * (round + 1) <= rounds) continue;
      sum += x;
      ++added;
    }
    const at::Tensor logits = LogOdds(sum / added);
    std::vector<at::Tensor> volumes;
    for (int64_t i = 0; i < n; ++i) volumes.push_back(TurnedBack(logits[i], turns[i]));
    return {torch::stack(volumes).contiguous(), {}};
  }

  at::Tensor Decode(const CompletionCode& view_code, const at::Tensor& queries) override {
    return SampledCode(view_code.volume, queries.slice(2, 0, 3)).squeeze(2);
  }

  // Evidence lower bound over the number of cells. The input of half of the samples is the true
  // volume. In the others the cells that were not observed are a mixture of truth and unknown, as
  // in the rounds of a completion.
  at::Tensor Loss(const CompletionTensors& step) override {
    const int64_t n = step.volumes.size(0);
    std::vector<at::Tensor> channels, volumes;
    for (int64_t i = 0; i < n; ++i) {
      const at::Tensor own = step.views.channels[i];
      const int turn = AligningTurn(own[kSeenSurface]);
      channels.push_back(Turned(own, turn));
      volumes.push_back(Turned(step.volumes[i], turn));
    }
    const at::Tensor truth = torch::stack(volumes).contiguous();
    const Observed seen = ObservedIn(torch::stack(channels).contiguous());
    const torch::Device device = truth.device();
    at::Tensor share = Normal({n, 1, 1, 1, 1}, step.seed, device).abs().clamp_max(1);
    share = torch::where(
        torch::arange(step.first, step.first + n).to(device).view({n, 1, 1, 1, 1}) % 2 == 0,
        torch::ones_like(share), share);
    const at::Tensor mixed = share * truth + (1 - share) * kNotObserved;
    const at::Tensor input = torch::where(share >= 1, truth, Clamped(seen, mixed));
    const auto [mean, log_variance] = Code(input);
    const at::Tensor noise = Normal({n, latent}, step.seed + 1, device);
    const at::Tensor logits = Volume(mean + torch::exp(0.5 * log_variance) * noise);
    const at::Tensor divergence =
        0.5 * (mean.pow(2) + log_variance.exp() - 1 - log_variance).sum(1).mean();
    return torch::binary_cross_entropy_with_logits(logits, truth) +
           divergence / static_cast<double>(kInputVolume);
  }

  int rounds;
  int64_t width_4, latent;
  std::shared_ptr<VolumeBlock> at_16, down_8, down_4, up_4, up_8, up_16;
  torch::nn::Linear code{nullptr}, expand{nullptr};
  torch::nn::Conv3d last{nullptr};
};

}  // namespace

std::shared_ptr<CompletionNet> MakeVolumeVae(const CompletionNetworkOptions& options) {
  return std::make_shared<VolumeVae>(options);
}

}  // namespace pickbed::perception
