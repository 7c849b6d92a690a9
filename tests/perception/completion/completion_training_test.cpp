#include "perception/completion/completion_training.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "perception/completion/completion_file.h"
#include "perception/completion/completion_network.h"
#include "perception/completion/sample_stream.h"
#include "scenes/base/error.h"
#include "scenes/base/files.h"
#include "tests/perception/completion/solid_views.h"
#include "tests/support/block_file.h"
#include "tests/support/error_of.h"

namespace pickbed::perception {
namespace {

using ::testing::HasSubstr;
using tests::ErrorOf;
using tests::WithRightHash;

std::filesystem::path TestFile(const std::string& name) {
  const auto folder = std::filesystem::path(::testing::TempDir()) / "completion_training";
  std::filesystem::create_directories(folder);
  return folder / name;
}

CompletionNetworkOptions TinyNetwork() {
  CompletionNetworkOptions options;
  options.width_16 = options.width_8 = options.width_4 = 4;
  options.bottleneck = 4;
  options.image_width = 4;
  options.hidden = 16;
  return options;
}

CompletionTrainingOptions TinyTraining() {
  CompletionTrainingOptions options;
  options.network = TinyNetwork();
  options.steps = 6;
  options.batch = 2;
  options.window = 3;
  options.held_out = 2;
  options.measure_every = 3;
  options.checkpoint_every = 2;
  options.points = 32;
  options.views_per_shape = 2;
  options.views.max_diameter_px = 50;
  return options;
}

CompletionJob Job(const std::string& name) {
  CompletionJob job;
  job.domains = {ShapeDomain::kMachine};
  job.model_file = TestFile(name + ".net");
  job.checkpoint = TestFile(name + ".checkpoint");
  return job;
}

CompletionSample SphereSample(uint64_t seed) {
  const auto solid = SphereSolid(0.05f);
  Rng rng(seed);
  const RandomView drawn = DrawView(*solid, {}, {}, rng);
  return MakeSample(*solid, drawn, 256, rng);
}

// A query keeps its cell and its pixel when all are turned.
TEST(TrainingSample, ATurnMovesCellsPixelsAndQueriesAlike) {
  CompletionSample sample;
  constexpr int n = kInputCells, m = kImagePixels;
  sample.channels.resize(kInputChannels * n * n * n);
  sample.image.resize(kImageChannels * m * m);
  Rng rng(1);
  for (int8_t& value : sample.channels) value = static_cast<int8_t>(rng.Index(255) - 127);
  for (float& value : sample.image) value = static_cast<float>(rng.Uniform());
  const auto pixel_of = [&](const float* place) {
    const auto at = [&](float value) { return std::min(m - 1, int((value + 1) / 2 * m)); };
    return at(place[1]) * m + at(place[0]);
  };
  const auto cell_of = [&](const float* place) {
    const auto at = [&](float value) { return std::min(n - 1, int((value + 1) / 2 * n)); };
    return (at(place[2]) * n + at(place[1])) * n + at(place[0]);
  };
  for (int i = 0; i < 50; ++i) {
    for (int axis = 0; axis < 3; ++axis) {
      sample.queries.push_back(static_cast<float>((rng.Index(n) + 0.5) / n * 2 - 1));
    }
    for (int axis = 0; axis < 2; ++axis) {
      sample.queries.push_back(static_cast<float>((rng.Index(m) + 0.5) / m * 2 - 1));
    }
    sample.queries.insert(sample.queries.end(), kPointFacts, 0.0f);
    sample.inside.push_back(0);
  }
  for (int turn = 0; turn < kCubeTurns; ++turn) {
    const TurnedSample turned[] = {{&sample, 0}, {&sample, turn}};
    const CompletionBatch batch = BatchOf(turned, 2);
    const int8_t* const channels = batch.channels.data() + sample.channels.size();
    const float* const image = batch.images.data() + sample.image.size();
    int moved = 0;
    for (size_t i = 0; i < sample.queries.size(); i += kQueryValues) {
      const float* const own = sample.queries.data() + i;
      const float* const query = &batch.queries[sample.queries.size() + i];
      EXPECT_EQ(sample.channels[cell_of(own)], channels[cell_of(query)]);
      EXPECT_EQ(sample.image[pixel_of(own + kImagePlace)], image[pixel_of(query + kImagePlace)]);
      moved += cell_of(own) != cell_of(query);
    }
    EXPECT_EQ(moved > 0, turn > 0);
  }
}

TEST(CompletionNetwork, LearnsOneShapeByHeart) {
  CompletionNetworkOptions options = TinyNetwork();
  options.width_16 = 8;
  CompletionNetwork network(options, 1);
  std::vector<CompletionSample> samples;
  for (int i = 0; i < 4; ++i) samples.push_back(SphereSample(i));
  std::vector<TurnedSample> turned;
  for (const CompletionSample& sample : samples) turned.push_back({&sample, 0});
  const CompletionBatch batch = BatchOf(turned);
  const double first = network.TrainStep(batch, 5e-3);
  double last = first;
  for (int step = 0; step < 60; ++step) last = network.TrainStep(batch, 5e-3);
  EXPECT_GT(first, 0.4);
  EXPECT_LT(last, 0.35 * first);
}

TEST(CompletionNetwork, ABatchGivesTheSameAsOneView) {
  const CompletionNetwork network(TinyNetwork(), 2);
  const CompletionInput input(UsualSphereView());
  const std::vector<Eigen::Vector3f> points{{0.03f, -0.02f, 0.6f}, {0.05f, 0, 0.62f}};
  CompletionBatch batch;
  batch.count = 1;
  batch.points = 2;
  batch.channels = input.Channels();
  batch.images = input.ImageChannels();
  for (const Eigen::Vector3f& p_C : points) AppendQuery(input, p_C, batch.queries);
  EXPECT_EQ(network.Probabilities(batch), network.Probabilities(input, points));
}

// A reflected view has the reflected completion when all turns are averaged.
TEST(CompletionNetwork, TheMeanOverAllTurnsIsSymmetric) {
  const CompletionNetwork network(TinyNetwork(), 2);
  const CameraIntrinsics k(121, 121, 400, 400, 60, 60);
  const CompletionInput input(SphereView(k, {0, 0, 0.6}, 0.04, 0.9f));
  const std::vector<Eigen::Vector3f> points{{0.02f, 0.01f, 0.6f}, {-0.01f, 0.02f, 0.6f}};
  const std::vector<float> all = network.Probabilities(input, points, kCubeTurns);
  EXPECT_NEAR(all[0], all[1], 1e-3);
  const std::vector<float> one = network.Probabilities(input, points, 1);
  EXPECT_GT(std::abs(one[0] - one[1]), 2 * std::abs(all[0] - all[1]));
}

TEST(CompletionFile, KeepsWeightsToHalfPrecisionAndWritesTheSameBytesAgain) {
  CompletionNetwork network(TinyNetwork(), 3);
  CompletionModelInfo info;
  info.network = TinyNetwork();
  info.families = {"bolt", "nut"};
  SaveCompletionModel(TestFile("a.net"), info, network);
  const CompletionModel read = LoadCompletionModel(TestFile("a.net"));
  EXPECT_EQ(read.info.families, info.families);
  EXPECT_EQ(read.network.Statistics(), network.Statistics());
  const std::vector<float> before = network.Weights(), after = read.network.Weights();
  ASSERT_EQ(before.size(), after.size());
  for (size_t i = 0; i < before.size(); ++i) {
    EXPECT_NEAR(after[i], before[i], 6e-4 * std::abs(before[i]) + 1e-7);
  }
  SaveCompletionModel(TestFile("b.net"), read.info, read.network);
  EXPECT_EQ(ReadFileBytes(TestFile("a.net")), ReadFileBytes(TestFile("b.net")));
}

TEST(CompletionFile, RefusesWeightsBeyondHalfPrecisionOrTheLimit) {
  CompletionNetwork network(TinyNetwork(), 3);
  std::vector<float> weights = network.Weights();
  weights.back() = 7e4f;
  network.SetWeights(weights, network.Statistics());
  const CompletionModelInfo info{TinyNetwork(), {}, {}, {}, 0, -1, -1, ""};
  EXPECT_THROW(SaveCompletionModel(TestFile("large.net"), info, network), InputError);
  std::vector<float> statistics = network.Statistics();
  statistics.front() = NAN;
  weights.back() = 1;
  network.SetWeights(weights, statistics);
  SaveCompletionModel(TestFile("nan.net"), info, network);
  EXPECT_THROW(LoadCompletionModel(TestFile("nan.net")), InputError);
  weights.back() = 3e4f;
  network.SetWeights(weights, CompletionNetwork(TinyNetwork(), 3).Statistics());
  SaveCompletionModel(TestFile("damaged.net"), info, network);
  EXPECT_THROW(LoadCompletionModel(TestFile("damaged.net")), InputError);
}

TEST(CompletionFile, RefusesMissingDamagedNewerAndOlderFilesInOneLine) {
  const auto error_of = [](const std::string& bytes) {
    WriteFileAtomically(TestFile("bad.net"), bytes);
    try {
      LoadCompletionModel(TestFile("bad.net"));
    } catch (const InputError& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  SaveCompletionModel(TestFile("c.net"), {TinyNetwork(), {}, {}, {}, 0, -1, -1, ""},
                      CompletionNetwork(TinyNetwork(), 3));
  const std::string good = ReadFileBytes(TestFile("c.net"));
  EXPECT_THAT(error_of(good.substr(0, good.size() / 2)), HasSubstr("cut short"));
  EXPECT_THAT(error_of(good.substr(0, 5)), HasSubstr("cut short"));
  EXPECT_THAT(error_of("something that is no model at all"), HasSubstr("not a completion model"));
  std::string damaged = good;
  damaged[damaged.size() / 2] ^= 1;
  EXPECT_THAT(error_of(damaged), HasSubstr("check sum is wrong"));
  EXPECT_EQ(error_of(WithRightHash(good)), "");
  EXPECT_THAT(error_of(WithRightHash(good + "x")), HasSubstr("longer than its blocks"));
  EXPECT_THAT(error_of(good + "x"), HasSubstr("check sum is wrong"));
  std::string newer = good;
  newer[8] = 9;  // the version follows the 8 bytes of the magic
  EXPECT_THAT(error_of(newer), HasSubstr("version 9, newer than this program"));
  std::string older = good;
  older[8] = 1;
  EXPECT_THAT(error_of(older), HasSubstr("version 1, older than 2; use the pickbed that wrote it"));
  EXPECT_THAT(error_of(newer), HasSubstr("pickbed train completion"));
  EXPECT_THROW(LoadCompletionModel(TestFile("none.net")), InputError);
}

TEST(SampleStream, GroupsDoNotDependOnTheThreads) {
  const auto make = [](int64_t group) {
    CompletionSample sample;
    sample.inside = {static_cast<uint8_t>(group)};
    return SampleStream::Group{sample};
  };
  SampleStream stream(make, 2, 3, 3);
  for (int64_t first = 2; first < 20; ++first) {
    stream.Advance(first, first + 4);
    for (int64_t group = first; group < first + 5; ++group) {
      EXPECT_EQ(stream.At(group).front().inside.front(), group);
    }
  }
}

TEST(SampleStream, PassesOnTheErrorOfAThread) {
  SampleStream stream([](int64_t) -> SampleStream::Group { throw InputError("no shape"); }, 0, 2,
                      2);
  EXPECT_THROW(stream.Advance(0, 1), InputError);
}

TEST(CompletionTraining, AStoppedAndResumedTrainingGivesTheSameBytes) {
  const CompletionTrainingOptions options = TinyTraining();
  EXPECT_TRUE(TrainCompletion(Job("whole"), options).finished);
  CompletionJob job = Job("stopped");
  int calls = 0;
  job.on_progress = [&](const CompletionProgress& state) {
    return state.phase != "network" || ++calls < 4;
  };
  const CompletionReport stopped = TrainCompletion(job, options);
  EXPECT_FALSE(stopped.finished);
  EXPECT_TRUE(stopped.has_checkpoint);
  job.on_progress = {};
  job.resume = true;
  CompletionTrainingOptions other_threads = options;
  other_threads.threads = 2;
  const CompletionReport resumed = TrainCompletion(job, other_threads);
  EXPECT_TRUE(resumed.finished);
  EXPECT_EQ(resumed.loss_history.size(), 6u);
  EXPECT_EQ(resumed.measurements.size(), 3u);
  EXPECT_EQ(ReadFileBytes(TestFile("whole.net")), ReadFileBytes(TestFile("stopped.net")));
}

// In this time, a slow machine may make no step at all.
TEST(CompletionTraining, StopsAtItsTimeLimitAndWritesAModel) {
  CompletionTrainingOptions options = TinyTraining();
  options.steps = 1000000;
  options.max_minutes = 0.02;
  const CompletionReport report = TrainCompletion(Job("minutes"), options);
  EXPECT_TRUE(report.finished);
  EXPECT_EQ(report.loss_history.size(), static_cast<size_t>(report.steps));
  EXPECT_LT(report.steps, options.steps);
  EXPECT_GE(report.seconds, 1.2);
  EXPECT_EQ(LoadCompletionModel(TestFile("minutes.net")).info.steps, report.steps);
}

// With a learning rate of nearly zero, the held-out loss soon stops improving.
TEST(CompletionTraining, StopsEarlyWithoutProgress) {
  CompletionTrainingOptions options = TinyTraining();
  options.steps = 400;
  options.warm_up = 1000000;
  options.measure_every = 4;
  options.patience = 3;
  const CompletionReport report = TrainCompletion(Job("early"), options);
  EXPECT_TRUE(report.finished);
  EXPECT_TRUE(report.stopped_early);
  EXPECT_LT(report.steps, options.steps);
  options.patience = 0;
  options.steps = report.steps + 4;
  EXPECT_FALSE(TrainCompletion(Job("late"), options).stopped_early);
}

TEST(CompletionTraining, RefusesReversedRangesOfTheViews) {
  CompletionTrainingOptions distance = TinyTraining(), diameter = distance, hidden = distance;
  distance.views.min_distance_m = 2;
  diameter.views.min_diameter_px = 51;
  hidden.views.min_hidden = 0.6;
  for (const CompletionTrainingOptions& options : {distance, diameter, hidden}) {
    try {
      TrainCompletion(Job("reversed"), options);
      ADD_FAILURE();
    } catch (const InputError& error) {
      EXPECT_THAT(error.what(), HasSubstr("is above views.max_"));
    }
  }
}

TEST(CompletionTraining, RefusesACheckpointOfOtherSettings) {
  CompletionCheckpoint checkpoint;
  checkpoint.key = "other";
  WriteCompletionCheckpoint(TestFile("other.checkpoint"), checkpoint);
  CompletionJob job = Job("other");
  job.resume = true;
  try {
    TrainCompletion(job, TinyTraining());
    FAIL();
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("training with other settings"));
  }
}

TEST(CompletionTraining, RefusesACheckpointThatIsLongerThanItsBlocks) {
  const std::filesystem::path file = TestFile("longer.checkpoint");
  CompletionCheckpoint checkpoint;
  checkpoint.key = "key";
  checkpoint.step = 3;
  WriteCompletionCheckpoint(file, checkpoint);
  const std::string bytes = ReadFileBytes(file);
  WriteFileAtomically(file, WithRightHash(bytes));
  EXPECT_EQ(ReadCompletionCheckpoint(file, "key").step, 3);
  WriteFileAtomically(file, WithRightHash(bytes + "x"));
  EXPECT_EQ(
      ErrorOf([&] { ReadCompletionCheckpoint(file, "key"); }),
      file.string() +
          ": the file is damaged: it is longer than its blocks; restore the file from a copy, "
          "or train to another file");
}

}  // namespace
}  // namespace pickbed::perception
