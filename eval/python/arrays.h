#pragma once

// Conversion between NumPy arrays and the types of pickbed. Images become read-only arrays that
// share the memory of their image. Arrays from Python are checked: a wrong type, shape or value
// throws InputError with the name of the argument.

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "eval/layer.h"
#include "scenes/camera/camera.h"
#include "scenes/geometry/pose.h"
#include "scenes/image/image.h"

namespace pickbed::eval {

// Returns a 4 x 4 array.
pybind11::array ArrayOf(const Pose& X);
// Returns a 3 x 3 array: the camera matrix.
pybind11::array CameraMatrix(const CameraIntrinsics& camera);
// Returns an array of shape (n, 4, 4).
pybind11::array ArrayOf(std::span<const Pose> poses);
// Returns an array of shape (n,).
pybind11::array ArrayOf(const Eigen::Vector3d& v);

// Read-only arrays that share memory with their argument. `owner` keeps it alive.
pybind11::array Share(const Image<Rgb8>& image, pybind11::handle owner);      // (height, width, 3)
pybind11::array Share(const Image<float>& image, pybind11::handle owner);     // (height, width)
pybind11::array Share(const Image<uint16_t>& image, pybind11::handle owner);  // (height, width)
pybind11::array Share(const std::vector<Eigen::Vector3d>& points,
                      pybind11::handle owner);  // (n, 3)
pybind11::array Share(const std::vector<Eigen::Vector3i>& indices, pybind11::handle owner);

// Reads a pose: 4 x 4 finite numbers with a proper rotation and the last row [0, 0, 0, 1]. See
// ProperRotation() in scenes/geometry/pose.h. With `as_given`, a small error of the rotation is
// accepted, but not corrected.
Pose PoseFrom(pybind11::handle value, const std::string& name, bool as_given = false);
// Reads a camera matrix without skew. The image size is in px.
CameraIntrinsics IntrinsicsFrom(pybind11::handle K, int width, int height);
// Reads a depth image in metres, of a floating-point type and with 0 = no reading. Its size must be
// the one of the camera.
Image<float> DepthFrom(pybind11::handle value, const CameraIntrinsics& camera);
// Reads a color image: (height, width, 3) of uint8. Its size must be the one of the camera.
Image<Rgb8> ColorFrom(pybind11::handle value, const CameraIntrinsics& camera);
// Reads a whole number from 0 to `max`, also one of NumPy.
uint64_t NumberFrom(pybind11::handle value, const std::string& name, uint64_t max);
// Reads a list of finite numbers.
std::vector<double> NumbersFrom(pybind11::handle value, const std::string& name);

}  // namespace pickbed::eval
