#include "sim/drop/fill_counts.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <sstream>

#include "scenes/base/cache_file.h"
#include "scenes/base/error.h"
#include "scenes/base/random.h"
#include "sim/drop/fill_level.h"

namespace pickbed::sim {
namespace {

constexpr int kMaxInstances = 2000;

// Distributes `total` instances over the objects in proportion to their shares, at least one each.
std::vector<int> Distributed(const std::vector<int>& shares, double total) {
  const double all = std::accumulate(shares.begin(), shares.end(), 0);
  std::vector<int> counts;
  for (const int share : shares) {
    counts.push_back(std::max(1, static_cast<int>(std::lround(total * share / all))));
  }
  return counts;
}

double Total(const std::vector<int>& counts) {
  return std::accumulate(counts.begin(), counts.end(), 0.0);
}

double MeanVolume_m3(const ObjectSet& objects, const std::vector<int>& shares) {
  double sum_m3 = 0;
  for (size_t i = 0; i < objects.size(); ++i) sum_m3 += shares[i] * objects[i]->mass.volume_m3;
  return sum_m3 / Total(shares);
}

// A drop for the measurement of a fill level.
struct MeasuredDrop {
  double instances = 0, level = 0;
  bool is_lost = false;  // an instance fell out of the bin
};

// Throws unless bins of the final number of instances have nearly the wanted level. A few large
// instances pile up differently in each bin, and a certified scene has no instance outside.
void RequireSteadyLevel(const std::vector<MeasuredDrop>& drops, double fill, double final_total) {
  constexpr double kMaxDeviation = 0.25;  // of the wanted level
  double lowest = fill, highest = fill;
  int lost = 0;
  for (size_t i = 1; i < drops.size(); ++i) {  // the count of the first one is only a guess
    const double level = drops[i].level * final_total / drops[i].instances;
    lowest = std::min(lowest, level);
    highest = std::max(highest, level);
    lost += drops[i].is_lost;
  }
  CheckInput(
      lost < 2 && lowest > (1 - kMaxDeviation) * fill && highest < (1 + kMaxDeviation) * fill,
      fmt::format("{} cannot be kept with these objects: bins of {:.0f} instances have levels of "
                  "{:.2f} to {:.2f}, and instances fall out in {} of {}; choose a lower fill, "
                  "smaller objects or a larger bin",
                  fill, final_total, lowest, highest, lost, drops.size() - 1));
}

// The height of a pile is nearly proportional to its number of instances. The ratio is taken over
// all drops, because the height varies by some percent from drop to drop.
std::vector<int> MeasuredCounts(const Bin& bin, const ObjectSet& objects,
                                const std::vector<int>& shares, double fill,
                                const DropOptions& options) {
  constexpr double kFirstPackedShare = 0.2;  // solid volume over the volume below the surface
  constexpr double kTolerance = 0.03;
  constexpr int kDrops = 3;
  constexpr uint64_t kSeed = 1;
  double total =
      fill * bin.inner_size_m.prod() * kFirstPackedShare / MeanVolume_m3(objects, shares);
  double sum_total = 0, sum_level = 0;
  std::vector<MeasuredDrop> drops;
  for (int drop = 0; drop < kDrops; ++drop) {
    CheckInput(total <= kMaxInstances,
               fmt::format("{} takes over {} instances; use larger objects, a smaller bin or a "
                           "lower fill",
                           fill, kMaxInstances));
    const std::vector<int> counts = Distributed(shares, total);
    Rng rng = Rng::Derive(kSeed, BinIndex(drop), "fill");
    const DropResult result = DropInstances(bin, objects, counts, rng, options);
    const double level = MeasureFill(result.scene, objects).fill_level;
    // Instances over the rim fall out, so that more of them do not raise the level.
    const int outside = result.certificate.instances_outside;
    CheckInput(outside == 0 || level > fill * (1 - kTolerance),
               fmt::format("{} cannot be reached with these objects; at level {:.2f}, {} of "
                           "{} instances have fallen out of the bin; choose a lower fill",
                           fill, level, outside, Total(counts)));
    CheckInput(level > 0, fmt::format("{} cannot be measured: no instance is in the bin, or they "
                                      "are too small for it; use larger objects or a smaller bin",
                                      fill));
    drops.push_back({Total(counts), level, outside > 0});
    sum_total += Total(counts);
    sum_level += level;
    total = sum_total * fill / sum_level;
  }
  RequireSteadyLevel(drops, fill, total);
  const std::vector<int> counts = Distributed(shares, total);
  const double expected = fill * Total(counts) / total;
  CheckInput(expected < 1.5 * fill,
             fmt::format("{} is less than one instance of each object, which fill {:.2g}; choose a "
                         "higher fill or smaller objects",
                         fill, expected));
  return counts;
}

std::filesystem::path FileOf(const Bin& bin, const ObjectSet& objects,
                             const std::vector<int>& shares, double fill,
                             const DropOptions& options) {
  constexpr int kVersion = 3;  // raise it when drops or the measurement change
  DropOptions copy = options;
  std::string key = fmt::format("{} {} {} {} {} {} {} {}", kVersion, bin.inner_size_m.x(),
                                bin.inner_size_m.y(), bin.inner_size_m.z(), bin.wall_m,
                                bin.friction, fill, static_cast<int>(options.arrangement));
  if (bin.shape) key += fmt::format(" {:016x}", MeshHash(bin.shape->mesh_B));
  key += WriteSettingsKey([&](SettingsVisitor& v) { copy.Visit(v); });
  for (size_t i = 0; i < objects.size(); ++i) {
    const ObjectModel& model = *objects[i];
    key += fmt::format(" {:016x} {} {} {}", model.mesh_hash, shares[i], model.friction,
                       model.mass.mass_kg);
    for (const double x : model.mass.com_O) key += fmt::format(" {}", x);
    for (const double x : model.mass.inertia_com_O.reshaped()) key += fmt::format(" {}", x);
  }
  uint64_t hash = HashBytes(key.data(), key.size());
  for (const auto& object : objects) {
    for (const ConvexPiece& piece : object->convex_pieces_O) {
      const std::vector<Eigen::Vector3d>& vertices = piece.vertices_O;
      hash = HashBytes(vertices.data(), vertices.size() * sizeof(vertices[0]), hash);
    }
  }
  return CacheDir() / "fill" / fmt::format("{:016x}.txt", hash);
}

std::string CountsText(const std::vector<int>& counts) {
  return fmt::format("{}", fmt::join(counts, " "));
}

std::vector<int> CountsFrom(const std::string& content, size_t objects) {
  std::istringstream text(content);
  std::vector<int> counts;
  for (int count = 0; text >> count;) counts.push_back(count);
  const bool valid = counts.size() == objects && std::ranges::all_of(counts, [](int count) {
                       return count >= 1 && count <= kMaxInstances;
                     });
  CheckInput(valid, "its counts do not fit the objects");
  return counts;
}

}  // namespace

std::vector<int> CountsForFill(const Bin& bin, const ObjectSet& objects,
                               const std::vector<int>& shares, double fill,
                               const DropOptions& options) {
  CheckInput(bin.inner_size_m.z() > 0,
             fmt::format("{}: a table has no height; give each object a count", fill));
  const std::filesystem::path file = FileOf(bin, objects, shares, fill, options);
  return Cached(
      file, [&](const std::string& content) { return CountsFrom(content, objects.size()); },
      [&] { return MeasuredCounts(bin, objects, shares, fill, options); }, CountsText);
}

}  // namespace pickbed::sim
