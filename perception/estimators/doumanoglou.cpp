#include "perception/estimators/doumanoglou.h"

#include "perception/estimators/descriptor.h"
#include "perception/torch_model_file.h"

namespace pickbed {

std::filesystem::path DoumanoglouModelFile(const EstimatorSpec& spec) {
  return TrainedFile(spec.model.empty() ? "doumanoglou" : spec.model);
}

std::unique_ptr<PoseEstimator> MakeDoumanoglouEstimator(const EstimatorSetup& setup) {
  DescriptorOptions options = OptionsForMode(setup.spec.mode);
  options.candidates.votes = "regressed";
  return MakeLearnedEstimator(
      setup, options,
      {DoumanoglouModelFile(setup.spec), "siamese_regression", "pickbed train doumanoglou"});
}

std::unique_ptr<PoseEstimator> MakeUnionEstimator(const EstimatorSetup& setup) {
  DescriptorOptions options = OptionsForMode(setup.spec.mode);
  options.candidates.votes = "both";
  return MakeLearnedEstimator(
      setup, options,
      {DescriptorModelFile({}), "", kTrainCommand, DoumanoglouModelFile(setup.spec)});
}

}  // namespace pickbed
