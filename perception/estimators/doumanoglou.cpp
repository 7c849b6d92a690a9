#include "perception/estimators/doumanoglou.h"

#include "perception/estimators/descriptor.h"
#include "perception/networks/model_file.h"

namespace pickbed::perception {

namespace {

constexpr const char* kDoumanoglouModel = "doumanoglou";

class UnionTraining : public EstimatorTraining {
 public:
  TrainingKind kind() const override { return TrainingKind::kNone; }
  std::filesystem::path ModelFile(const EstimatorSpec& spec) const override {
    return ModelFileOr(spec, kDoumanoglouModel);
  }
};

}  // namespace

std::unique_ptr<PoseEstimator> MakeDoumanoglouEstimator(const EstimatorSetup& setup) {
  DescriptorOptions options = OptionsForMode(setup.spec.mode);
  options.candidates.votes = "regressed";
  return MakeLearnedEstimator(setup, options,
                              {ModelFileOr(setup.spec, kDoumanoglouModel), "siamese_regression",
                               "`pickbed train doumanoglou`"});
}

std::unique_ptr<EstimatorTraining> MakeDoumanoglouTraining() {
  TrainingOptions options;
  options.network.kind = "siamese_regression";
  options.network.descriptor = 64;
  options.candidates.votes = "regressed";
  options.held_out.patience = 0;  // recall of the features does not measure the regression
  return MakePatchNetworkTraining(kDoumanoglouModel, options);
}

std::unique_ptr<PoseEstimator> MakeUnionEstimator(const EstimatorSetup& setup) {
  DescriptorOptions options = OptionsForMode(setup.spec.mode);
  options.candidates.votes = "both";
  return MakeLearnedEstimator(setup, options,
                              {ModelFileOr({}, kShippedModel), "", kTrainCommand,
                               ModelFileOr(setup.spec, kDoumanoglouModel)});
}

std::unique_ptr<EstimatorTraining> MakeUnionTraining() { return std::make_unique<UnionTraining>(); }

}  // namespace pickbed::perception
