#include "perception/training/wohlhart_training.h"

#include <fmt/format.h>
#include <torch/autograd.h>
#include <torch/optim/adam.h>
#include <torch/types.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "perception/model/pose_distance.h"
#include "perception/networks/torch_runtime.h"
#include "perception/networks/wohlhart_layers.h"
#include "perception/training/checkpoint.h"
#include "scenes/base/error.h"
#include "scenes/base/parallel.h"

namespace pickbed::perception {
namespace {

constexpr size_t kLookupChunk = 64;  // anchors looked up in one call
constexpr int kHalves = 2;           // pieces of a batch, processed in parallel

// Hash of everything in the crops that the training uses.
uint64_t HashOf(const CropSet& crops) {
  const auto add = [](const auto& values, uint64_t hash) {
    return HashBytes(values.data(), values.size() * sizeof(values[0]), hash);
  };
  return add(crops.masks, add(crops.color, add(crops.depth, crops.size())));
}

}  // namespace

// A training crop and the templates with which it is compared.
struct CropAnchor {
  ObjectId object{0};
  int row = 0;     // row of training_set.training[object]
  int puller = 0;  // row of the closest template among all templates
  int wrong_pose = 0, wrong_object = 0;
};

class WohlhartTrainer {
 public:
  WohlhartTrainer(const WohlhartJob& job, const WohlhartOptions& options)
      : job_(job),
        options_(options),
        network_(std::make_unique<WohlhartNetwork>(options, job.seed)),
        adam_(network_->impl_->layers->parameters(), torch::optim::AdamOptions()) {
    for (size_t object = 0; object < job.training_set.templates.size(); ++object) {
      const ObjectCrops& of_object = job.training_set.templates[object];
      first_.push_back(static_cast<int>(templates_.size()));
      for (size_t i = 0; i < of_object.crops.size(); ++i) {
        AppendRow(of_object.crops, i, templates_);
        object_of_.push_back(ObjectId(object));
      }
      distances_.emplace_back(job.training_set.objects[object]->symmetries_O);
    }
    iterations_ = options.iterations * static_cast<int>(first_.size());
    for (ObjectId object{0}; object < static_cast<int>(first_.size()); ++object) {
      std::vector<int>& of_object = pullers_.emplace_back();
      const int rows = static_cast<int>(job.training_set.training[object].crops.size());
      for (int row = 0; row < rows; ++row) of_object.push_back(NearestTemplate(object, row));
    }
  }

  std::unique_ptr<WohlhartNetwork> Run();

