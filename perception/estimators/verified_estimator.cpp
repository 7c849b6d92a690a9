#include "perception/estimators/verified_estimator.h"

#include <utility>

#include "perception/cloud/search_cloud.h"
#include "perception/verify/image_domain.h"

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
      cloud = SearchCloud(input.frame, input.background, setup_.binning, input.region,
                          input.fits_background, setup_.threads);
    }
    result.has_background = input.background.has_value() || !cloud.planes.empty();
    result.domain_warnings = DomainWarnings(DomainOf(cloud));
    const std::vector<Candidate> candidates = setup_.source->Find(cloud, rng, result.seconds);
    const CandidateRefiner& candidate_refiner = setup_.source->candidate_refiner();
    {
      const StageTimer timer(result.seconds, "non_maximum_suppression");
      result.hypotheses =
          SelectPoses(cloud, candidate_refiner.model_points(), candidate_refiner.distances(),
                      setup_.verifiers, candidates, setup_.pose_selection, input.instances);
    }
    {
      const StageTimer timer(result.seconds, "refine");
      RefineFinally(setup_.refiner, cloud, candidate_refiner.model_points(), setup_.threads,
                    result.hypotheses);
    }
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
  for (const int index : TrainedObjects(trained.objects, objects, file,
                                        "`pickbed train` as verifiers of " + trained.estimator)) {
    verifiers.push_back(trained.verifiers[index]);
  }
  return verifiers;
}

}  // namespace pickbed::perception
