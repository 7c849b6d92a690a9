#include "perception/estimators/verified_estimator.h"

#include <utility>

namespace pickbed::perception {
namespace {

class VerifiedEstimator : public PoseEstimator {
 public:
  explicit VerifiedEstimator(VerifiedSetup setup) : setup_(std::move(setup)) {}

  EstimateResult Estimate(const EstimatorInput& input, Rng& rng) override {
    EstimateResult result;
    OrganizedCloud cloud;
    {
      const StageTimer timer(result.seconds, "cloud");
      cloud = BuildCloud(input.frame, input.background);
    }
    const std::vector<Candidate> candidates = setup_.source->Find(cloud, rng, result.seconds);
    const CandidateAssessor& assessor = setup_.source->assessor();
    {
      const StageTimer timer(result.seconds, "suppress");
      result.hypotheses = FinalSet(cloud, assessor.model_points(), assessor.distances(),
                                   setup_.verifiers, candidates, setup_.final_set, input.instances);
    }
    const StageTimer timer(result.seconds, "refine");
    RefineFinally(setup_.refiner, cloud, assessor.model_points(), setup_.refiner_options,
                  setup_.threads, result.hypotheses);
    return result;
  }

 private:
  VerifiedSetup setup_;
};

}  // namespace

std::unique_ptr<PoseEstimator> MakeVerifiedEstimator(VerifiedSetup setup) {
  return std::make_unique<VerifiedEstimator>(std::move(setup));
}

std::vector<Verifier> VerifiersOf(const VerifierFile& trained, const ObjectSet& objects,
                                  const std::filesystem::path& file) {
  std::vector<Verifier> verifiers;
  for (const int part : TrainedParts(trained.objects, objects, file,
                                     "pickbed train PART... --verifier-for " + trained.estimator)) {
    verifiers.push_back(trained.verifiers[part]);
  }
  return verifiers;
}

}  // namespace pickbed::perception
