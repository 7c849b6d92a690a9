#include "perception/training_start.h"

#include <fmt/format.h>

#include <algorithm>

#include "perception/patch.h"
#include "scenes/check.h"

namespace pickbed {

TrainingStart LoadTrainingStart(const TrainingJob& job, const TrainingOptions& options) {
  const ObjectSet& objects = job.views.objects();
  TrainingStart start;
  start.known.assign(objects.size(), -1);
  if (job.start_from.empty()) return start;
  start.model = LoadModel(job.start_from);
  const ModelInfo& info = start.model->info;
  CheckInput(info.network.kind == options.network.kind &&
                 info.network.descriptor == options.network.descriptor,
             fmt::format("{}: its network is {} with descriptors of {}, not {} with {}; set "
                         "network.kind and network.descriptor to those",
                         job.start_from.string(), info.network.kind, info.network.descriptor,
                         options.network.kind, options.network.descriptor));
  CheckInput(start.model->network.channels() == ChannelsOf(options.network),
             fmt::format("{}: its network learned from {}, not from {}; set "
                         "network.autoencoder.channels to what it learned from",
                         job.start_from.string(), NameOf(start.model->network.channels()),
                         NameOf(ChannelsOf(options.network))));
  // Its last layer has rows for the parts that it was made for, in their order.
  const bool grows = start.model->network.regresses() && info.objects.size() != objects.size();
  CheckInput(!grows, fmt::format("{}: a network that regresses poses learns no parts later; train "
                                 "it on all of them at once, without --from",
                                 job.start_from.string()));
  for (size_t part = 0; part < objects.size(); ++part) {
    for (size_t i = 0; i < info.objects.size(); ++i) {
      if (info.objects[i].name != objects[part]->name) continue;
      if (info.objects[i].mesh_hash == objects[part]->mesh_hash) start.known[part] = i;
    }
  }
  const auto is_known = [](int index) { return index >= 0; };
  start.rehearses = std::any_of(start.known.begin(), start.known.end(), is_known) &&
                    !std::all_of(start.known.begin(), start.known.end(), is_known);
  return start;
}

std::vector<double> PartWeights(const TrainingStart& start, const TrainingOptions& options) {
  std::vector<double> weights(start.known.size(), 1);
  for (size_t part = 0; part < weights.size(); ++part) {
    if (start.IsRehearsed(part)) weights[part] = options.rehearsal;
  }
  return weights;
}

std::vector<double> StartSides(const ObjectSet& objects, const TrainingStart& start,
                               const TrainingOptions& options) {
  std::vector<double> sides;
  for (size_t part = 0; part < objects.size(); ++part) {
    sides.push_back(start.known[part] >= 0
                        ? start.model->info.objects[start.known[part]].side_m
                        : PatchSide(objects[part]->diameter_m, options.patch_diameters));
  }
  return sides;
}

std::string CheckpointKey(const LabelledViewSource& views, TrainingOptions options,
                          const std::string& sensor, uint64_t start_hash) {
  options.max_minutes = 0;
  options.checkpoint_every = TrainingOptions{}.checkpoint_every;
  std::string key = WriteSettings([&](SettingsVisitor& v) { options.Visit(v); });
  key += fmt::format("sensor {}\nfrom {:016x}", sensor, start_hash);
  key += fmt::format("\n{}", views.PileSettings());
  for (const auto& object : views.objects()) {
    key += fmt::format("\n{} {:016x}", object->name, object->mesh_hash);
  }
  return key;
}

}  // namespace pickbed
