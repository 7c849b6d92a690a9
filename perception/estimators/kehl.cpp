#include "perception/estimators/kehl.h"

#include "perception/estimators/descriptor.h"
#include "perception/torch_model_file.h"

namespace pickbed {

std::filesystem::path KehlModelFile(const EstimatorSpec& spec) {
  return TrainedFile(spec.model.empty() ? "kehl" : spec.model);
}

std::unique_ptr<PoseEstimator> MakeKehlEstimator(const EstimatorSetup& setup) {
  DescriptorOptions options = OptionsForMode(setup.spec.mode);
  options.candidates.votes = "modes";
  return MakeLearnedEstimator(setup, options,
                              {KehlModelFile(setup.spec), "autoencoder", "pickbed train kehl"});
}

}  // namespace pickbed
