#include "scenes/ply_writer.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <stdexcept>

namespace pickbed {

static_assert(std::endian::native == std::endian::little, "floats are written as they lie");

std::string PlyCloudBytes(std::span<const Eigen::Vector3f> points,
                          std::span<const Eigen::Vector3f> rgb) {
  if (points.size() != rgb.size()) throw std::logic_error("a PLY needs a colour for each point");
  std::string bytes = fmt::format(
      "ply\nformat binary_little_endian 1.0\nelement vertex {}\n"
      "property float x\nproperty float y\nproperty float z\n"
      "property uchar red\nproperty uchar green\nproperty uchar blue\nend_header\n",
      points.size());
  for (size_t i = 0; i < points.size(); ++i) {
    char xyz[3 * sizeof(float)];
    std::memcpy(xyz, points[i].data(), sizeof(xyz));
    bytes.append(xyz, sizeof(xyz));
    for (const float channel : rgb[i]) {
      bytes += static_cast<char>(std::lround(255 * std::clamp(channel, 0.f, 1.f)));
    }
  }
  return bytes;
}

}  // namespace pickbed
