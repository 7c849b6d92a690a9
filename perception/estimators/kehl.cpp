#include "perception/estimators/kehl.h"

#include "perception/estimators/descriptor.h"

namespace pickbed::perception {
namespace {

constexpr const char* kKehlModel = "kehl";

}  // namespace

std::unique_ptr<PoseEstimator> MakeKehlEstimator(const EstimatorSetup& setup) {
  DescriptorOptions options = OptionsForMode(setup.spec.mode);
  options.candidates.votes = "modes";
  return MakeLearnedEstimator(
      setup, options, {ModelFileOr(setup.spec, kKehlModel), "autoencoder", "`pickbed train kehl`"});
}

std::unique_ptr<EstimatorTraining> MakeKehlTraining() {
  TrainingOptions options;
  options.network.kind = "autoencoder";
  options.network.descriptor = 64;
  options.candidates.votes = "modes";
  return MakePatchNetworkTraining(kKehlModel, options);
}

}  // namespace pickbed::perception
