#include "tests/fuzz/targets.h"

#include <iterator>

#include "scenes/base/error.h"
#include "tests/fuzz/format_targets.h"

namespace pickbed::tests {
namespace {

// The targets of each format.
constexpr std::vector<FuzzTarget> (*kFormats[])() = {
    SettingsTargets, MeshTargets,  ImageTargets, FrameTargets,   DatasetTargets,
    StoreTargets,    ModelTargets, GraspTargets, MessageTargets, CacheTargets,
};

std::vector<FuzzTarget> MakeTargets() {
  std::vector<FuzzTarget> targets;
  for (const auto& make : kFormats) {
    std::vector<FuzzTarget> more = make();
    std::move(more.begin(), more.end(), std::back_inserter(targets));
  }
  return targets;
}

}  // namespace

std::span<const FuzzTarget> FuzzTargets() {
  static const std::vector<FuzzTarget> targets = MakeTargets();
  return targets;
}

const FuzzTarget& FindFuzzTarget(const std::string& name) {
  std::vector<std::string> names;
  for (const FuzzTarget& target : FuzzTargets()) {
    if (target.name == name) return target;
    names.push_back(target.name);
  }
  throw InputError(UnknownNameMessage("target", name, names));
}

}  // namespace pickbed::tests
