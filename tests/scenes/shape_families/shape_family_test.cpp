#include "scenes/shape_families/shape_family.h"

#include <gtest/gtest.h>

#include "tests/support/error_of.h"

// The table of shape_family.cpp and the families of families_free.cpp, families_packages.cpp,
// families_pipes.cpp, families_sheet.cpp, families_turned.cpp and families_vessels.cpp.

namespace pickbed::tests {
namespace {

TEST(ShapeFamily, SameSeedGivesTheSameShape) {
  for (const ShapeFamilyRow& row : ShapeFamilyTable()) {
    const SampledShape a = SampleShape(row, ShapeSplit::kSeen, 5);
    EXPECT_EQ(a.solid.hash(), SampleShape(row, ShapeSplit::kSeen, 5).solid.hash()) << row.name;
    EXPECT_NE(a.solid.hash(), SampleShape(row, ShapeSplit::kSeen, 6).solid.hash()) << row.name;
  }
}

TEST(ShapeFamily, UnknownNameGivesTheNearest) {
  EXPECT_EQ(ErrorOf([] { FindShapeFamily("cupp"); }).find("unknown shape family 'cupp'"), 0u);
}

}  // namespace
}  // namespace pickbed::tests
