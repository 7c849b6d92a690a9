#include "scenes/shape_families/sampled_names.h"

#include <fmt/format.h>

#include <array>
#include <charconv>

#include "scenes/base/error.h"
#include "scenes/base/random.h"

namespace pickbed::scenes {
namespace {

constexpr char kPrefix[] = "sampled/";
constexpr char kUnseenFamilies[] = "unseen_families";

std::vector<std::string> SplitAtSlashes(const std::string& text) {
  std::vector<std::string> fields;
  size_t begin = 0;
  while (true) {
    const size_t end = text.find('/', begin);
    fields.push_back(text.substr(begin, end - begin));
    if (end == std::string::npos) return fields;
    begin = end + 1;
  }
}

// Returns whether the text is a whole number, and parses it.
bool ParseSeed(const std::string& digits, uint64_t& seed) {
  const char* last = digits.data() + digits.size();
  const auto [end, error] = std::from_chars(digits.data(), last, seed);
  return error == std::errc() && end == last;
}

bool IsDomain(const std::string& what) {
  return what == ShapeDomainName(ShapeDomain::kMachine) ||
         what == ShapeDomainName(ShapeDomain::kSupermarket);
}

}  // namespace

bool IsSampledName(const std::string& name) { return name.starts_with(kPrefix); }

SampledShape SampleShapeOf(const std::string& what, const std::string& split, uint64_t seed) {
  if (!IsDomain(what)) {
    CheckInput(split != kUnseenFamilies,
               fmt::format("split '{}' needs a domain (machine, supermarket), not the family '{}'",
                           kUnseenFamilies, what));
    return SampleShape(FindShapeFamily(what), ShapeSplitFromName(split), seed);
  }
  const bool held_out = split == kUnseenFamilies;
  const ShapeSplit sizes = held_out ? ShapeSplit::kSeen : ShapeSplitFromName(split);
  const auto rows = ShapeFamiliesOf(ShapeDomainFromName(what), held_out);
  Rng rng = Rng::Derive(seed, 0, "family of " + what);
  return SampleShape(*rows[rng.Index(static_cast<int>(rows.size()))], sizes, seed);
}

SampledShape SampleShapeByName(const std::string& name) {
  const std::vector<std::string> fields = SplitAtSlashes(name);
  CheckInput(IsSampledName(name) && (fields.size() == 3 || fields.size() == 4),
             fmt::format("object '{}': a sampled shape is written sampled/FAMILY/SEED or "
                         "sampled/FAMILY/SPLIT/SEED",
                         name));
  const std::string& digits = fields.back();
  uint64_t seed = 0;
  CheckInput(ParseSeed(digits, seed),
             fmt::format("object '{}': the seed '{}' is not a whole number", name, digits));
  return SampleShapeOf(fields[1], fields.size() == 4 ? fields[2] : "seen", seed);
}

std::vector<std::string> SampledNamesIn(const std::string& name) {
  const size_t slash = name.rfind('/');
  const size_t dash = name.find('-', slash == std::string::npos ? 0 : slash);
  // "sampled/cup/-1" is a malformed seed, not a range.
  if (!IsSampledName(name) || dash == std::string::npos || dash == slash + 1) return {name};
  uint64_t first = 0, last = 0;
  CheckInput(
      ParseSeed(name.substr(slash + 1, dash - slash - 1), first) &&
          ParseSeed(name.substr(dash + 1), last) && first <= last,
      fmt::format("object '{}': '{}' is not a range of seeds; write FIRST-LAST, such as 0-39", name,
                  name.substr(slash + 1)));
  CheckInput(last - first < static_cast<uint64_t>(kMaxSampledShapes),
             fmt::format("object '{}': the range has more than {} seeds; make it smaller", name,
                         kMaxSampledShapes));
  std::vector<std::string> names;
  // The range may end at the largest number, so `last` is no end of a loop.
  for (uint64_t i = 0; i <= last - first; ++i) {
    names.push_back(fmt::format("{}/{}", name.substr(0, slash), first + i));
  }
  return names;
}

Rgb8 SampledColor(const SampledShape& shape) {
  // Metals and painted metal; printed packages, glazes and plastics.
  static constexpr std::array<Rgb8, 6> kMachine{{{176, 176, 180},
                                                 {140, 142, 148},
                                                 {198, 186, 150},
                                                 {96, 100, 108},
                                                 {184, 120, 84},
                                                 {72, 104, 140}}};
  static constexpr std::array<Rgb8, 8> kSupermarket{{{206, 52, 44},
                                                     {28, 84, 156},
                                                     {246, 190, 40},
                                                     {236, 232, 220},
                                                     {64, 140, 72},
                                                     {226, 128, 48},
                                                     {150, 72, 132},
                                                     {88, 168, 188}}};
  Rng rng = Rng::Derive(shape.seed, 0, std::string("color ") + shape.family->name);
  return shape.family->domain == ShapeDomain::kMachine ? kMachine[rng.Index(6)]
                                                       : kSupermarket[rng.Index(8)];
}

}  // namespace pickbed::scenes
