#include "perception/completion/training_sample.h"

#include "perception/completion/traced_solid.h"
#include "scenes/base/error.h"

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

void AppendTurned(const CompletionSample& sample, int turn, CompletionBatch& batch) {
  const std::vector<int8_t> channels = TurnedChannels(sample.channels, turn);
  batch.channels.insert(batch.channels.end(), channels.begin(), channels.end());
  const size_t first = batch.queries.size();
  batch.queries.insert(batch.queries.end(), sample.queries.begin(), sample.queries.end());
  for (size_t i = first; i < batch.queries.size(); i += kQueryValues) {
    TurnPlace(turn, batch.queries.data() + i);
  }
  batch.inside.insert(batch.inside.end(), sample.inside.begin(), sample.inside.end());
  if (!sample.volume.empty()) {
    const std::vector<int8_t> volume = TurnedChannels(sample.volume, turn);
    batch.volumes.insert(batch.volumes.end(), volume.begin(), volume.end());
  }
  batch.points = static_cast<int>(sample.inside.size());
  ++batch.count;
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
