#pragma once

#include <gmock/gmock.h>

#include <functional>
#include <limits>
#include <span>
#include <string>

#include "tests/support/error_of.h"

namespace pickbed::tests {

inline constexpr double kNotANumber = std::numeric_limits<double>::quiet_NaN();

// A call of a library with one option out of range, and the key that its error must name.
struct PlantedOption {
  const char* key;
  std::function<void()> call;
};

// Expects that each call is refused with an error that names the key and what is allowed.
inline void ExpectRefused(std::span<const PlantedOption> planted) {
  for (const PlantedOption& row : planted) {
    const std::string error = ErrorOf(row.call);
    EXPECT_THAT(error, ::testing::HasSubstr(std::string(row.key) + " ")) << row.key;
    EXPECT_THAT(error, ::testing::AnyOf(::testing::HasSubstr("must be a number from "),
                                        ::testing::HasSubstr("known: ")))
        << row.key;
  }
}

}  // namespace pickbed::tests
