#include "perception/estimators/estimator_training.h"

#include <stdexcept>

#include "perception/networks/model_file.h"
#include "scenes/base/files.h"

namespace pickbed::perception {
namespace {

class PatchNetworkTraining : public EstimatorTraining {
 public:
  PatchNetworkTraining(const char* default_model, const TrainingOptions& options)
      : default_model_(default_model), options_(options) {}

  TrainingKind kind() const override { return TrainingKind::kPatchNetwork; }
  std::filesystem::path ModelFile(const EstimatorSpec& spec) const override {
    return ModelFileOr(spec, default_model_);
  }
  TrainingOptions PatchNetworkOptions() const override { return options_; }

 private:
  const char* default_model_;
  TrainingOptions options_;
};

}  // namespace

TrainingOptions EstimatorTraining::PatchNetworkOptions() const {
  throw std::logic_error("the estimator has no patch network");
}

std::unique_ptr<CandidateSource> EstimatorTraining::MakeCandidates(const CandidateSetup&) const {
  throw std::logic_error("the estimator has no verifiers of its own");
}

void EstimatorTraining::VisitNetworkOptions(SettingsVisitor&) {
  throw std::logic_error("the estimator has no network of its own");
}

std::string EstimatorTraining::NetworkSettings(const ObjectSet&) const {
  throw std::logic_error("the estimator has no network of its own");
}

std::optional<LearnedNetwork> EstimatorTraining::TrainNetwork(const NetworkTrainingJob&) const {
  throw std::logic_error("the estimator has no network of its own");
}

std::filesystem::path ModelFileOr(const EstimatorSpec& spec, const char* default_model) {
  return TrainedFile(spec.model.empty() ? default_model : spec.model);
}

std::unique_ptr<EstimatorTraining> MakePatchNetworkTraining(const char* default_model,
                                                            const TrainingOptions& options) {
  return std::make_unique<PatchNetworkTraining>(default_model, options);
}

}  // namespace pickbed::perception
