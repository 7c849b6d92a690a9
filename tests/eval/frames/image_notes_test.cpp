#include "eval/frames/image_notes.h"

#include <gtest/gtest.h>

namespace pickbed::tests {
namespace {

TEST(DatasetImagesCsv, HasOneLinePerImageAndQuotesWarnings) {
  const std::vector<DatasetImageNote> images{
      {1, 2, 3, true, {}}, {4, 5, 0, false, {"no reading; or \"none\"", "too steep"}}};
  EXPECT_EQ(DatasetImagesCsv(images),
            "scene_id,im_id,poses,background_recognised,warnings\n"
            "1,2,3,1,\n"
            "4,5,0,0,\"no reading; or \"\"none\"\" | too steep\"\n");
  EXPECT_EQ(DatasetImagesCsv({}), HeaderLine(DatasetImageColumns()));
}

}  // namespace
}  // namespace pickbed::tests
