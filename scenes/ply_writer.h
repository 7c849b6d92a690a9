#pragma once

// Point clouds as PLY files.

#include <Eigen/Core>
#include <span>
#include <string>

namespace pickbed {

// The bytes of a binary little-endian PLY with x y z (float, m) and red green blue (uchar) of each
// point. Colours are sRGB, 0..1, one a point; std::logic_error otherwise. Same input, same bytes.
std::string PlyCloudBytes(std::span<const Eigen::Vector3f> points,
                          std::span<const Eigen::Vector3f> rgb);

}  // namespace pickbed
