#include "eval/python/arrays.h"

#include <fmt/format.h>

#include <cmath>
#include <cstring>

#include "scenes/base/error.h"

namespace pickbed::eval {
namespace {

namespace py = pybind11;

using Matrix4 = Eigen::Matrix<double, 4, 4, Eigen::RowMajor>;
using Matrix3 = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;

std::string ShapeText(const py::array& array) {
  std::string text;
  for (py::ssize_t i = 0; i < array.ndim(); ++i) {
    text += fmt::format("{}{}", i > 0 ? " x " : "", array.shape(i));
  }
  return array.ndim() > 0 ? text : "a single number";
}

std::string TypeText(const py::array& array) {
  return py::str(py::reinterpret_borrow<py::object>(array.dtype()));
}

// Throws InputError unless the value is an array of one of these kinds of NumPy: "f", "i", "u".
py::array ArrayFrom(py::handle value, const std::string& name, std::string_view kinds,
                    const std::string& wanted) {
  const py::array array = py::array::ensure(value);
  if (!array) {
    PyErr_Clear();
    const std::string type = py::str(py::type::of(value).attr("__name__"));
    throw InputError(fmt::format("{} must be {}, not a value of type {}", name, wanted, type));
  }
  CheckInput(kinds.find(array.dtype().kind()) != std::string_view::npos,
             fmt::format("{} must be {}, not an array of {}", name, wanted, TypeText(array)));
  return array;
}

void RequireShape(const py::array& array, const std::string& name,
                  std::initializer_list<py::ssize_t> shape) {
  bool is_equal = array.ndim() == static_cast<py::ssize_t>(shape.size());
  std::string text;
  py::ssize_t i = 0;
  for (const py::ssize_t size : shape) {
    is_equal = is_equal && array.shape(i) == size;
    text += fmt::format("{}{}", i > 0 ? " x " : "", size);
    ++i;
  }
  CheckInput(is_equal, fmt::format("{} must be {}, not {}", name, text, ShapeText(array)));
}

// Numbers of any real type as doubles, in row order.
py::array_t<double, py::array::c_style | py::array::forcecast> Doubles(const py::array& array) {
  return py::array_t<double, py::array::c_style | py::array::forcecast>(array);
}

constexpr char kNumbers[] = "fiu";

// An array over memory that `owner` keeps alive. It is read-only.
template <typename T>
py::array ReadOnly(const T* data, std::vector<py::ssize_t> shape, py::handle owner) {
  py::array_t<T> array(std::move(shape), data, owner);
  array.attr("setflags")(py::arg("write") = false);
  return array;
}

}  // namespace

py::array ArrayOf(const Pose& X) {
  py::array_t<double> array({4, 4});
  Eigen::Map<Matrix4>(array.mutable_data()) = X.matrix();
  return array;
}

py::array ArrayOf(std::span<const Pose> poses) {
  py::array_t<double> array(
      {static_cast<py::ssize_t>(poses.size()), py::ssize_t{4}, py::ssize_t{4}});
  for (size_t i = 0; i < poses.size(); ++i) {
    Eigen::Map<Matrix4>(array.mutable_data() + 16 * i) = poses[i].matrix();
  }
  return array;
}

py::array ArrayOf(const Eigen::Vector3d& v) {
  py::array_t<double> array(3);
  Eigen::Map<Eigen::Vector3d>(array.mutable_data()) = v;
  return array;
}

py::array CameraMatrix(const CameraIntrinsics& camera) {
  py::array_t<double> array({3, 3});
  Eigen::Map<Matrix3> K(array.mutable_data());
  K << camera.fx(), 0, camera.cx(), 0, camera.fy(), camera.cy(), 0, 0, 1;
  return array;
}

py::array Share(const Image<Rgb8>& image, py::handle owner) {
  static_assert(sizeof(Rgb8) == 3);
  return ReadOnly(reinterpret_cast<const uint8_t*>(image.data()),
                  {image.height(), image.width(), 3}, owner);
}

py::array Share(const Image<float>& image, py::handle owner) {
  return ReadOnly(image.data(), {image.height(), image.width()}, owner);
}

py::array Share(const Image<uint16_t>& image, py::handle owner) {
  return ReadOnly(image.data(), {image.height(), image.width()}, owner);
}

py::array Share(const std::vector<Eigen::Vector3d>& points, py::handle owner) {
  static_assert(sizeof(Eigen::Vector3d) == 3 * sizeof(double));
  return ReadOnly(reinterpret_cast<const double*>(points.data()),
                  {static_cast<py::ssize_t>(points.size()), 3}, owner);
}

py::array Share(const std::vector<Eigen::Vector3i>& indices, py::handle owner) {
  static_assert(sizeof(Eigen::Vector3i) == 3 * sizeof(int));
  return ReadOnly(reinterpret_cast<const int*>(indices.data()),
                  {static_cast<py::ssize_t>(indices.size()), 3}, owner);
}

Pose PoseFrom(py::handle value, const std::string& name, bool as_given) {
  const py::array array = ArrayFrom(value, name, kNumbers, "a pose of 4 x 4 numbers");
  RequireShape(array, name, {4, 4});
  const auto doubles = Doubles(array);
  const Matrix4 matrix = Eigen::Map<const Matrix4>(doubles.data());
  CheckInput(matrix.allFinite(), name + " has a value that is not finite");
  CheckInput(matrix.row(3).isApprox(Eigen::RowVector4d(0, 0, 0, 1), 1e-9),
             name + " has another last row than [0, 0, 0, 1]");
  const Eigen::Matrix3d R = matrix.topLeftCorner<3, 3>();
  const Eigen::Matrix3d proper = ProperRotation(R, name);
  return MakePose(as_given ? R : proper, matrix.topRightCorner<3, 1>());
}

CameraIntrinsics IntrinsicsFrom(py::handle value, int width, int height) {
  const py::array array = ArrayFrom(value, "K", kNumbers, "a camera matrix of 3 x 3 numbers");
  RequireShape(array, "K", {3, 3});
  const auto doubles = Doubles(array);
  const Matrix3 K = Eigen::Map<const Matrix3>(doubles.data());
  CheckInput(K(0, 1) == 0 && K(1, 0) == 0 && K.row(2) == Eigen::RowVector3d(0, 0, 1),
             "K must be [[fx, 0, cx], [0, fy, cy], [0, 0, 1]]");
  return {width, height, K(0, 0), K(1, 1), K(0, 2), K(1, 2)};
}

Image<float> DepthFrom(py::handle value, const CameraIntrinsics& camera) {
  const py::array array = ArrayFrom(value, "depth_m", "f", "an image of float32 in metres");
  RequireShape(array, "depth_m", {camera.height(), camera.width()});
  const py::array_t<float, py::array::c_style | py::array::forcecast> floats(array);
  Image<float> depth_m(camera.width(), camera.height());
  std::memcpy(depth_m.data(), floats.data(), depth_m.size() * sizeof(float));
  for (const float depth : depth_m.pixels()) {
    CheckInput(std::isfinite(depth) && depth >= 0,
               fmt::format("depth_m has the value {}; a pixel without a reading is 0", depth));
  }
  return depth_m;
}

Image<Rgb8> ColorFrom(py::handle value, const CameraIntrinsics& camera) {
  const py::array array = ArrayFrom(value, "color", "u", "an image of uint8");
  CheckInput(array.itemsize() == 1,
             fmt::format("color must be an image of uint8, not an array of {}", TypeText(array)));
  RequireShape(array, "color", {camera.height(), camera.width(), 3});
  const py::array_t<uint8_t, py::array::c_style | py::array::forcecast> bytes(array);
  Image<Rgb8> color(camera.width(), camera.height());
  std::memcpy(color.data(), bytes.data(), 3 * color.size());
  return color;
}

uint64_t NumberFrom(py::handle value, const std::string& name, uint64_t max) {
  const auto number = py::reinterpret_steal<py::object>(PyNumber_Index(value.ptr()));
  if (!number) PyErr_Clear();
  const bool is_valid = number && number >= py::int_(0) && number <= py::int_(max);
  CheckInput(is_valid, fmt::format("{} = {}: must be a whole number from 0 to {}", name,
                                   std::string(py::repr(value)), max));
  return number.cast<uint64_t>();
}

std::vector<double> NumbersFrom(py::handle value, const std::string& name) {
  const py::array array = ArrayFrom(value, name, kNumbers, "a list of numbers");
  CheckInput(array.ndim() == 1,
             fmt::format("{} must be a list of numbers, not {}", name, ShapeText(array)));
  const auto doubles = Doubles(array);
  std::vector<double> numbers(doubles.data(), doubles.data() + doubles.size());
  for (const double number : numbers) {
    CheckInput(std::isfinite(number), fmt::format("{} has the value {}", name, number));
  }
  return numbers;
}

}  // namespace pickbed::eval
