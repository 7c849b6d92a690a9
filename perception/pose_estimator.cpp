#include "perception/pose_estimator.h"

#include "perception/estimators/descriptor.h"
#include "perception/estimators/doumanoglou.h"
#include "perception/estimators/kehl.h"
#include "perception/estimators/ppf.h"
#include "perception/estimators/ppf_verified.h"
#include "perception/estimators/wohlhart.h"
#include "perception/training.h"

namespace pickbed {
namespace {

TrainingOptions DescriptorTraining() { return {}; }

constexpr EstimatorRow kRows[] = {
    {"descriptor", "learned patch descriptors that vote through a code book, ICP and verifier",
     &MakeDescriptorEstimator, &DescriptorModelFile, true, true, nullptr, &DescriptorTraining},
    {"kehl",
     "patches described by an auto-encoder; their votes filtered to modes, then descriptor's ICP "
     "and verifier",
     &MakeKehlEstimator, &KehlModelFile, false, true, nullptr, &KehlTraining},
    {"doumanoglou",
     "poses regressed from patches by a siamese network, then descriptor's ICP and verifier",
     &MakeDoumanoglouEstimator, &DoumanoglouModelFile, false, false, nullptr, &DoumanoglouTraining},
    {"union", "descriptor's votes and those that doumanoglou's network regresses, together",
     &MakeUnionEstimator, &DoumanoglouModelFile, false, true},
    {"wohlhart",
     "whole parts described at once and looked up among templates, then descriptor's ICP and "
     "verifier",
     &MakeWohlhartEstimator, &WohlhartModelFile, false, true, &MakeWohlhartCandidates, nullptr,
     &LearnWohlhart},
    {"ppf",
     "point pair features with ICP, OpenCV's surface matching; mode verified: its poses with "
     "descriptor's ICP and a verifier",
     &MakePpfEstimator, &PpfModelFile, false, false, &MakePpfCandidates},
};

}  // namespace

std::span<const EstimatorRow> EstimatorTable() { return kRows; }

}  // namespace pickbed
