#include "perception/pose_estimator.h"

#include "perception/estimators/descriptor.h"
#include "perception/estimators/ppf.h"
#include "perception/estimators/ppf_verified.h"

namespace pickbed {
namespace {

constexpr EstimatorRow kRows[] = {
    {"descriptor", "learned patch descriptors that vote through a code book, ICP and verifier",
     &MakeDescriptorEstimator, &DescriptorModelFile, true, true},
    {"ppf",
     "point pair features with ICP, OpenCV's surface matching; mode verified: its poses with "
     "descriptor's ICP and a verifier",
     &MakePpfEstimator, &PpfModelFile, false, false, &MakePpfCandidates},
};

}  // namespace

std::span<const EstimatorRow> EstimatorTable() { return kRows; }

}  // namespace pickbed
