#include "perception/completion/training_sample.h"

#include <algorithm>

#include "perception/completion/traced_solid.h"
#include "scenes/base/error.h"
#include "scenes/base/parallel.h"

namespace pickbed::perception {
namespace {

// Draws of points for each point that is kept. More are never needed in practice; a sample whose
// cube is almost all empty has points that are known to be empty.
constexpr int kMaxDraws = 30;

// Returns 127 for the cells whose center is inside, x fastest.
std::vector<int8_t> VolumeOf(const ViewedSolid& solid, const CompletionCube& cube,
                             const Eigen::Isometry3f& X_OC) {
  constexpr int n = kInputCells;
  std::vector<Eigen::Vector3f> centers_O;
  centers_O.reserve(kInputVolume);
  for (int i = 0; i < kInputVolume; ++i) {
    const Eigen::Vector3f cell(static_cast<float>(i % n), static_cast<float>(i / n % n),
                               static_cast<float>(i / (n * n)));
    const Eigen::Vector3f share = (cell + Eigen::Vector3f::Constant(0.5f)) / n;
    centers_O.push_back(X_OC * (cube.origin_C + cube.side_m * share));
  }
  std::vector<uint8_t> inside(centers_O.size());
  solid.Inside(centers_O, inside);
  std::vector<int8_t> volume(inside.size());
  for (size_t i = 0; i < inside.size(); ++i) volume[i] = inside[i] ? 127 : 0;
  return volume;
}

}  // namespace

CompletionSample MakeSample(const ViewedSolid& solid, const RandomView& drawn, int points, Rng& rng,
                            bool with_volume) {
  const CompletionInput input(drawn.view);
  const CompletionCube& cube = input.cube();
  CompletionSample sample;
  sample.channels = input.Channels();
  sample.image = input.ImageChannels();
  sample.queries.reserve(static_cast<size_t>(points) * kQueryValues);
  const Eigen::Isometry3f X_OC = drawn.X_CO.inverse().cast<float>();
  std::vector<Eigen::Vector3f> points_O;
  points_O.reserve(points);
  for (int draws_left = kMaxDraws * points; static_cast<int>(points_O.size()) < points;) {
    const Eigen::Vector3d share(rng.Uniform(), rng.Uniform(), rng.Uniform());
    const Eigen::Vector3f p_C = cube.origin_C + cube.side_m * share.cast<float>();
    if (--draws_left > 0 && input.IsKnownEmpty(p_C)) continue;
    AppendQuery(input, p_C, sample.queries);
    points_O.push_back(X_OC * p_C);
  }
  sample.inside.resize(points);
  solid.Inside(points_O, sample.inside);
  if (with_volume) sample.volume = VolumeOf(solid, cube, X_OC);
  return sample;
}

CompletionBatch BatchOf(std::span<const TurnedSample> samples, int threads) {
  CompletionBatch batch;
  batch.count = static_cast<int>(samples.size());
  if (samples.empty()) return batch;
  const CompletionSample& first = *samples.front().sample;
  batch.points = static_cast<int>(first.inside.size());
  batch.channels.resize(samples.size() * first.channels.size());
  batch.images.resize(samples.size() * first.image.size());
  batch.queries.resize(samples.size() * first.queries.size());
  batch.inside.resize(samples.size() * first.inside.size());
  batch.volumes.resize(samples.size() * first.volume.size());
  ForRanges(batch.count, threads, [&](int begin, int end) {
    for (size_t i = begin; i < static_cast<size_t>(end); ++i) {
      const auto& [sample, turn] = samples[i];
      TurnChannels(sample->channels, turn, batch.channels.data() + i * first.channels.size());
      TurnImage(sample->image, turn, batch.images.data() + i * first.image.size());
      float* const queries = batch.queries.data() + i * first.queries.size();
      std::copy(sample->queries.begin(), sample->queries.end(), queries);
      for (size_t k = 0; k < sample->queries.size(); k += kQueryValues) {
        TurnPlaces(turn, queries + k);
      }
      std::copy(sample->inside.begin(), sample->inside.end(),
                batch.inside.data() + i * first.inside.size());
      TurnChannels(sample->volume, turn, batch.volumes.data() + i * first.volume.size());
    }
  });
  return batch;
}

std::unique_ptr<ViewedSolid> SolidOf(SolidShape shape) {
  const Eigen::AlignedBox3f box_O = shape.box_O();
  return std::make_unique<TracedSolid>(
      [shape = std::move(shape)](std::span<const Eigen::Vector3f> points_O,
                                 std::span<float> distances_m) {
        shape.SignedDistances_m(points_O, distances_m);
      },
      box_O);
}

std::vector<CompletionSample> DrawGroup(const CompletionSource& source, uint64_t seed,
                                        int64_t group) {
  CheckInput(!source.families.empty(), "no shape families to draw from; name a shape domain");
  Rng rng = Rng::Derive(seed, static_cast<uint64_t>(group), "completion sample");
  const ShapeFamilyRow& family =
      *source.families[rng.Index(static_cast<int>(source.families.size()))];
  const auto solid = SolidOf(SampleShape(family, source.split, rng.Next()).solid);
  std::vector<CompletionSample> samples;
  for (int i = 0; i < source.views_per_shape; ++i) {
    const RandomView drawn = DrawView(*solid, source.sensors, source.views, rng);
    samples.push_back(MakeSample(*solid, drawn, source.points, rng, source.volumes));
  }
  return samples;
}

}  // namespace pickbed::perception
