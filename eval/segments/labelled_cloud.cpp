#include "eval/segments/labelled_cloud.h"

#include <algorithm>
#include <string>

#include "eval/frames/cloud_file.h"
#include "scenes/base/error.h"

namespace pickbed::eval {

LabelledCloud ReadLabelledCloud(const std::filesystem::path& file) {
  const std::string name = file.string();
  const CloudFile points = ReadCloudFile(file);
  const CloudFile::Field* label = points.Find("label");
  CheckInput(label != nullptr, name + ": the cloud has no field label; give x, y, z and label");
  LabelledCloud cloud;
  cloud.frame = FrameOfCloud(points, name);
  CheckInput(!label->is_float, name + ": field label has TYPE F; write it with TYPE U");
  cloud.labels = Image<uint16_t>(points.width, points.height);
  std::ranges::transform(label->words, cloud.labels.pixels().begin(), [](uint32_t word) {
    return static_cast<uint16_t>(std::min<uint32_t>(word, 0xffff));
  });
  return cloud;
}

}  // namespace pickbed::eval
