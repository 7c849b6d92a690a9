#include "perception/networks/model_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <functional>

#include "perception/networks/tensor_file.h"
#include "perception/networks/verifier_file.h"
#include "scenes/base/error.h"
#include "scenes/base/files.h"
#include "scenes/mesh_io/mesh_join.h"
#include "tests/support/error_of.h"
#include "tests/support/synthetic_depth.h"
#include "tests/support/temporary_folder.h"

namespace pickbed::tests {
namespace {

using testing::HasSubstr;

class ModelFile : public testing::Test {
 protected:
  // Saves a model without training and returns its file.
  std::filesystem::path Untrained() {
    const std::filesystem::path file = folder_ / "model.net";
    ModelInfo info;
    info.objects = {{"test part", objects_[0]->mesh_hash, 0.08, 0.064}};
    info.network.descriptor = 8;
    Verifier verifier;
    verifier.known.mean = Eigen::VectorXf::LinSpaced(kVerifyFeatures, 0, 1);
    verifier.known.scale = Eigen::VectorXf::Ones(kVerifyFeatures);
    verifier.known.w1 = Eigen::MatrixXf::Random(24, kVerifyFeatures);
    verifier.known.b1 = Eigen::VectorXf::LinSpaced(24, -1, 1);
    verifier.known.w2 = Eigen::VectorXf::LinSpaced(24, 1, -1);
    verifier.known.b2 = 0.25f;
    verifier.unknown = verifier.known;
    verifier.unknown.b2 = -0.5f;
    verifier.calibrations[1][1] = {0.5f, -1};
    SaveModel(file, info, DescriptorNetwork(info.network, 3), {verifier});
    verifier_ = verifier;
    return file;
  }

