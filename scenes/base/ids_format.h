#pragma once

// Formats ids as their number: fmt::format("{}", instance). A source that formats ids includes it.

#include <fmt/format.h>

#include "scenes/base/ids.h"

template <typename Kind>
struct fmt::formatter<pickbed::scenes::Id<Kind>> : fmt::formatter<int> {
  template <typename Context>
  auto format(pickbed::scenes::Id<Kind> id, Context& context) const {
    return fmt::formatter<int>::format(int{id}, context);
  }
};
