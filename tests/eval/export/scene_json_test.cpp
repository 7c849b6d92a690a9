#include "eval/export/scene_json.h"

#include <gtest/gtest.h>

#include <sstream>

#include "tests/support/layer.h"

namespace pickbed::tests {
namespace {

TEST(CertificateText, ValuesAreInOneColumnApartFromTheirNames) {
  CertifiedScene made;
  made.certificate.simulated_s = 3.25;
  made.refused = {{12, {"not at rest"}}};
  std::istringstream lines(CertificateText(made));
  size_t column = 0;
  int count = 0;
  for (std::string line; std::getline(lines, line); ++count) {
    const size_t gap = line.find("  ", 2);  // after the indent
    ASSERT_NE(gap, std::string::npos) << line;
    const size_t value = line.find_first_not_of(' ', gap);
    if (column == 0) column = value;
    EXPECT_EQ(value, column) << line;
  }
  EXPECT_EQ(count, 6);
}

}  // namespace
}  // namespace pickbed::tests
