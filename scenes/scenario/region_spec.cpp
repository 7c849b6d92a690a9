#include "scenes/scenario/region_spec.h"

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <vector>

#include "scenes/base/error.h"

namespace pickbed::scenes {
namespace {

constexpr double kFarthest_m = 100;

std::vector<double> NumbersOf(const std::string& text) {
  std::vector<double> numbers;
  for (const char *at = text.data(), *const last = at + text.size(); at < last;) {
    double number = 0;
    const auto [end, error] = std::from_chars(at, last, number);
    if (error != std::errc() || !std::isfinite(number)) return {};
    numbers.push_back(number);
    if (end < last && *end != ',') return {};
    at = end + 1;
  }
  return numbers;
}

}  // namespace

void RegionSpec::Visit(SettingsVisitor& v) {
  v.Text("frame", frame, {"world", "camera"}, "frame of the box");
  v.Vector3("min_m", min_m, {-kFarthest_m, kFarthest_m},
            "smallest x, y, z of the box, m; equal to max_m = no box");
  v.Vector3("max_m", max_m, {-kFarthest_m, kFarthest_m}, "largest x, y, z of the box, m");
  v.Text("mask", mask, {},
         "image of the camera's size whose pixels over 0 are in the region; empty = no mask");
  v.Bool("automatic", automatic,
         "use the depth range in which the largest object has a useful size in the image");
}

void RegionSpec::Validate(const std::string& key) const {
  const int kinds = !mask.empty() + automatic + has_box();
  CheckInput(kinds <= 1, key + ": give only one of a box (min_m, max_m), mask and automatic");
  CheckInput(!has_box() || (max_m.array() > min_m.array()).all(),
             fmt::format("{}: the box from [{:g}, {:g}, {:g}] to [{:g}, {:g}, {:g}] has no volume; "
                         "give max_m over min_m in x, y and z",
                         key, min_m.x(), min_m.y(), min_m.z(), max_m.x(), max_m.y(), max_m.z()));
}

RegionSpec ParseRegion(const std::string& text) {
  RegionSpec region;
  const size_t colon = text.find(':');
  const std::string kind = text.substr(0, colon);
  if (text == "auto") {
    region.automatic = true;
  } else if (kind == "world" || kind == "camera") {
    const std::vector<double> n =
        NumbersOf(colon == std::string::npos ? "" : text.substr(colon + 1));
    CheckInput(n.size() == 6,
               fmt::format("region '{}': give two corners in m as {}:X,Y,Z,X,Y,Z", text, kind));
    const Eigen::Vector3d a(n[0], n[1], n[2]), b(n[3], n[4], n[5]);
    region.frame = kind;
    region.min_m = a.cwiseMin(b);
    region.max_m = a.cwiseMax(b);
    CheckInput((region.max_m.array() > region.min_m.array()).all(),
               fmt::format("region '{}': the box has no volume; give two opposite corners", text));
  } else {
    CheckInput(!text.empty(),
               "region '': give auto, world:X,Y,Z,X,Y,Z, camera:X,Y,Z,X,Y,Z or a mask image");
    region.mask = text;
  }
  return region;
}

}  // namespace pickbed::scenes