 private:
  const Eigen::Matrix3d& RotationOf(int row) const {
    return job_.training_set.templates[object_of_[row]].R_CO[row - first_[object_of_[row]]];
  }
  double PoseDistanceOf(const CropAnchor& anchor, int row) const {
    if (object_of_[row] != anchor.object) return kOtherObject;
    return distances_[anchor.object](job_.training_set.training[anchor.object].R_CO[anchor.row],
                                     RotationOf(row));
  }
  int NearestTemplate(ObjectId object, int row) const;
  CropAnchor RandomAnchor(Rng& rng) const;
  std::vector<CropAnchor> MineRound(int round) const;
  CropSet Varied(std::span<const CropAnchor> anchors) const;
  double Step(std::span<const CropAnchor> anchors);
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
  CropSet templates_;                      // of all objects
  std::vector<int> first_;                 // by object: row of its first template
  std::vector<ObjectId> object_of_;        // by template: its object
  std::vector<std::vector<int>> pullers_;  // by object and row of its training crops
  std::vector<RotationDistance> distances_;
  std::vector<double> losses_;
};

int WohlhartTrainer::NearestTemplate(ObjectId object, int row) const {
  CropAnchor anchor;
  anchor.object = object;
  anchor.row = row;
  const int end =
      first_[object] + static_cast<int>(job_.training_set.templates[object].crops.size());
  int nearest = first_[object];
  double min_distance = kOtherObject;
  for (int i = first_[object]; i < end; ++i) {
    const double distance = PoseDistanceOf(anchor, i);
    if (distance >= min_distance) continue;
    min_distance = distance;
    nearest = i;
  }
  return nearest;
}

// Returns a random anchor with random wrong templates.
CropAnchor WohlhartTrainer::RandomAnchor(Rng& rng) const {
  const int object_count = static_cast<int>(first_.size()),
            all = static_cast<int>(templates_.size());
  CropAnchor anchor;
  anchor.object = ObjectId(rng.Index(object_count));
  anchor.row = rng.Index(static_cast<int>(job_.training_set.training[anchor.object].crops.size()));
  anchor.puller = pullers_[anchor.object][anchor.row];
  const int begin = first_[anchor.object];
  const int count = static_cast<int>(job_.training_set.templates[anchor.object].crops.size());
  anchor.wrong_pose = begin + rng.Index(count);
  anchor.wrong_object = object_count > 1 ? (begin + count + rng.Index(all - count)) % all : begin;
  return anchor;
}

// Returns the anchors of all steps until the next round. Their wrong templates are the nearest ones
// in the current descriptor space (section 4.1: bootstrapping); in round 0 they are random.
std::vector<CropAnchor> WohlhartTrainer::MineRound(int round) const {
  constexpr int kNeighbors = 64;  // nearest templates that are searched for wrong ones
  Rng rng = Rng::Derive(job_.seed, round, "wohlhart/round");
  std::vector<CropAnchor> anchors;
  CropSet crops;
  for (int i = 0; i < options_.mine_every * options_.anchors; ++i) {
    anchors.push_back(RandomAnchor(rng));
    AppendRow(job_.training_set.training[anchors.back().object].crops, anchors.back().row, crops);
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
  const int64_t neighbors = std::min<int64_t>(kNeighbors, all.size(0));
  for (size_t begin = 0; begin < anchors.size(); begin += kLookupChunk) {
    const size_t end = std::min(anchors.size(), begin + kLookupChunk);
    const at::Tensor nearest =
        std::get<1>(
            torch::cdist(as_tensor(crop_rows).slice(0, begin, end), all).topk(neighbors, 1, false))
            .contiguous();
    for (size_t i = begin; i < end; ++i) {
      const int64_t* rows = nearest.data_ptr<int64_t>() + (i - begin) * neighbors;
      CropAnchor& anchor = anchors[i];
      const double wrong_from = PoseDistanceOf(anchor, anchor.puller) + options_.min_rotation_rad;
      bool has_pose = false, has_object = false;
      for (int n = 0; n < neighbors && !(has_pose && has_object); ++n) {
        const int row = static_cast<int>(rows[n]);
        const bool other = object_of_[row] != anchor.object;
        if (other ? has_object : has_pose || PoseDistanceOf(anchor, row) <= wrong_from) continue;
        (other ? has_object : has_pose) = true;
        (other ? anchor.wrong_object : anchor.wrong_pose) = row;
      }
    }
  }
  return anchors;
}

// Returns the augmented crops of the anchors. Each crop has its own random stream.
CropSet WohlhartTrainer::Varied(std::span<const CropAnchor> anchors) const {
  const CropTrainingSet& training_set = job_.training_set;
  std::vector<CropSet> varied(anchors.size());
  ForRanges(static_cast<int>(anchors.size()), job_.threads, [&](int begin, int end) {
    for (int i = begin; i < end; ++i) {
      const CropAnchor& anchor = anchors[i];
      Rng rng = Rng::Derive(job_.seed, static_cast<uint64_t>(iteration_) * anchors.size() + i,
                            "wohlhart/crop");
      const int other = rng.Index(static_cast<int>(training_set.training.size()));
      AppendAugmented(training_set.training[anchor.object].crops, anchor.row,
                      training_set.training[other].crops, options_.augment, rng, varied[i]);
    }
  });
  CropSet crops;
  for (const CropSet& one : varied) AppendRow(one, 0, crops);
  return crops;
}

double WohlhartTrainer::Step(std::span<const CropAnchor> anchors) {
  const int64_t count = static_cast<int64_t>(anchors.size());
  CropSet crops = Varied(anchors);
  std::vector<int> rows;  // pullers, wrong poses, wrong objects
  for (const CropAnchor& anchor : anchors) rows.push_back(anchor.puller);
  for (const CropAnchor& anchor : anchors) rows.push_back(anchor.wrong_pose);
  for (const CropAnchor& anchor : anchors) rows.push_back(anchor.wrong_object);
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

// Makes one Adam step on the loss of a batch whose first `count` crops are the anchors. Both halves
// of the batch are evaluated in parallel, forward and backward. The sum of two gradients does not
// depend on their order.
double WohlhartTrainer::Descend(const CropSet& crops, int64_t count,
                                const at::Tensor& pose_distance) {
  WohlhartLayers& layers = *network_->impl_->layers;
  const torch::Device& device = network_->impl_->device;
  const int64_t half = static_cast<int64_t>(crops.size()) / kHalves;
  std::array<at::Tensor, kHalves> described;
  const auto size_of = [&](int h) {
    return h + 1 < kHalves ? half : static_cast<int64_t>(crops.size()) - h * half;
  };
  ForRanges(kHalves, job_.threads, [&](int begin, int end) {
    for (int h = begin; h < end; ++h) {
      described[h] = layers.Forward(WohlhartTensor(crops, h * half, size_of(h), options_, device));
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
                    WriteSettingsKey([&](SettingsVisitor& v) { options.Visit(v); });
  for (size_t object = 0; object < first_.size(); ++object) {
    const CropSet& crops = job_.training_set.training[object].crops;
    key += fmt::format("{} {} {:016x}\n", job_.training_set.objects[object]->name, crops.size(),
                       HashOf(crops));
  }
  return key + fmt::format("{:016x}\n", HashOf(templates_));
}

void WohlhartTrainer::Restore() {
  if (job_.checkpoint.empty() || !std::filesystem::exists(job_.checkpoint)) return;
  const Checkpoint checkpoint = ReadCheckpoint(job_.checkpoint, Key());
  RestoreTrainingStateOf(checkpoint.training_state, *network_->impl_->layers, adam_);
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
    const std::vector<CropAnchor> anchors = MineRound(iteration_ / options_.mine_every);
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
  CheckSettings("WohlhartOptions", options);
  CheckInput(!job.training_set.templates.empty(), "training on crops needs at least one object");
  for (size_t object = 0; object < job.training_set.templates.size(); ++object) {
    CheckInput(
        job.training_set.templates[object].crops.size() > 0 &&
            job.training_set.training[object].crops.size() > 0,
        fmt::format("no training views of object '{}'; raise train_level above template_level",
                    job.training_set.objects[object]->name));
  }
  return WohlhartTrainer(job, options).Run();
}

}  // namespace pickbed::perception
