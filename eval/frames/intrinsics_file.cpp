#include "eval/frames/intrinsics_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <string_view>
#include <vector>

#include "scenes/base/error.h"
#include "scenes/base/files.h"
#include "scenes/base/message_text.h"
#include "scenes/base/settings_tree.h"

namespace pickbed::eval {
namespace {

constexpr size_t kMatrixEntries = 9;

// Returns the numbers of a text, separated by commas, spaces and brackets; nullopt if it has other
// words.
std::optional<std::vector<double>> NumbersIn(std::string_view text) {
  constexpr std::string_view kSeparators = " ,;[]\t\r\n";
  std::vector<double> numbers;
  while (true) {
    const size_t begin = text.find_first_not_of(kSeparators);
    if (begin == std::string_view::npos) return numbers;
    text.remove_prefix(begin);
    if (text.front() == '+') text.remove_prefix(1);
    double number = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
    if (error != std::errc() || !std::isfinite(number)) return std::nullopt;
    numbers.push_back(number);
    text.remove_prefix(end - text.data());
    if (!text.empty() && kSeparators.find(text.front()) == std::string_view::npos) {
      return std::nullopt;
    }
  }
}

// Whether a value says that there is none.
bool IsNothing(const SettingsTree& node) {
  constexpr std::array kNothing = {"", "~", "null", "Null", "NULL", "none", "None"};
  return node.kind == SettingsTree::Kind::kValue &&
         std::ranges::find(kNothing, node.text) != kNothing.end();
}

void AddNumbers(const SettingsTree& node, std::vector<double>& numbers) {
  if (node.kind == SettingsTree::Kind::kList) {
    for (const SettingsTree& item : node.items) AddNumbers(item, numbers);
    return;
  }
  const auto found = NumbersIn(node.text);
  CheckInput(found.has_value(), fmt::format("{}: '{}' is no number", node.place, node.text));
  numbers.insert(numbers.end(), found->begin(), found->end());
}

// Checks the size of a matrix with its data, as ROS and OpenCV write it.
void RequireSize(const SettingsTree& matrix, size_t numbers) {
  const SettingsTree *rows = matrix.Find("rows"), *columns = matrix.Find("cols");
  if (rows == nullptr || columns == nullptr || numbers == 0) return;
  std::vector<double> size;
  AddNumbers(*rows, size);
  AddNumbers(*columns, size);
  CheckInput(size.size() == 2 && size[0] * size[1] == static_cast<double>(numbers),
             fmt::format("{}: the matrix has {} numbers, not {} rows and {} columns; get the file "
                         "again",
                         matrix.place, numbers, rows->text, columns->text));
}

// Returns the numbers of the first of these keys that the map has. A map with `data`, as ROS and
// OpenCV write matrices, gives its data.
std::vector<double> NumbersOf(const SettingsTree& map, const std::vector<const char*>& keys) {
  std::vector<double> numbers;
  for (const char* key : keys) {
    const SettingsTree* node = map.Find(key);
    if (node == nullptr) continue;
    const SettingsTree* const matrix = node->kind == SettingsTree::Kind::kMap ? node : nullptr;
    if (matrix != nullptr) node = matrix->Find("data");
    if (node == nullptr && matrix->Find("rows") != nullptr) {
      throw InputError(fmt::format("{}: {} has no data; get the file again", matrix->place, key));
    }
    if (node == nullptr) continue;
    if (IsNothing(*node)) return numbers;
    AddNumbers(*node, numbers);
    if (matrix != nullptr) RequireSize(*matrix, numbers.size());
    return numbers;
  }
  return numbers;
}

std::optional<double> NumberOf(const SettingsTree& map, const std::vector<const char*>& keys,
                               const std::string& name) {
  const std::vector<double> numbers = NumbersOf(map, keys);
  if (numbers.empty()) return std::nullopt;
  CheckInput(numbers.size() == 1,
             fmt::format("{}: {} has {} numbers; give one", name, keys[0], numbers.size()));
  return numbers.front();
}

// Returns the width or height of the image; 0 if the file has none.
int SizeOf(const SettingsTree& map, const std::vector<const char*>& keys, const std::string& name) {
  constexpr double kMaxSide_px = 1e6;
  const double size = NumberOf(map, keys, name).value_or(0);
  CheckInput(size >= 0 && size <= kMaxSide_px && size == std::floor(size),
             fmt::format("{}: {} = {}: give the whole number of pixels", name, keys[0], size));
  return static_cast<int>(size);
}

void TakeMatrix(const std::vector<double>& k, const std::string& name, GivenIntrinsics& given) {
  const bool by_columns = k[2] == 0 && k[5] == 0 && k[6] != 0;
  given.fx = k[0];
  given.fy = k[4];
  given.cx = by_columns ? k[6] : k[2];
  given.cy = by_columns ? k[7] : k[5];
  const double skew = by_columns ? k[3] : k[1];
  const double opposite = by_columns ? k[1] : k[3];
  const double rest = by_columns ? 0 : std::max(std::abs(k[6]), std::abs(k[7]));
  CheckInput(skew == 0 && opposite == 0 && rest == 0 && k[8] == 1,
             name + ": the camera matrix is not fx 0 cx 0 fy cy 0 0 1; give such a matrix");
}

// Without these keys, a wrong scale of the depth, the size of another image or a distortion would
// not be noticed.
void RequireSoundKeys(const SettingsTree& map, const std::string& name) {
  const auto has = [&](const char* key) {
    return std::ranges::any_of(map.items, [&](const auto& item) { return item.key == key; });
  };
  for (const SettingsTree& item : map.items) {
    for (const char* key : {"depth_scale", "width", "height", "image_width", "image_height",
                            "distortion_coefficients", "dist_coeffs"}) {
      CheckInput(!IsDamagedKey(item.key, key) || has(key),
                 fmt::format("{}: has the unknown key '{}'; did you mean {}?", name,
                             OneLine(item.key), key));
    }
  }
}

// A YAML file that is cut within a key ends with a word.
void RequireNoCutKey(std::string_view text, const std::string& name) {
  const size_t line_end = text.rfind('\n');
  const std::string_view last = text.substr(line_end == text.npos ? 0 : line_end + 1);
  const bool is_word = !last.empty() && std::ranges::all_of(last, [](unsigned char c) {
    return std::isalpha(c) != 0 || c == '_';
  });
  CheckInput(!is_word, fmt::format("{}: its last line '{}' has no value, so it is cut short; get "
                                   "the file again",
                                   name, last));
}

// A depth_scale below this is metres per unit, as RealSense gives it, not BOP's millimetres.
constexpr double kMinScale_mm = 0.005;

GivenIntrinsics FromMap(const SettingsTree& map, const std::string& name) {
  RequireSoundKeys(map, name);
  GivenIntrinsics given;
  const std::vector<double> matrix =
      NumbersOf(map, {"cam_K", "K", "k", "camera_matrix", "intrinsic_matrix"});
  const auto fx = NumberOf(map, {"fx"}, name), fy = NumberOf(map, {"fy"}, name);
  const auto cx = NumberOf(map, {"cx", "ppx"}, name), cy = NumberOf(map, {"cy", "ppy"}, name);
  if (matrix.size() == kMatrixEntries) {
    TakeMatrix(matrix, name, given);
  } else {
    const bool is_one_image =
        fx.has_value() || map.items.empty() || map.items.front().kind != SettingsTree::Kind::kMap;
    CheckInput(is_one_image,
               fmt::format("{}: has the cameras of several images ({}, ...); give the camera of "
                           "this image as FX,FY,CX,CY",
                           name, map.items.empty() ? "" : map.items.front().key));
    CheckInput(fx && fy && cx && cy,
               name + ": has no camera matrix and no fx, fy, cx, cy; give them, in px");
    given.fx = *fx;
    given.fy = *fy;
    given.cx = *cx;
    given.cy = *cy;
  }
  given.width = SizeOf(map, {"width", "image_width"}, name);
  given.height = SizeOf(map, {"height", "image_height"}, name);
  given.depth_scale_mm = NumberOf(map, {"depth_scale"}, name);
  CheckInput(!given.depth_scale_mm || *given.depth_scale_mm > 0,
             fmt::format("{}: depth_scale is {:g}; give the positive length of one unit", name,
                         given.depth_scale_mm.value_or(0)));
  if (given.depth_scale_mm && *given.depth_scale_mm < kMinScale_mm) *given.depth_scale_mm *= 1e3;
  const std::vector<double> distortion =
      NumbersOf(map, {"D", "distortion_coefficients", "dist_coeffs", "coeffs"});
  constexpr double kLargest = 1e6;  // coefficients of rational models reach some hundreds
  for (const double coefficient : distortion) {
    CheckInput(std::abs(coefficient) <= kLargest,
               fmt::format("{}: has the distortion coefficient {:g}, over {:g}; get the file again",
                           name, coefficient, kLargest));
  }
  given.is_distorted = std::ranges::any_of(distortion, [](double c) { return c != 0; });
  return given;
}

GivenIntrinsics FromNumbers(const std::vector<double>& numbers, const std::string& name) {
  GivenIntrinsics given;
  if (numbers.size() == kMatrixEntries) {
    TakeMatrix(numbers, name, given);
    return given;
  }
  constexpr size_t kParameters = 4;
  CheckInput(numbers.size() == kParameters,
             fmt::format("{}: has {} numbers; give FX,FY,CX,CY in px, or a file with a camera "
                         "matrix",
                         name, numbers.size()));
  given.fx = numbers[0];
  given.fy = numbers[1];
  given.cx = numbers[2];
  given.cy = numbers[3];
  return given;
}

}  // namespace

CameraIntrinsics GivenIntrinsics::ForImage(int width_px, int height_px,
                                           const std::string& name) const {
  CheckInput((width == 0 || width == width_px) && (height == 0 || height == height_px),
             fmt::format("{}: the intrinsics are for {}x{} px but the image has {}x{} px; give the "
                         "intrinsics of this image, or scale fx, fy, cx and cy",
                         name, width, height, width_px, height_px));
  const std::string faults = CameraIntrinsics::FaultsOf(width_px, height_px, fx, fy, cx, cy);
  CheckInput(faults.empty(), name + ": " + faults);
  CheckInput(cx > -0.5 && cy > -0.5 && cx < width_px && cy < height_px,
             fmt::format("{}: the principal point ({:.1f}, {:.1f}) is outside the image of {}x{} "
                         "px; give the intrinsics of this image",
                         name, cx, cy, width_px, height_px));
  return {width_px, height_px, fx, fy, cx, cy};
}

GivenIntrinsics ReadIntrinsics(const std::string& text_or_file) {
  if (const auto numbers = NumbersIn(text_or_file); numbers && !numbers->empty()) {
    return FromNumbers(*numbers, "intrinsics " + text_or_file);
  }
  std::error_code error;
  CheckInput(
      text_or_file.find(',') == std::string::npos || std::filesystem::exists(text_or_file, error),
      fmt::format("intrinsics {}: give four finite numbers FX,FY,CX,CY in px", text_or_file));
  std::string text = ReadFileText(text_or_file);
  if (const auto numbers = NumbersIn(text)) return FromNumbers(*numbers, text_or_file);
  RequireNoCutKey(text, text_or_file);
  // OpenCV begins its YAML with a directive that YAML does not have.
  if (text.starts_with("%YAML")) text.erase(0, std::min(text.size(), text.find('\n')));
  return FromMap(ReadSettingsTreeText(text, text_or_file), text_or_file);
}

}  // namespace pickbed::eval
