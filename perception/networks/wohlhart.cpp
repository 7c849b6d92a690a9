#include "perception/networks/wohlhart.h"

#include <fmt/format.h>
#include <torch/torch.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "perception/checkpoint.h"
#include "perception/rotation_distance.h"
#include "perception/torch_device.h"
#include "perception/torch_weights.h"
#include "scenes/check.h"
#include "scenes/parallel.h"

namespace pickbed {
namespace {

constexpr int64_t kChunk = 64;  // crops described in one call; more does not fit the caches
constexpr int kHalves = 2;      // of a batch in training, one a thread

int Channels(const WohlhartOptions& options) {
  return options.input == "depth" ? 1 : options.input == "rgb" ? 3 : 4;
}

// Section 3.2: conv 16 of 8x8 - pool - ReLU - conv 7 of 5x5 - pool - ReLU - full 256 - ReLU - full
// D. The descriptor is not normalised. 269,335 weights for RGB-D and D = 16.
struct Layers : torch::nn::Module {
  explicit Layers(const WohlhartOptions& options) {
    using torch::nn::Conv2dOptions;
    first = register_module("first", torch::nn::Conv2d(Conv2dOptions(Channels(options), 16, 8)));
    second = register_module("second", torch::nn::Conv2d(Conv2dOptions(16, 7, 5)));
    const int side = ((kCropPixels - 7) / 2 - 4) / 2;
    hidden = register_module("hidden", torch::nn::Linear(7 * side * side, 256));
    last = register_module("last", torch::nn::Linear(256, options.descriptor));
  }
  at::Tensor Forward(const at::Tensor& crops) {
    at::Tensor x = torch::relu(torch::max_pool2d(first(crops), 2));
    x = torch::relu(torch::max_pool2d(second(x), 2));
    return last(torch::relu(hidden(x.flatten(1))));
  }
  torch::nn::Conv2d first{nullptr}, second{nullptr};
  torch::nn::Linear hidden{nullptr}, last{nullptr};
};

// Depth over the reach, in [-1, 1]; colour / 255 - 0.5 as in the released code, 0 beyond the reach.
// count x channels x 64 x 64.
at::Tensor ToTensor(const CropSet& crops, int64_t begin, int64_t count,
                    const WohlhartOptions& options, const torch::Device& device) {
  const int channels = Channels(options);
  const bool has_depth = channels != 3;
  std::vector<float> values(count * kCropArea * channels);
  float* next = values.data();
  for (int64_t pixel = begin * kCropArea; pixel < (begin + count) * kCropArea; ++pixel) {
    const double depth = crops.depth[pixel] / (options.depth_reach * kCropDepthUnit);
    if (has_depth) *next++ = static_cast<float>(std::clamp(depth, -1.0, 1.0));
    if (channels == 1) continue;
    const bool is_seen = !has_depth || std::abs(depth) < 1;
    for (const uint8_t value : {crops.color[pixel].r, crops.color[pixel].g, crops.color[pixel].b}) {
      *next++ = is_seen ? static_cast<float>(value) / 255.0f - 0.5f : 0;
    }
  }
  // Pixel by pixel is what oneDNN's convolutions of few channels are fastest with.
  return torch::from_blob(values.data(), {count, kCropPixels, kCropPixels, channels}, torch::kFloat)
      .clone()
      .permute({0, 3, 1, 2})
      .to(device);
}

// Of all that a network may learn from them.
uint64_t HashOf(const CropSet& crops) {
  const auto add = [](const auto& values, uint64_t hash) {
    return HashBytes(values.data(), values.size() * sizeof(values[0]), hash);
  };
  return add(crops.masks, add(crops.color, add(crops.depth, crops.size())));
}

// From the differences: a matrix product would lose the small distances of rows that lie far from
// zero. The slope at zero is 0.
at::Tensor Distances(const at::Tensor& a, const at::Tensor& b) {
  constexpr int64_t kNoMatrixProduct = 2;
  return torch::cdist(a, b, 2.0, kNoMatrixProduct);
}

}  // namespace

void WohlhartOptions::Visit(SettingsVisitor& v) {
  v.Text("input", input, {"depth", "rgb", "rgbd"}, "what the network sees");
  v.Integer("descriptor", descriptor, {2, 1024}, "length of the descriptor");
  v.Real("depth_reach", depth_reach, {0.1, 1}, "seen about the centre both ways, over the side");
  v.Real("margin", margin, {1e-6, 10}, "m of the triplet term");
  v.Bool("dynamic_margin", dynamic_margin, "m by the angle between the poses (Zakharov 2017)");
  v.Real("class_margin", class_margin, {std::numbers::pi, 100}, "of another part then");
  v.Real("least_turn_rad", least_turn_rad, {0, std::numbers::pi}, "pusher beyond puller, rad");
  v.Integer("pushers", pushers, {1, 10000}, "hardest templates of the batch for one anchor");
  v.Real("pair_weight", pair_weight, {0, 100}, "of the pair term");
  v.Real("weight_decay", weight_decay, {0, 1}, "lambda of |w|^2");
  v.Integer("anchors", anchors, {2, 10000}, "crops of a batch, with three templates each");
  v.Integer("iterations", iterations, {1, 1000000}, "steps a part");
  v.Integer("mine_every", mine_every, {1, 1000000}, "steps between two rounds of mining");
  v.Real("learning_rate", learning_rate, {1e-7, 1}, "of Adam, at the start of the cosine");
  v.Group(
      "augment", [&](SettingsVisitor& g) { augment.Visit(g); }, "how crops are varied");
}

at::Tensor WohlhartLoss(const at::Tensor& anchors, const at::Tensor& templates,
                        const at::Tensor& puller, const at::Tensor& pose_distance,
                        const WohlhartOptions& options) {
  const at::Tensor plain = Distances(anchors, templates);
  // Zakharov 2017, eq. 2, squares distances; the released code of 2015 does not.
  const at::Tensor distance = options.dynamic_margin ? plain.square() : plain;
  const at::Tensor column = puller.unsqueeze(1);
  const at::Tensor near = distance.gather(1, column);
  const at::Tensor is_other = pose_distance >= kOtherPart;
  const at::Tensor margin = options.dynamic_margin
                                ? pose_distance.masked_fill(is_other, options.class_margin)
                                : torch::full_like(pose_distance, options.margin);
  const at::Tensor no_pusher =
      pose_distance <= pose_distance.gather(1, column) + options.least_turn_rad;
  // Eq. 2: max(0, 1 - |f_i - f_k| / (|f_i - f_j| + m)).
  const at::Tensor hinge = torch::relu(1 - distance / (near + margin)).masked_fill(no_pusher, 0.0);
  const int64_t kept = std::min<int64_t>(options.pushers, hinge.size(1));
  // Eq. 3: |f_i - f_j|.
  return std::get<0>(hinge.topk(kept, 1)).mean() + options.pair_weight * near.mean();
}

struct WohlhartNetwork::Impl {
  Impl(const WohlhartOptions& options, uint64_t seed) : options(options), device(NetworkDevice()) {
    at::set_num_threads(1);
    torch::manual_seed(seed);
    layers = std::make_shared<Layers>(options);
    layers->to(device);
  }
  WohlhartOptions options;
  torch::Device device;
  std::shared_ptr<Layers> layers;
};

WohlhartNetwork::WohlhartNetwork(const WohlhartOptions& options, uint64_t seed)
    : impl_(std::make_unique<Impl>(options, seed)) {}
WohlhartNetwork::~WohlhartNetwork() = default;
WohlhartNetwork::WohlhartNetwork(WohlhartNetwork&&) noexcept = default;

int WohlhartNetwork::length() const { return impl_->options.descriptor; }

int64_t WohlhartNetwork::weights() const { return static_cast<int64_t>(Weights().size()); }

std::vector<float> WohlhartNetwork::Weights() const { return WeightsOf(*impl_->layers); }

void WohlhartNetwork::SetWeights(std::span<const float> weights) {
  SetWeightsOf(*impl_->layers, weights);
}

std::vector<float> WohlhartNetwork::Describe(const CropSet& crops, int threads) const {
  const int64_t count = static_cast<int64_t>(crops.size());
  std::vector<float> rows(count * length());
  const int chunks = static_cast<int>((count + kChunk - 1) / kChunk);
  ForRanges(chunks, threads, [&](int begin, int end) {
    const torch::InferenceMode no_gradients;  // of this thread
    for (int64_t first = begin * kChunk; first < std::min(count, end * kChunk); first += kChunk) {
      const int64_t size = std::min(kChunk, count - first);
      const at::Tensor values =
          impl_->layers->Forward(ToTensor(crops, first, size, impl_->options, impl_->device))
              .cpu()
              .contiguous();
      std::copy_n(values.data_ptr<float>(), values.numel(), rows.begin() + first * length());
    }
  });
  return rows;
}

// A crop to learn from, with the templates that it is compared with.
struct Anchor {
  int object = 0;
  int row = 0;     // of lesson.training[object]
  int puller = 0;  // the closest template, a row of all templates
  int wrong_pose = 0, wrong_part = 0;
};

class WohlhartTrainer {
 public:
  WohlhartTrainer(const WohlhartJob& job, const WohlhartOptions& options)
      : job_(job),
        options_(options),
        network_(std::make_unique<WohlhartNetwork>(options, job.seed)),
        adam_(network_->impl_->layers->parameters(), torch::optim::AdamOptions()) {
    for (size_t part = 0; part < job.lesson.templates.size(); ++part) {
      const ObjectCrops& of_part = job.lesson.templates[part];
      first_.push_back(static_cast<int>(templates_.size()));
      for (size_t i = 0; i < of_part.crops.size(); ++i) {
        AppendRow(of_part.crops, i, templates_);
        part_of_.push_back(static_cast<int>(part));
      }
      distances_.emplace_back(job.lesson.objects[part]->symmetries_O);
    }
    iterations_ = options.iterations * static_cast<int>(first_.size());
    for (int part = 0; part < static_cast<int>(first_.size()); ++part) {
      std::vector<int>& of_part = pullers_.emplace_back();
      const int rows = static_cast<int>(job.lesson.training[part].crops.size());
      for (int row = 0; row < rows; ++row) of_part.push_back(NearestTemplate(part, row));
    }
  }

