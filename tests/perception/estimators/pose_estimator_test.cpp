#include "perception/estimators/pose_estimator.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>
#include <stdexcept>

#include "perception/estimators/estimator_training.h"
#include "tests/support/error_of.h"
#include "tests/support/synthetic_depth.h"

namespace pickbed::tests {
namespace {

using testing::AllOf;
using testing::HasSubstr;

TEST(EstimatorTable, NamesAreDistinctAndRowsAreComplete) {
  std::set<std::string> names;
  for (const EstimatorRow& row : EstimatorTable()) {
    EXPECT_TRUE(names.insert(row.name).second) << row.name;
    EXPECT_STRNE(row.help, "") << row.name;
    EXPECT_NE(row.make, nullptr) << row.name;
    EXPECT_FALSE(row.modes.empty()) << row.name;
    EXPECT_EQ(&EstimatorNamed(row.name), &row);
  }
}

TEST(EstimatorTable, ModelFileIsTheNamedOneOrTheDefault) {
  for (const EstimatorRow& row : EstimatorTable()) {
    if (!row.make_training) continue;
    const auto training = row.make_training();
    EstimatorSpec spec;
    spec.mode = row.modes.back();
    EXPECT_EQ(training->ModelFile(spec).extension(), ".net") << row.name;
    spec.model = "folder/own.net";
    EXPECT_EQ(training->ModelFile(spec), "folder/own.net") << row.name;
  }
}

// Each kind of training has its own functions. A call of another function is an error of the
// program.
TEST(EstimatorTable, TrainingHasTheFunctionsOfItsKind) {
  for (const EstimatorRow& row : EstimatorTable()) {
    if (!row.make_training) continue;
    const auto training = row.make_training();
    const bool has_network = training->kind() == TrainingKind::kNetworkAndVerifiers;
    if (training->kind() == TrainingKind::kPatchNetwork) {
      EXPECT_NO_THROW(training->PatchNetworkOptions()) << row.name;
    } else {
      EXPECT_THROW(training->PatchNetworkOptions(), std::logic_error) << row.name;
    }
    if (has_network) {
      EXPECT_NE(training->NetworkSettings({ObjectOf(BracketMesh())}), "") << row.name;
    } else {
      EXPECT_THROW(training->NetworkSettings({}), std::logic_error) << row.name;
    }
  }
}

TEST(MakeEstimator, OnlyEstimatorsThatCompleteShapesAcceptACompletion) {
  EstimatorSetup setup;
  setup.spec.name = "ppf";
  setup.spec.completion = "network";
  EXPECT_THAT(ErrorOf([&] { MakeEstimator(setup); }), HasSubstr("use estimator descriptor"));
}

TEST(MakeEstimator, UnknownNamesAreRefusedAndKnownOnesAreListed) {
  EstimatorSetup setup;
  setup.objects = {ObjectOf(BracketMesh())};
  setup.spec.name = "pff";
  EXPECT_THAT(ErrorOf([&] { MakeEstimator(setup); }),
              AllOf(HasSubstr("did you mean 'ppf'"), HasSubstr("descriptor")));
  for (const EstimatorRow& row : EstimatorTable()) {
    setup.spec.name = row.name;
    setup.spec.mode = "fsat";
    EXPECT_THAT(
        ErrorOf([&] { MakeEstimator(setup); }),
        AllOf(HasSubstr(row.name), HasSubstr("did you mean 'fast'"), HasSubstr("accurate")));
    setup.spec.mode = row.modes.front();
    setup.refiner = "icp";
    EXPECT_THAT(ErrorOf([&] { MakeEstimator(setup); }),
                AllOf(HasSubstr("'icp'"), HasSubstr("pcl_icp"), HasSubstr("bidirectional_icp")));
    setup.refiner = "none";
  }
}

}  // namespace
}  // namespace pickbed::tests
