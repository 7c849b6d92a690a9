#include "perception/estimators/ppf_verified.h"

#include "perception/candidates/vote_candidates.h"
#include "perception/estimators/verified_estimator.h"
#include "perception/networks/verifier_file.h"

namespace pickbed::perception {
namespace {

constexpr const char* kPpfName = "ppf";

class PpfCandidates : public CandidateSource {
 public:
  PpfCandidates(const ObjectSet& objects, const VerifiedPpfOptions& options, int threads)
      : candidate_refiner_(objects, options.refinement, threads) {
    for (const ModelPoints& model : candidate_refiner_.model_points()) {
      matchers_.push_back(std::make_unique<PpfMatcher>(model, options.match));
    }
  }

  std::vector<Candidate> Find(const OrganizedCloud& cloud, Rng&, StageSeconds& seconds,
                              EstimateTrace* trace = nullptr) const override {
    std::vector<Candidate> candidates;
    for (size_t object = 0; object < matchers_.size(); ++object) {
      const std::vector<PoseVote> votes = Votes(*matchers_[object], cloud, seconds);
      if (votes.empty()) continue;
      const std::vector<Candidate> of_object = candidate_refiner_.RefineCandidates(
          cloud, ObjectId(object), votes, static_cast<int>(votes.size()), {}, seconds, trace);
      candidates.insert(candidates.end(), of_object.begin(), of_object.end());
    }
    candidate_refiner_.Compare(candidates, seconds);
    return candidates;
  }

  const CandidateRefiner& candidate_refiner() const override { return candidate_refiner_; }

 private:
  // Each reference point gives one pose, so each pose counts as a separate patch.
  static std::vector<PoseVote> Votes(const PpfMatcher& matcher, const OrganizedCloud& cloud,
                                     StageSeconds& seconds) {
    const StageTimer timer(seconds, "match");
    std::vector<PoseVote> votes;
    for (const Pose& X_CO : matcher.Match(matcher.SceneRows(cloud))) {
      votes.push_back({X_CO, static_cast<int>(votes.size())});
    }
    return votes;
  }

  CandidateRefiner candidate_refiner_;
  std::vector<std::unique_ptr<PpfMatcher>> matchers_;
};

class PpfTraining : public EstimatorTraining {
 public:
  TrainingKind kind() const override { return TrainingKind::kVerifiers; }
  std::filesystem::path ModelFile(const EstimatorSpec& spec) const override {
    if (spec.mode != kVerifiedMode) return {};
    return ModelFileOr(spec, kPpfName);
  }
  std::unique_ptr<CandidateSource> MakeCandidates(const CandidateSetup& setup) const override {
    return MakePpfCandidates(setup.objects, {});
  }
};

}  // namespace

VerifiedPpfOptions::VerifiedPpfOptions() { refinement = AccurateCandidates(); }

std::unique_ptr<CandidateSource> MakePpfCandidates(const ObjectSet& objects,
                                                   const VerifiedPpfOptions& options, int threads) {
  return std::make_unique<PpfCandidates>(objects, options, threads);
}

std::unique_ptr<EstimatorTraining> MakePpfTraining() { return std::make_unique<PpfTraining>(); }

std::unique_ptr<PoseEstimator> MakeVerifiedPpfEstimator(const EstimatorSetup& setup,
                                                        const VerifiedPpfOptions& options) {
  const std::filesystem::path file = PpfTraining().ModelFile(setup.spec);
  // Before the candidates, whose models take seconds: a wrong file is refused at once.
  auto verifiers = VerifiersOf(LoadVerifiers(file, kPpfName), setup.objects, file);
  VerifiedSetup made{MakePpfCandidates(setup.objects, options, setup.threads),
                     std::move(verifiers),
                     options.pose_selection,
                     setup.refiner,
                     setup.threads,
                     SearchBinning(setup)};
  made.pose_selection.min_score = setup.spec.min_score;
  return MakeVerifiedEstimator(std::move(made));
}

}  // namespace pickbed::perception
