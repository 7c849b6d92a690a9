#include "scenes/shape_families/shape_family.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "scenes/base/error.h"
#include "scenes/base/random.h"
#include "scenes/shape_families/family_rows.h"

namespace pickbed::scenes {
namespace {

// Held-out intervals of a parameter, as shares of its range. The other shares are seen.
struct Interval {
  double low, high;
};
constexpr std::array<Interval, 3> kHeldOut{{{0.15, 0.25}, {0.45, 0.55}, {0.75, 0.85}}};
constexpr std::array<Interval, 4> kSeen{{{0, 0.15}, {0.25, 0.45}, {0.55, 0.75}, {0.85, 1}}};
// An outside value is beyond an end of the range by at most this share of it.
constexpr double kBeyond = 0.25;
// Among the whole numbers of a range, every third one is held out. Shorter ranges have no split.
constexpr int kWholePeriod = 3;

// Draws uniformly from the union of intervals.
template <size_t N>
double DrawFrom(const std::array<Interval, N>& intervals, Rng& rng) {
  double total = 0;
  for (const Interval& i : intervals) total += i.high - i.low;
  double at = rng.Uniform(0, total);
  for (const Interval& i : intervals) {
    if (at < i.high - i.low) return i.low + at;
    at -= i.high - i.low;
  }
  return intervals.back().low;
}

double DrawWhole(const ShapeParameter& p, bool held_out, Rng& rng) {
  const int count = static_cast<int>(p.high - p.low) + 1;
  if (count < kWholePeriod) return p.low + rng.Index(count);
  while (true) {
    const int k = rng.Index(count);
    if ((k % kWholePeriod == 1) == held_out) return p.low + k;
  }
}

double DrawInside(const ShapeParameter& p, bool held_out, Rng& rng) {
  if (p.whole) return DrawWhole(p, held_out, rng);
  const double share = held_out ? DrawFrom(kHeldOut, rng) : DrawFrom(kSeen, rng);
  return p.low + share * (p.high - p.low);
}

double DrawOutside(const ShapeParameter& p, Rng& rng) {
  const bool above = rng.Index(2) == 1;
  const double range = p.high - p.low;
  if (p.whole) {
    const int beyond = 1 + rng.Index(std::max(1, static_cast<int>(kBeyond * range)));
    return above ? p.high + beyond : p.low - beyond;
  }
  const double beyond = range * (kBeyond - rng.Uniform(0, kBeyond));  // never 0
  return above ? p.high + beyond : p.low - beyond;
}

template <typename Value, size_t N>
Value ValueOf(const char* kind, const std::string& name,
              const std::array<std::pair<const char*, Value>, N>& names) {
  std::vector<std::string> known;
  for (const auto& [key, value] : names) {
    if (name == key) return value;
    known.emplace_back(key);
  }
  throw InputError(UnknownNameMessage(kind, name, known));
}

constexpr std::array<std::pair<const char*, ShapeDomain>, 2> kDomains{
    {{"machine", ShapeDomain::kMachine}, {"supermarket", ShapeDomain::kSupermarket}}};
constexpr std::array<std::pair<const char*, ShapeSplit>, 3> kSplits{
    {{"seen", ShapeSplit::kSeen},
     {"unseen_sizes", ShapeSplit::kUnseenSizes},
     {"outside", ShapeSplit::kOutside}}};

}  // namespace

std::span<const ShapeFamilyRow> ShapeFamilyTable() {
  static const std::vector<ShapeFamilyRow> table = [] {
    std::vector<ShapeFamilyRow> rows;
    for (const auto& families : {PipeFamilies(), TurnedFamilies(), SheetFamilies(),
                                 VesselFamilies(), PackageFamilies(), FreeFamilies()}) {
      rows.insert(rows.end(), families.begin(), families.end());
    }
    std::stable_sort(rows.begin(), rows.end(),
                     [](const auto& a, const auto& b) { return a.domain < b.domain; });
    return rows;
  }();
  return table;
}

const ShapeFamilyRow& FindShapeFamily(const std::string& name) {
  std::vector<std::string> names;
  for (const ShapeFamilyRow& row : ShapeFamilyTable()) {
    if (name == row.name) return row;
    names.emplace_back(row.name);
  }
  throw InputError(UnknownNameMessage("shape family", name, names));
}

std::string ShapeDomainName(ShapeDomain domain) {
  return kDomains[static_cast<size_t>(domain)].first;
}
std::string ShapeSplitName(ShapeSplit split) { return kSplits[static_cast<size_t>(split)].first; }
ShapeDomain ShapeDomainFromName(const std::string& name) {
  return ValueOf("domain", name, kDomains);
}
ShapeSplit ShapeSplitFromName(const std::string& name) { return ValueOf("split", name, kSplits); }

std::vector<const ShapeFamilyRow*> ShapeFamiliesOf(ShapeDomain domain, bool held_out) {
  std::vector<const ShapeFamilyRow*> rows;
  for (const ShapeFamilyRow& row : ShapeFamilyTable()) {
    if (row.domain == domain && row.held_out == held_out) rows.push_back(&row);
  }
  return rows;
}

SampledShape SampleShape(const ShapeFamilyRow& family, ShapeSplit split, uint64_t seed) {
  SampledShape sample;
  sample.family = &family;
  sample.split = split;
  sample.seed = seed;
  Rng rng = Rng::Derive(seed, 0, std::string("shape ") + family.name + " " + ShapeSplitName(split));
  const int count = static_cast<int>(family.parameters.size());
  // One parameter is outside in any case, and each other one with probability 1/2.
  const int surely_outside = split == ShapeSplit::kOutside ? rng.Index(count) : -1;
  for (int i = 0; i < count; ++i) {
    const ShapeParameter& p = family.parameters[i];
    const bool outside =
        split == ShapeSplit::kOutside && (i == surely_outside || rng.Index(2) == 1);
    sample.values.push_back(outside ? DrawOutside(p, rng)
                                    : DrawInside(p, split == ShapeSplit::kUnseenSizes, rng));
  }
  const FamilySolid made = family.make(sample.values);
  sample.solid = CompiledSolid(made.solid, made.min_wall_mm);
  return sample;
}

}  // namespace pickbed::scenes