  std::unique_ptr<WohlhartNetwork> Run();

 private:
  const Eigen::Matrix3d& RotationOf(int row) const {
    return job_.lesson.templates[part_of_[row]].R_CO[row - first_[part_of_[row]]];
  }
  double PoseDistanceOf(const Anchor& anchor, int row) const {
    if (part_of_[row] != anchor.object) return kOtherPart;
    return distances_[anchor.object](job_.lesson.training[anchor.object].R_CO[anchor.row],
                                     RotationOf(row));
  }
  int NearestTemplate(int part, int row) const;
  Anchor RandomAnchor(Rng& rng) const;
  std::vector<Anchor> MineRound(int round) const;
  CropSet Varied(std::span<const Anchor> anchors) const;
  double Step(std::span<const Anchor> anchors);
  double Descend(const CropSet& crops, int64_t count, const at::Tensor& pose_distance);
  std::string Key() const;
  void Restore();
  void Save() const;

  const WohlhartJob& job_;
  WohlhartOptions options_;
  std::unique_ptr<WohlhartNetwork> network_;
  torch::optim::Adam adam_;
  int iterations_ = 0;
  int iteration_ = 0;
  CropSet templates_;                      // of all parts
  std::vector<int> first_;                 // row of each part's first template
  std::vector<int> part_of_;               // of each template
  std::vector<std::vector<int>> pullers_;  // by part and row of its training
  std::vector<RotationDistance> distances_;
  std::vector<double> losses_;
};

int WohlhartTrainer::NearestTemplate(int part, int row) const {
  Anchor anchor;
  anchor.object = part;
  anchor.row = row;
  const int end = first_[part] + static_cast<int>(job_.lesson.templates[part].crops.size());
  int nearest = first_[part];
  double least = kOtherPart;
  for (int i = first_[part]; i < end; ++i) {
    const double distance = PoseDistanceOf(anchor, i);
    if (distance >= least) continue;
    least = distance;
    nearest = i;
  }
  return nearest;
}

// With random wrong templates.
Anchor WohlhartTrainer::RandomAnchor(Rng& rng) const {
  const int parts = static_cast<int>(first_.size()), all = static_cast<int>(templates_.size());
  Anchor anchor;
  anchor.object = rng.Index(parts);
  anchor.row = rng.Index(static_cast<int>(job_.lesson.training[anchor.object].crops.size()));
  anchor.puller = pullers_[anchor.object][anchor.row];
  const int begin = first_[anchor.object];
  const int count = static_cast<int>(job_.lesson.templates[anchor.object].crops.size());
  anchor.wrong_pose = begin + rng.Index(count);
  anchor.wrong_part = parts > 1 ? (begin + count + rng.Index(all - count)) % all : begin;
  return anchor;
}

// The anchors of the steps until the next round, with the nearest wrong templates by the network as
// it is (section 4.1: bootstrapping).
std::vector<Anchor> WohlhartTrainer::MineRound(int round) const {
  constexpr int kLooked = 64;  // nearest templates among which the wrong ones are looked for
  Rng rng = Rng::Derive(job_.seed, round, "wohlhart/round");
  std::vector<Anchor> anchors;
  CropSet crops;
  for (int i = 0; i < options_.mine_every * options_.anchors; ++i) {
    anchors.push_back(RandomAnchor(rng));
    AppendRow(job_.lesson.training[anchors.back().object].crops, anchors.back().row, crops);
  }
  if (round == 0) return anchors;
  const auto as_tensor = [&](std::vector<float>& rows) {
    const int64_t length = network_->length();
    return torch::from_blob(rows.data(), {static_cast<int64_t>(rows.size()) / length, length},
                            torch::kFloat);
  };
  std::vector<float> template_rows = network_->Describe(templates_, job_.threads);
  std::vector<float> crop_rows = network_->Describe(crops, job_.threads);
  const at::Tensor all = as_tensor(template_rows);
  const int64_t looked = std::min<int64_t>(kLooked, all.size(0));
  for (size_t begin = 0; begin < anchors.size(); begin += kChunk) {
    const size_t end = std::min(anchors.size(), begin + kChunk);
    const at::Tensor nearest =
        std::get<1>(
            torch::cdist(as_tensor(crop_rows).slice(0, begin, end), all).topk(looked, 1, false))
            .contiguous();
    for (size_t i = begin; i < end; ++i) {
      const int64_t* rows = nearest.data_ptr<int64_t>() + (i - begin) * looked;
      Anchor& anchor = anchors[i];
      const double wrong_from = PoseDistanceOf(anchor, anchor.puller) + options_.least_turn_rad;
      bool has_pose = false, has_part = false;
      for (int n = 0; n < looked && !(has_pose && has_part); ++n) {
        const int row = static_cast<int>(rows[n]);
        const bool other = part_of_[row] != anchor.object;
        if (other ? has_part : has_pose || PoseDistanceOf(anchor, row) <= wrong_from) continue;
        (other ? has_part : has_pose) = true;
        (other ? anchor.wrong_part : anchor.wrong_pose) = row;
      }
    }
  }
  return anchors;
}

// The crops to learn from, each varied with chance of its own.
CropSet WohlhartTrainer::Varied(std::span<const Anchor> anchors) const {
  const CropLesson& lesson = job_.lesson;
  std::vector<CropSet> varied(anchors.size());
  ForRanges(static_cast<int>(anchors.size()), job_.threads, [&](int begin, int end) {
    for (int i = begin; i < end; ++i) {
      const Anchor& anchor = anchors[i];
      Rng rng = Rng::Derive(job_.seed, static_cast<uint64_t>(iteration_) * anchors.size() + i,
                            "wohlhart/crop");
      const int other = rng.Index(static_cast<int>(lesson.training.size()));
      AppendAugmented(lesson.training[anchor.object].crops, anchor.row,
                      lesson.training[other].crops, options_.augment, rng, varied[i]);
    }
  });
  CropSet crops;
  for (const CropSet& one : varied) AppendRow(one, 0, crops);
  return crops;
}

double WohlhartTrainer::Step(std::span<const Anchor> anchors) {
  const int64_t count = static_cast<int64_t>(anchors.size());
  CropSet crops = Varied(anchors);
  std::vector<int> rows;  // pullers, wrong poses, wrong parts
  for (const Anchor& anchor : anchors) rows.push_back(anchor.puller);
  for (const Anchor& anchor : anchors) rows.push_back(anchor.wrong_pose);
  for (const Anchor& anchor : anchors) rows.push_back(anchor.wrong_part);
  for (const int row : rows) AppendRow(templates_, row, crops);
  const int64_t columns = static_cast<int64_t>(rows.size());
  std::vector<float> distances(count * columns);
  ForRanges(static_cast<int>(count), job_.threads, [&](int begin, int end) {
    for (int i = begin; i < end; ++i) {
      for (int64_t k = 0; k < columns; ++k) {
        distances[i * columns + k] = static_cast<float>(PoseDistanceOf(anchors[i], rows[k]));
      }
    }
  });
  const torch::Device& device = network_->impl_->device;
  const at::Tensor pose_distance =
      torch::from_blob(distances.data(), {count, columns}, torch::kFloat).to(device);
  return Descend(crops, count, pose_distance);
}

// One step of Adam down the loss of a batch whose first `count` crops are the anchors. Halves of it
// are described, and their gradients found, side by side; their sum is the same in either order.
double WohlhartTrainer::Descend(const CropSet& crops, int64_t count,
                                const at::Tensor& pose_distance) {
  Layers& layers = *network_->impl_->layers;
  const torch::Device& device = network_->impl_->device;
  const int64_t half = static_cast<int64_t>(crops.size()) / kHalves;
  std::array<at::Tensor, kHalves> described;
  const auto size_of = [&](int h) {
    return h + 1 < kHalves ? half : static_cast<int64_t>(crops.size()) - h * half;
  };
  ForRanges(kHalves, job_.threads, [&](int begin, int end) {
    for (int h = begin; h < end; ++h) {
      described[h] = layers.Forward(ToTensor(crops, h * half, size_of(h), options_, device));
    }
  });
  at::Tensor all = torch::cat({described[0].detach(), described[1].detach()});
  all.requires_grad_();
  const at::Tensor loss =
      WohlhartLoss(all.slice(0, 0, count), all.slice(0, count),
                   torch::arange(count, torch::TensorOptions(torch::kLong).device(device)),
                   pose_distance, options_);
  loss.backward();
  std::vector<at::Tensor> weights = layers.parameters();
  std::array<std::vector<at::Tensor>, kHalves> slopes;
  ForRanges(kHalves, job_.threads, [&](int begin, int end) {
    for (int h = begin; h < end; ++h) {
      slopes[h] = torch::autograd::grad({described[h]}, weights,
                                        {all.grad().slice(0, h * half, h * half + size_of(h))});
    }
  });
  for (size_t w = 0; w < weights.size(); ++w) {
    // Eq. 1: lambda |w|^2.
    weights[w].mutable_grad() =
        slopes[0][w] + slopes[1][w] + 2 * options_.weight_decay * weights[w].detach();
  }
  const double share = static_cast<double>(iteration_) / iterations_;
  SetLearningRate(adam_, 0.5 * options_.learning_rate * (1 + std::cos(std::numbers::pi * share)));
  adam_.step();
  return loss.item<double>();
}

std::string WohlhartTrainer::Key() const {
  WohlhartOptions options = options_;
  std::string key = fmt::format("wohlhart {}\n", job_.seed) +
                    WriteSettings([&](SettingsVisitor& v) { options.Visit(v); });
  for (size_t part = 0; part < first_.size(); ++part) {
    const CropSet& crops = job_.lesson.training[part].crops;
    key += fmt::format("{} {} {:016x}\n", job_.lesson.objects[part]->name, crops.size(),
                       HashOf(crops));
  }
  return key + fmt::format("{:016x}\n", HashOf(templates_));
}

void WohlhartTrainer::Restore() {
  if (job_.checkpoint.empty() || !std::filesystem::exists(job_.checkpoint)) return;
  const Checkpoint checkpoint = ReadCheckpoint(job_.checkpoint, Key());
  RestoreTrainingStateOf(checkpoint.training_state, network_->impl_->device,
                         *network_->impl_->layers, adam_);
  iteration_ = checkpoint.iteration;
  losses_ = checkpoint.loss_history;
}

void WohlhartTrainer::Save() const {
  if (job_.checkpoint.empty()) return;
  Checkpoint checkpoint;
  checkpoint.key = Key();
  checkpoint.iteration = iteration_;
  checkpoint.loss_history = losses_;
  checkpoint.recall_history = {};
  checkpoint.training_state = TrainingStateOf(*network_->impl_->layers, adam_);
  WriteCheckpoint(job_.checkpoint, checkpoint);
}

std::unique_ptr<WohlhartNetwork> WohlhartTrainer::Run() {
  Restore();
  while (iteration_ < iterations_) {
    const std::vector<Anchor> anchors = MineRound(iteration_ / options_.mine_every);
    for (int step = 0; step < options_.mine_every && iteration_ < iterations_; ++step) {
      losses_.push_back(
          Step(std::span(anchors).subspan(step * options_.anchors, options_.anchors)));
      ++iteration_;
      const double share = static_cast<double>(iteration_) / iterations_;
      if (job_.on_progress && !job_.on_progress(share, losses_.back())) return nullptr;
    }
    Save();
  }
  return std::move(network_);
}

std::unique_ptr<WohlhartNetwork> TrainWohlhart(const WohlhartJob& job,
                                               const WohlhartOptions& options) {
  CheckInput(!job.lesson.templates.empty(), "learning crops needs at least one part");
  for (size_t part = 0; part < job.lesson.templates.size(); ++part) {
    CheckInput(
        job.lesson.templates[part].crops.size() > 0 && job.lesson.training[part].crops.size() > 0,
        fmt::format("no views of part '{}' to learn from; raise train_level above "
                    "template_level",
                    job.lesson.objects[part]->name));
  }
  return WohlhartTrainer(job, options).Run();
}

}  // namespace pickbed