  Verifier verifier_;
  const ObjectSet objects_{ObjectOf(BracketMesh())};
  const TemporaryFolder temporary_;
  const std::filesystem::path folder_ = temporary_.path();
};

TEST_F(ModelFile, RoundTripKeepsVerifierAndWeights) {
  const DescriptorModel model = LoadModel(Untrained());
  EXPECT_EQ(model.network.Weights(), DescriptorNetwork({"convolutional", 8}, 3).Weights());
  VerifyFeatures features{};
  features[3] = 0.7f;
  for (const auto background :
       {BackgroundKind::kKnown, BackgroundKind::kFitted, BackgroundKind::kNone}) {
    for (const auto mode : {CandidateMode::kAccurate, CandidateMode::kFast}) {
      EXPECT_EQ(model.verifiers.at(0).Score(features, mode, background),
                verifier_.Score(features, mode, background));
    }
  }
}

TEST_F(ModelFile, RoundTripKeepsAColorNetwork) {
  Untrained();
  ModelInfo info;
  info.objects = {{"test part", objects_[0]->mesh_hash, 0.08, 0.064}};
  info.network = {"autoencoder", 8};
  info.network.autoencoder.channels = "rgbd";
  const DescriptorNetwork network(info.network, 3);
  SaveModel(folder_ / "rgbd.net", info, network, {verifier_});
  const DescriptorModel model = LoadModel(folder_ / "rgbd.net");
  std::vector<int8_t> patches(3 * kPatchValues);
  for (size_t i = 0; i < patches.size(); ++i) patches[i] = static_cast<int8_t>(i * 37 % 251 - 125);
  EXPECT_EQ(model.network.Describe(patches), network.Describe(patches));
  EXPECT_EQ(model.network.channels(), PatchChannels::kDepthColor);
}

TEST_F(ModelFile, DamagedFilesAreRefusedByName) {
  const std::filesystem::path file = Untrained();
  const std::string bytes = ReadFileBytes(file);
  for (const double share : {0.0, 0.1, 0.5, 0.9, 0.999}) {
    WriteFileAtomically(file, bytes.substr(0, static_cast<size_t>(share * bytes.size())));
    const std::string error = ErrorOf([&] { LoadModel(file); });
    EXPECT_THAT(error, HasSubstr("model.net")) << "cut to " << share;
    EXPECT_THAT(error, HasSubstr("pickbed train"));
    EXPECT_EQ(error.find('\n'), std::string::npos) << error;
  }
  int refused = 0;
  for (size_t place = bytes.size() / 4; place < bytes.size() * 3 / 4; place += bytes.size() / 20) {
    std::string damaged = bytes;
    damaged[place] ^= 0x10;
    WriteFileAtomically(file, damaged);
    refused += ErrorOf([&] { LoadModel(file); }) != "no error";
  }
  EXPECT_GE(refused, 10) << "flipped bits among the weights are not detected";
  WriteFileAtomically(file, "hello");
  EXPECT_THAT(ErrorOf([&] { LoadModel(file); }), HasSubstr("cut short"));
  EXPECT_THAT(ErrorOf([&] { LoadModel(folder_ / "absent.net"); }), HasSubstr("absent.net"));
}

TEST_F(ModelFile, NewerVersionIsReportedAsSuch) {
  TensorFile content("descriptor model", 99);
  WriteFileAtomically(folder_ / "model.net", content.Bytes());
  EXPECT_THAT(ErrorOf([&] { LoadModel(folder_ / "model.net"); }),
              HasSubstr("model.net: it is of version 99, newer than this program"));
}

TEST_F(ModelFile, FilesOfAnotherKindAreRefused) {
  VerifierFile verifiers;
  verifiers.estimator = "ppf";
  SaveVerifiers(folder_ / "ppf.net", verifiers);
  EXPECT_THAT(ErrorOf([&] { LoadModel(folder_ / "ppf.net"); }),
              HasSubstr("ppf.net: it is not a descriptor model but a file of verifiers"));
}

// PyTorch runs the code in an archive when it opens it.
TEST_F(ModelFile, PyTorchArchivesAreRefusedUnread) {
  WriteFileAtomically(folder_ / "old.net", std::string("PK\3\4 and code", 13));
  EXPECT_THAT(ErrorOf([&] { LoadModel(folder_ / "old.net"); }),
              HasSubstr("old.net: it is a PyTorch archive, which can run code"));
}

// One hidden unit that uses only the first two features.
TEST(VerifierValues, FewerFeaturesMeanTheFirstOnes) {
  const std::vector<float> values{0.5f, 1, 2, 4, 3, -1, 0.1f, 2, 0.25f, 1, 0};
  const Verifier verifier = VerifiersFrom(values, 1, {2, 1, false}).at(0);
  VerifyFeatures features{};
  features[0] = 0.7f;
  features[1] = 2;
  const double unit = std::tanh(3 * (0.7 - 0.5) / 2 - (2.0 - 1) / 4 + 0.1);
  const double expected = 1 / (1 + std::exp(-(2 * unit + 0.25)));
  EXPECT_NEAR(verifier.Score(features), expected, 1e-6);
  features[kOutsideFeature] = 100;
  EXPECT_NEAR(verifier.Score(features), expected, 1e-6);
  EXPECT_NEAR(verifier.Score(features, CandidateMode::kFast), expected, 1e-6)
      << "a single calibration applies to all modes";
  EXPECT_THAT(ErrorOf([&] {
                VerifiersFrom(values, 1, {3, 1, false});
              }),
              HasSubstr("another shape"));
}

// A mesh with other colors on both sides of an edge has more vertices there.
TEST(TrainedObjects, ColoredMeshUsesTheModelOfTheSameShape) {
  TriangleMesh plain = BracketMesh();
  plain = WithEqualVerticesJoined(plain);
  TriangleMesh colored;
  for (const Eigen::Vector3i& triangle : plain.triangles) {
    const int first = static_cast<int>(colored.vertices.size());
    for (const int corner : triangle) {
      colored.vertices.push_back(plain.vertices[corner]);
      colored.colors.push_back({static_cast<uint8_t>(first), 100, 50});
    }
    colored.triangles.emplace_back(first, first + 1, first + 2);
  }
  auto object = std::make_shared<ObjectModel>();
  object->name = "bracket";
  object->mesh_O = colored;
  object->mesh_hash = MeshHash(colored);
  ASSERT_NE(object->mesh_hash, MeshHash(plain));
  const std::vector<ModelObject> trained{{"bracket", MeshHash(plain), 0.08, 0.064}};
  EXPECT_EQ(TrainedObjects(trained, {object}, "m.net"), std::vector{0});
  auto other = std::make_shared<ObjectModel>(*object);
  other->mesh_O.vertices.back().x() += 0.001;
  other->mesh_hash = MeshHash(other->mesh_O);
  EXPECT_THAT(ErrorOf([&] { TrainedObjects(trained, {other}, "m.net"); }),
              HasSubstr("has changed since training"));
}

TEST(ShippedModel, CanBeLoaded) {
  const DescriptorModel model =
      LoadModel(std::filesystem::path(PICKBED_SOURCE_DIR) / "assets/models/shipped.net");
  EXPECT_GE(model.info.objects.size(), 12u);
  EXPECT_EQ(model.verifiers.size(), model.info.objects.size());
}

TEST_F(ModelFile, UnknownObjectsAndChangedMeshesAreNamed) {
  const DescriptorModel model = LoadModel(Untrained());
  const ObjectSet& known = objects_;
  EXPECT_EQ(TrainedObjects(model.info.objects, known, "m.net"), std::vector{0});
  auto changed = std::make_shared<ObjectModel>(*known[0]);
  changed->mesh_hash += 1;
  EXPECT_THAT(ErrorOf([&] { TrainedObjects(model.info.objects, {changed}, "m.net"); }),
              HasSubstr("m.net: the mesh of object 'test part' has changed"));
  changed->name = "widget";
  EXPECT_THAT(
      ErrorOf([&] { TrainedObjects(model.info.objects, {changed}, "m.net"); }),
      HasSubstr("m.net: not trained for object 'widget' (knows test part); train a model with "
                "`pickbed train widget`"));
}

}  // namespace
}  // namespace pickbed::tests
