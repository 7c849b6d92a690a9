#include "perception/training/checkpoint.h"

#include <gtest/gtest.h>

#include "tests/support/block_file.h"
#include "tests/support/error_of.h"
#include "tests/support/temporary_folder.h"

namespace pickbed::tests {
namespace {

TrainedVerifier AVerifier(float bias, double auc) {
  constexpr int kHidden = 3;
  Verifier v;
  v.known.mean = Eigen::VectorXf::LinSpaced(kVerifyFeatures, 0, 1);
  v.known.scale = Eigen::VectorXf::Ones(kVerifyFeatures);
  v.known.w1 = Eigen::MatrixXf::Constant(kHidden, kVerifyFeatures, 0.1f);
  v.known.b1 = Eigen::VectorXf::LinSpaced(kHidden, -1, 1);
  v.known.w2 = Eigen::VectorXf::LinSpaced(kHidden, 1, 2);
  v.known.b2 = bias;
  v.unknown = v.known;
  v.unknown.b2 = -bias;
  for (auto& modes : v.calibrations) modes = {{{1.5f, 0.5f}, {0.5f, -0.5f}}};
  return {v, auc};
}

TEST(Checkpoint, RoundTripKeepsAllFields) {
  const std::vector<HeldOutRecall> recalls{{0, 0.1, 0.4, {0.2, -1}, {0.5, -1}},
                                           {5, 0.3, 0.6, {0.4, 0.2}, {0.7, 0.5}}};
  const Checkpoint saved{"key",
                         7,
                         {0.5, 0.25},
                         recalls,
                         std::string("\0state\xff", 7),
                         {AVerifier(0.25f, 0.9), AVerifier(-0.5f, 0.8)}};
  const TemporaryFolder folder;
  WriteCheckpoint(folder.path() / "c", saved);
  const Checkpoint read = ReadCheckpoint(folder.path() / "c", "key");
  EXPECT_EQ(read.iteration, saved.iteration);
  EXPECT_EQ(read.loss_history, saved.loss_history);
  EXPECT_EQ(read.training_state, saved.training_state);
  ASSERT_EQ(read.recall_history.size(), 2u);
  EXPECT_EQ(read.recall_history[0].object_at_1, recalls[0].object_at_1);
  EXPECT_EQ(read.recall_history[1].iteration, 5);
  EXPECT_EQ(read.recall_history[1].at_1, 0.3);
  EXPECT_EQ(read.recall_history[1].at_8, 0.6);
  EXPECT_EQ(read.recall_history[1].object_at_8, recalls[1].object_at_8);
  ASSERT_EQ(read.verifiers.size(), 2u);
  VerifyFeatures features{};
  features[3] = 0.7f;
  for (size_t i = 0; i < 2; ++i) {
    EXPECT_EQ(read.verifiers[i].auc, saved.verifiers[i].auc);
    for (const CandidateMode mode : {CandidateMode::kAccurate, CandidateMode::kFast}) {
      EXPECT_EQ(read.verifiers[i].verifier.Score(features, mode),
                saved.verifiers[i].verifier.Score(features, mode));
    }
  }
}

TEST(Checkpoint, AFileThatIsLongerThanItsBlocksIsRefused) {
  const TemporaryFolder folder;
  const std::filesystem::path file = folder.path() / "c";
  Checkpoint checkpoint;
  checkpoint.key = "key";
  checkpoint.iteration = 3;
  WriteCheckpoint(file, checkpoint);
  const std::string bytes = ReadFileBytes(file);
  WriteFileAtomically(file, WithRightHash(bytes));
  EXPECT_EQ(ReadCheckpoint(file, "key").iteration, 3);
  WriteFileAtomically(file, WithRightHash(bytes + "x"));
  EXPECT_EQ(
      ErrorOf([&] { ReadCheckpoint(file, "key"); }),
      file.string() +
          ": the file is damaged: it is longer than its blocks; restore the file from a copy, "
          "or train to another file");
}

}  // namespace
}  // namespace pickbed::tests
