#include "perception/training/verifier_library.h"

#include <algorithm>

#include "scenes/base/error.h"

namespace pickbed::perception {
namespace {

// Returns the file from which to resume; empty = none.
std::filesystem::path ResumedFile(const VerifierJob& job) {
  const std::filesystem::path unfinished = UnfinishedLibrary(job.file);
  if (!job.resume) return {};
  if (std::filesystem::exists(unfinished)) return unfinished;
  // The stopped training has not finished its network, so the file is from an earlier training.
  if (!job.checkpoint.empty() && std::filesystem::exists(job.checkpoint)) return {};
  return std::filesystem::exists(job.file) ? job.file : std::filesystem::path();
}

// Returns the content of the resumed file, or a new content without objects.
VerifierFile Begin(const VerifierJob& job, const VerifierTrainingOptions& options,
                   const std::filesystem::path& resumed) {
  const std::string training = VerifierTrainingText(job.views, options);
  if (!resumed.empty()) {
    VerifierFile known = LoadVerifiers(resumed, job.estimator);
    CheckInput(known.training == training && known.sensor == job.sensor_profile,
               resumed.string() +
                   ": trained with other settings, another sensor, another bin or an older "
                   "pickbed; do not resume it, or name another file");
    CheckInput(known.network.settings.empty() || known.network.settings == job.network_settings,
               resumed.string() +
                   ": its network was trained for other objects or with other settings; do not "
                   "resume it, or name another file");
    return known;
  }
  return {job.estimator, job.sensor_profile, training, {}, {}, {}};
}

bool Knows(const VerifierFile& file, const ObjectModel& model) {
  return std::any_of(file.objects.begin(), file.objects.end(), [&](const ModelObject& known) {
    return known.name == model.name && known.mesh_hash == model.mesh_hash;
  });
}

// Adds a verifier. It replaces the verifier of an object with the same name and another mesh.
void Put(const ObjectModel& model, const TrainedVerifier& trained, VerifierFile& file) {
  const ModelObject object{model.name, model.mesh_hash, model.diameter_m, 0, trained.auc};
  for (size_t i = 0; i < file.objects.size(); ++i) {
    if (file.objects[i].name != model.name) continue;
    file.objects[i] = object;
    file.verifiers[i] = trained.verifier;
    return;
  }
  file.objects.push_back(object);
  file.verifiers.push_back(trained.verifier);
}

}  // namespace

std::filesystem::path UnfinishedLibrary(const std::filesystem::path& file) {
  return file.string() + ".part";
}

std::string VerifierTrainingText(const LabelledViewSource& views, VerifierTrainingOptions options) {
  return WriteSettingsKey([&](SettingsVisitor& v) { options.Visit(v); }) +
         views.ClutterSceneSettings();
}

VerifierReport TrainVerifierLibrary(const VerifierJob& job,
                                    const VerifierTrainingOptions& options) {
  CheckSettings("VerifierTrainingOptions", options);
  const ObjectSet& objects = job.views.objects();
  CheckInput(!objects.empty(), "training needs at least one object");
  const std::filesystem::path unfinished = UnfinishedLibrary(job.file);
  if (!job.resume) std::filesystem::remove(unfinished);
  std::filesystem::path saved = ResumedFile(job);
  VerifierFile file = Begin(job, options, saved);
  const auto stopped = [&] {
    return VerifierReport{false, saved, static_cast<int>(file.objects.size()), 0};
  };
  if (job.learn && file.network.settings.empty()) {
    std::optional<LearnedNetwork> network = job.learn(
        [&](double share) { return !job.on_progress || job.on_progress("all objects", share); });
    if (!network) return stopped();
    file.network = *std::move(network);
    SaveVerifiers(saved = unfinished, file);
  }
  for (size_t i = 0; i < objects.size(); ++i) {
    const ObjectModel& model = *objects[i];
    if (Knows(file, model)) continue;
    bool go_on = true;
    const auto report = [&](double share) {
      return go_on = !job.on_progress || job.on_progress(model.name, share);
    };
    try {
      constexpr double kScenesShare = 0.1;  // approximate share of the time
      const ObjectId object(i);
      const VerifierTrainingSet training_set =
          VerifierScenes(job.views, object, /*color=*/false, options,
                         [&](double share) { return report(kScenesShare * share); });
      if (!go_on) return stopped();
      const std::unique_ptr<CandidateSource> source = job.candidates({objects[i]}, file.network);
      const CandidateSource* const sources[] = {source.get()};
      const TrainedVerifier trained = TrainObjectVerifier(
          training_set, object, sources, options,
          [&](double share) { return report(kScenesShare + (1 - kScenesShare) * share); });
      if (!go_on) return stopped();
      Put(model, trained, file);
    } catch (const InputError& error) {
      throw InputError("object '" + model.name + "': " + error.what());
    }
    SaveVerifiers(saved = unfinished, file);
  }
  if (saved == unfinished) std::filesystem::rename(unfinished, job.file);
  VerifierReport report{true, job.file, static_cast<int>(file.objects.size()), 0};
  for (const ModelObject& object : file.objects) {
    report.mean_auc += object.verifier_auc / static_cast<double>(file.objects.size());
  }
  return report;
}

}  // namespace pickbed::perception
