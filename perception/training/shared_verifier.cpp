#include "perception/training/shared_verifier.h"

#include <fmt/format.h>

#include <algorithm>

#include "perception/networks/model_file.h"
#include "perception/networks/tensor_file.h"
#include "perception/networks/verifier_file.h"
#include "scenes/base/error.h"
#include "scenes/base/files.h"
#include "scenes/base/random.h"

namespace pickbed::perception {
namespace {

constexpr const char* kFileKind = "shared verifier";
constexpr const char* kUnfinishedKind = "unfinished shared verifier";
constexpr int kFileVersion = 1;

// Everything that the candidates depend on.
std::string SettingsText(const SharedVerifierJob& job, const VerifierTrainingOptions& options,
                         uint64_t model_hash) {
  VerifierTrainingOptions visited = options;
  std::vector<CandidateOptions> modes = options.candidates;
  std::string text = WriteSettingsKey([&](SettingsVisitor& v) { visited.Visit(v); });
  for (CandidateOptions& mode : modes) {
    text += WriteSettingsKey([&](SettingsVisitor& v) { mode.Visit(v); });
  }
  text += fmt::format("entries {}\nsensor {}\nmodel {:016x}\n{}", options.entries,
                      job.sensor_profile, model_hash, job.views.ClutterSceneSettings());
  for (const auto& object : job.views.objects()) {
    text += fmt::format("\n{} {:016x}", object->name, object->mesh_hash);
  }
  return text;
}

// Candidates of the first objects.
struct Collected {
  int objects = 0;
  VerifierExamples examples;
};

void WriteUnfinished(const std::filesystem::path& file, const std::string& settings,
                     const Collected& collected) {
  const auto count = static_cast<int64_t>(collected.examples.features.size());
  std::vector<float> features;
  features.reserve(count * kVerifyFeatures);
  for (const VerifyFeatures& row : collected.examples.features) {
    features.insert(features.end(), row.begin(), row.end());
  }
  const std::vector<int64_t> right(collected.examples.right.begin(),
                                   collected.examples.right.end());
  const std::vector<int64_t> objects{collected.objects};
  TensorFile stored(kUnfinishedKind, kFileVersion);
  stored.PutText("settings", settings);
  stored.Put("objects", objects, {1});
  stored.Put("features", features, {count, kVerifyFeatures});
  stored.Put("right", right, {count});
  WriteFileAtomically(file, stored.Bytes());
}

Collected ReadUnfinished(const std::filesystem::path& file, const std::string& settings,
                         size_t object_count) {
  Collected collected;
  try {
    const TensorFile stored =
        TensorFile::Parse(ReadFileBytes(file), kUnfinishedKind, kFileVersion, kFileVersion);
    CheckInput(stored.Text("settings") == settings,
               "it has other settings, objects or another model; train without --resume");
    const std::vector<int64_t> objects = stored.Integers("objects"),
                               right = stored.Integers("right");
    const std::vector<float> features = stored.Floats("features");
    CheckInput(objects.size() == 1 && objects[0] >= 0 &&
                   objects[0] <= static_cast<int64_t>(object_count) &&
                   features.size() == right.size() * kVerifyFeatures,
               "it is damaged; train without --resume");
    collected.objects = static_cast<int>(objects[0]);
    collected.examples.right.assign(right.begin(), right.end());
    collected.examples.features.resize(right.size());
    for (size_t i = 0; i < right.size(); ++i) {
      std::copy_n(features.begin() + i * kVerifyFeatures, kVerifyFeatures,
                  collected.examples.features[i].begin());
    }
  } catch (const InputError& error) {
    throw InputError(file.string() + ": " + error.what());
  }
  return collected;
}

}  // namespace

std::filesystem::path UnfinishedSharedVerifier(const std::filesystem::path& file) {
  return file.string() + ".checkpoint";
}

SharedVerifierReport TrainSharedVerifier(const SharedVerifierJob& job,
                                         const VerifierTrainingOptions& given) {
  CheckSettings("VerifierTrainingOptions", given);
  CheckInput(given.room_scenes > 0, "room_scenes must be 1 or more for a shared verifier");
  const ObjectSet& objects = job.views.objects();
  const DescriptorModel model = LoadModel(job.model);
  const std::vector<int> known = TrainedObjects(model.info.objects, objects, job.model);
  VerifierTrainingOptions options = given;
  options.clutter_scenes = 0;
  options.seed = Rng::Derive(given.seed, 0, "training/shared_verifier").Next();
  const std::string settings = SettingsText(job, given, model.hash);
  const std::filesystem::path unfinished = UnfinishedSharedVerifier(job.file);
  Collected collected;
  if (job.resume) collected = ReadUnfinished(unfinished, settings, objects.size());
  SharedVerifierReport report;
  const auto summarize = [&] {
    report.objects = collected.objects;
    report.candidates = static_cast<int>(collected.examples.right.size());
    report.right = static_cast<int>(std::ranges::count(collected.examples.right, 1));
    return report;
  };
  while (collected.objects < static_cast<int>(objects.size())) {
    const ObjectId object(collected.objects);
    const double side_m = model.info.objects[known[object]].side_m;
    bool go_on = true;
    // Rendering takes about as long as the search.
    const auto half = [&](double offset) {
      return [&, offset](double share) {
        return go_on =
                   !job.on_progress || job.on_progress(objects[object]->name, offset + 0.5 * share);
      };
    };
    const VerifierTrainingSet training_set = MakeVerifierTrainingSet(
        job.views, object, {side_m, model.network.channels()}, options, half(0));
    if (!go_on) return summarize();
    const VerifierExamples found = RoomExamples(
        training_set, objects[object],
        {object, side_m, model.network.length(), VoterOf(model.network)}, options, half(0.5));
    if (!go_on) return summarize();
    VerifierExamples& all = collected.examples;
    all.features.insert(all.features.end(), found.features.begin(), found.features.end());
    all.right.insert(all.right.end(), found.right.begin(), found.right.end());
    ++collected.objects;
    WriteUnfinished(unfinished, settings, collected);
  }
  const TrainedNetwork trained = TrainVerifier(collected.examples, options.verifier, given.seed);
  SaveSharedVerifier(job.file, trained.network, job.sensor_profile, settings);
  std::filesystem::remove(unfinished);
  report.finished = true;
  return summarize();
}

void SaveSharedVerifier(const std::filesystem::path& file, const VerifierNetwork& network,
                        const std::string& sensor_profile, const std::string& settings) {
  TensorFile stored(kFileKind, kFileVersion);
  stored.PutText("sensor", sensor_profile);
  stored.PutText("training", settings);
  stored.Put("verifier", VerifierValues({Verifier{network, network, {}}}));
  WriteFileAtomically(file, stored.Bytes());
}

VerifierNetwork LoadSharedVerifier(const std::filesystem::path& file) {
  const auto fail = [&](const std::string& reason) {
    return InputError(
        fmt::format("{}: {}; make it with `pickbed train verifier`, or set "
                    "shared_verifier=none",
                    file.string(), reason));
  };
  if (!std::filesystem::exists(file)) throw fail("the shared verifier does not exist");
  try {
    const TensorFile stored =
        TensorFile::Parse(ReadFileBytes(file), kFileKind, kFileVersion, kFileVersion);
    return VerifiersFrom(stored.Floats("verifier"), 1).front().unknown;
  } catch (const InputError& error) {
    throw fail(error.what());
  }
}

}  // namespace pickbed::perception
