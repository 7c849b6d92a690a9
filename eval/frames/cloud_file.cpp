#include "eval/frames/cloud_file.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <cstring>
#include <iterator>
#include <optional>
#include <sstream>

#include "eval/frames/ply_rows.h"
#include "scenes/base/error.h"
#include "scenes/base/files.h"
#include "scenes/base/message_text.h"

namespace pickbed::eval {
namespace {

constexpr size_t kFieldBytes = 4;
constexpr int kMaxSide = 1 << 14;

std::string ExtensionOf(const std::filesystem::path& path) {
  std::string extension = path.extension().string();
  for (char& c : extension) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return extension;
}

// ---- PCD ----

struct PcdHeader {
  std::vector<std::string> fields;
  std::vector<std::string> types;  // by field: F, U or I
  int width = 0, height = 0;
  std::string data;  // binary or binary_compressed
  size_t end = 0;    // first byte of the data
};

// Returns the whole number of a statement, which has one.
int WholeNumber(const std::vector<std::string>& words, const std::string& name) {
  int number = 0;
  const bool is_one = words.size() == 2;
  const std::string& word = words.back();
  const char* const end = word.data() + word.size();
  const auto [after, error] = std::from_chars(word.data(), end, number);
  CheckInput(is_one && error == std::errc() && after == end,
             fmt::format("{}: the header of the PCD file has no whole number after {}; get the "
                         "file again",
                         name, words.front()));
  return number;
}

void RequireViewpoint(const std::vector<std::string>& words, const std::string& name) {
  constexpr size_t kNumbers = 7;  // position and quaternion
  constexpr size_t kPosition = 3;
  constexpr double kRounding = 0.01;  // of the norm
  std::vector<double> numbers;
  for (size_t i = 1; i < words.size(); ++i) {
    double number = 0;
    const char* const end = words[i].data() + words[i].size();
    const auto [after, error] = std::from_chars(words[i].data(), end, number);
    if (error == std::errc() && after == end && std::isfinite(number)) numbers.push_back(number);
  }
  CheckInput(numbers.size() == kNumbers && words.size() == 1 + kNumbers,
             name + ": VIEWPOINT of the PCD file has no seven numbers; get the file again");
  double squared_norm = 0;
  for (size_t i = kPosition; i < kNumbers; ++i) squared_norm += numbers[i] * numbers[i];
  const double norm = std::sqrt(squared_norm);
  CheckInput(norm == 0 || std::abs(norm - 1) < kRounding,
             fmt::format("{}: the rotation in VIEWPOINT of the PCD file is a quaternion of length "
                         "{:.3g}, not 1; get the file again",
                         name, norm));
}

// Reads one line of the header.
void ReadPcdLine(const std::vector<std::string>& words, const std::string& name,
                 PcdHeader& header) {
  const std::string& key = words.front();
  if (key == "FIELDS") {
    header.fields.assign(words.begin() + 1, words.end());
    for (const std::string& field : header.fields) {
      const bool is_name =
          std::all_of(field.begin(), field.end(), [](char c) { return c > ' ' && c <= '~'; });
      CheckInput(is_name, fmt::format("{}: FIELDS of the PCD file has '{}', which is no name; get "
                                      "the file again",
                                      name, OneLine(field)));
    }
  } else if (key == "TYPE") {
    header.types.assign(words.begin() + 1, words.end());
    const bool are_types =
        header.types.size() == header.fields.size() &&
        std::all_of(header.types.begin(), header.types.end(), [](const std::string& type) {
          return type == "F" || type == "I" || type == "U";
        });
    CheckInput(are_types, fmt::format("{}: TYPE of the PCD file is '{}', but needs F, I or U for "
                                      "each of {} fields; get the file again",
                                      name, OneLine(fmt::to_string(fmt::join(header.types, " "))),
                                      header.fields.size()));
  } else if (key == "SIZE" || key == "COUNT") {
    const std::string wanted = key == "SIZE" ? "4" : "1";
    CheckInput(words.size() - 1 == header.fields.size(),
               fmt::format("{}: {} of the PCD file has {} values for {} fields; get the file again",
                           name, key, words.size() - 1, header.fields.size()));
    for (size_t i = 1; i < words.size(); ++i) {
      CheckInput(words[i] == wanted,
                 fmt::format("{}: {} has {}; only fields with one value of four "
                             "bytes are read, so write the cloud with these",
                             name, key, OneLine(words[i])));
    }
  } else if (key == "WIDTH") {
    header.width = WholeNumber(words, name);
  } else if (key == "HEIGHT") {
    header.height = WholeNumber(words, name);
  } else if (key == "POINTS") {
    WholeNumber(words, name);
  } else if (key == "VIEWPOINT") {
    RequireViewpoint(words, name);
  } else if (key == "DATA") {
    header.data = words.size() == 2 ? words.back() : "not one word";
  } else {
    CheckInput(key == "VERSION",
               fmt::format("{}: the header of the PCD file has the unknown word '{}'; get the file "
                           "again",
                           name, OneLine(key)));
  }
}

PcdHeader ReadPcdHeader(const std::string& bytes, const std::string& name) {
  PcdHeader header;
  while (header.data.empty()) {
    const size_t end = bytes.find('\n', header.end);
    CheckInput(end != std::string::npos,
               name + ": the header of a PCD file has no line DATA; give a PCD file");
    std::istringstream line(bytes.substr(header.end, end - header.end));
    header.end = end + 1;
    const std::vector<std::string> words{std::istream_iterator<std::string>(line), {}};
    if (!words.empty() && !words.front().starts_with('#')) ReadPcdLine(words, name, header);
  }
  return header;
}

void RequireLayout(int width, int height, const std::string& name) {
  CheckInput(width > 1 && height > 1 && width < kMaxSide && height < kMaxSide,
             fmt::format("{}: the cloud is {}x{}; give an organised cloud, with the width and the "
                         "height of the image",
                         name, width, height));
}

// Returns the values of all fields, field by field.
std::string PcdFieldBytes(const std::string& bytes, const PcdHeader& header,
                          const std::string& name) {
  const size_t points = static_cast<size_t>(header.width) * header.height;
  const size_t fields = header.fields.size(), size = points * fields * kFieldBytes;
  if (header.data == "binary_compressed") {
    uint32_t sizes[2] = {};
    CheckInput(bytes.size() >= header.end + sizeof(sizes), name + ": the file ends in its header");
    std::memcpy(sizes, bytes.data() + header.end, sizeof(sizes));
    CheckInput(sizes[1] == size && bytes.size() - header.end - sizeof(sizes) >= sizes[0],
               name + ": the data has another size than the header says; get the file again");
    return DecompressLzf(bytes.substr(header.end + sizeof(sizes), sizes[0]), size, name);
  }
  CheckInput(
      header.data == "binary",
      fmt::format("{}: DATA is {}; write it as binary or binary_compressed", name, header.data));
  CheckInput(bytes.size() - header.end >= size, name + ": the file is too short; get it again");
  CheckInput(
      bytes.size() - header.end == size,
      name + ": the file is longer than its header says, so it may be damaged; get it again");
  std::string by_field(size, '\0');
  for (size_t i = 0; i < points * fields; ++i) {
    std::memcpy(&by_field[(i % fields * points + i / fields) * kFieldBytes],
                &bytes[header.end + i * kFieldBytes], kFieldBytes);
  }
  return by_field;
}

CloudFile ReadPcd(const std::string& bytes, const std::string& name) {
  const PcdHeader header = ReadPcdHeader(bytes, name);
  RequireLayout(header.width, header.height, name);
  const std::string data = PcdFieldBytes(bytes, header, name);
  const size_t points = static_cast<size_t>(header.width) * header.height;
  CloudFile cloud{header.width, header.height, {}};
  for (size_t i = 0; i < header.fields.size(); ++i) {
    CloudFile::Field field{header.fields[i], i >= header.types.size() || header.types[i] == "F",
                           std::vector<uint32_t>(points)};
    std::memcpy(field.words.data(), data.data() + i * points * kFieldBytes, points * kFieldBytes);
    cloud.fields.push_back(std::move(field));
  }
  return cloud;
}

// ---- PLY ----

CloudFile ReadPly(const std::string& bytes, const std::string& name, const CloudSize& size) {
  const PlyRows ply = ReadPlyRows(bytes, name);
  CloudFile cloud{ply.width, ply.height, {}};
  if (cloud.width == 0 && size.width > 0) {
    cloud.width = size.width;
    cloud.height = size.height;
  }
  CheckInput(cloud.width > 0,
             fmt::format("{}: the cloud has {} points but no width and height; write it as an "
                         "organised cloud, for example as PCD, or give its color image, too",
                         name, ply.rows));
  RequireLayout(cloud.width, cloud.height, name);
  CheckInput(static_cast<size_t>(cloud.width) * cloud.height == ply.rows,
             fmt::format("{}: the cloud has {} points, but an image of {}x{} has {}; write all "
                         "points, also those without a reading",
                         name, ply.rows, cloud.width, cloud.height,
                         static_cast<size_t>(cloud.width) * cloud.height));
  for (size_t i = 0; i < ply.columns.size(); ++i) {
    CloudFile::Field field{ply.columns[i].name, ply.columns[i].is_float,
                           std::vector<uint32_t>(ply.rows)};
    for (size_t row = 0; row < ply.rows; ++row) {
      const double value = ply.columns[i].values[row];
      if (field.is_float) {
        const auto as_float = static_cast<float>(value);
        std::memcpy(&field.words[row], &as_float, sizeof(as_float));
      } else {
        field.words[row] = static_cast<uint32_t>(static_cast<int64_t>(value));
      }
    }
    cloud.fields.push_back(std::move(field));
  }
  return cloud;
}

// ---- frame ----

// Line through value(index): slope and the index of value 0.
struct Line {
  double n = 0, x = 0, y = 0, xx = 0, xy = 0;
  void Add(double index, double value) {
    ++n;
    x += index;
    y += value;
    xx += index * index;
    xy += index * value;
  }
  double Slope() const { return (n * xy - x * y) / (n * xx - x * x); }
  double Zero() const { return x / n - y / n / Slope(); }
};

// Adds the median of the values to the line. Single wrong points do not turn it then.
void AddMedian(int index, std::vector<double>& values, Line& line) {
  if (values.empty()) return;
  const auto median = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), median, values.end());
  line.Add(index, *median);
}

// Rounding leaves more of a 0, so a number nearer to it is made of other bytes. NaN marks a missing
// point.
void RequireSound(float side_m, int u, int v, const std::string& name) {
  CheckInput(side_m == 0 || !(std::abs(side_m) <= 1e-30),
             fmt::format("{}: the point in column {}, row {} has {:g}, so its bytes are damaged; "
                         "get the file again",
                         name, u, v, side_m));
}

// A point far from the ray of its pixel contradicts the others: it is damaged, or the cloud has the
// frame of another camera.
void RequireOnRays(const CameraIntrinsics& k, const Image<float>& depth_m, const Image<float>& x_m,
                   const Image<float>& y_m, const std::string& name) {
  const double limit_px = std::max(10.0, 0.05 * k.width());
  for (int v = 0; v < depth_m.height(); ++v) {
    for (int u = 0; u < depth_m.width(); ++u) {
      if (!(depth_m(u, v) > 0)) continue;
      RequireSound(x_m(u, v), u, v, name);
      RequireSound(y_m(u, v), u, v, name);
      const double off_px = std::hypot(k.fx() * x_m(u, v) / depth_m(u, v) + k.cx() - u,
                                       k.fy() * y_m(u, v) / depth_m(u, v) + k.cy() - v);
      CheckInput(off_px <= limit_px,
                 fmt::format("{}: the point in column {}, row {} is {:.0f} px from its pixel; give "
                             "an organised cloud in the camera frame, with NaN for wrong points",
                             name, u, v, off_px));
    }
  }
}

CameraIntrinsics FitIntrinsics(const Image<float>& depth_m, const Image<float>& x_m,
                               const Image<float>& y_m, const std::string& name) {
  Line columns, rows;
  std::vector<double> slopes;
  for (int u = 0; u < depth_m.width(); ++u) {
    slopes.clear();
    for (int v = 0; v < depth_m.height(); ++v) {
      if (depth_m(u, v) > 0) slopes.push_back(x_m(u, v) / depth_m(u, v));
    }
    AddMedian(u, slopes, columns);
  }
  for (int v = 0; v < depth_m.height(); ++v) {
    slopes.clear();
    for (int u = 0; u < depth_m.width(); ++u) {
      if (depth_m(u, v) > 0) slopes.push_back(y_m(u, v) / depth_m(u, v));
    }
    AddMedian(v, slopes, rows);
  }
  const double fx = 1 / columns.Slope(), fy = 1 / rows.Slope();
  CheckInput(columns.n > 2 && std::isfinite(fx) && std::isfinite(fy) && fx > 0 && fy > 0,
             name +
                 ": the points have no layout of an image; give an organised cloud in the "
                 "camera frame");
  const CameraIntrinsics fitted{depth_m.width(), depth_m.height(), fx, fy,
                                columns.Zero(),  rows.Zero()};
  RequireOnRays(fitted, depth_m, x_m, y_m, name);
  return fitted;
}

Image<float> Coordinate(const CloudFile& cloud, const std::string& key, const std::string& name,
                        double unit_m) {
  const CloudFile::Field* field = cloud.Find(key);
  CheckInput(field != nullptr,
             fmt::format("{}: the cloud has no field {}; give one with x, y and z", name, key));
  CheckInput(
      field->is_float,
      fmt::format("{}: field {} has no floats (TYPE U or I); write it with TYPE F", name, key));
  Image<float> image(cloud.width, cloud.height);
  std::memcpy(image.data(), field->words.data(), image.size() * sizeof(float));
  for (float& value : image.pixels()) value = static_cast<float>(value * unit_m);
  return image;
}

std::optional<Image<Rgb8>> ColorOf(const CloudFile& cloud, const std::string& name) {
  const CloudFile::Field* packed = cloud.Find("rgba");
  if (packed == nullptr) packed = cloud.Find("rgb");
  const CloudFile::Field *red = cloud.Find("red"), *green = cloud.Find("green"),
                         *blue = cloud.Find("blue");
  if (packed == nullptr && red == nullptr && green == nullptr && blue == nullptr) {
    return std::nullopt;
  }
  const auto is_channel = [](const CloudFile::Field* field) {
    return field != nullptr && !field->is_float;
  };
  CheckInput(packed != nullptr || (is_channel(red) && is_channel(green) && is_channel(blue)),
             name +
                 ": a color needs the fields red, green and blue with integers from 0 to 255; "
                 "write all three as integers, or leave them out");
  Image<Rgb8> color(cloud.width, cloud.height);
  for (size_t i = 0; i < color.size(); ++i) {
    if (packed != nullptr) {
      const uint32_t word = packed->words[i];
      color.data()[i] = {static_cast<uint8_t>(word >> 16), static_cast<uint8_t>(word >> 8),
                         static_cast<uint8_t>(word)};
    } else {
      color.data()[i] = {static_cast<uint8_t>(red->words[i]), static_cast<uint8_t>(green->words[i]),
                         static_cast<uint8_t>(blue->words[i])};
    }
  }
  return color;
}

}  // namespace

const CloudFile::Field* CloudFile::Find(const std::string& name) const {
  const auto found =
      std::ranges::find_if(fields, [&](const Field& field) { return field.name == name; });
  return found == fields.end() ? nullptr : &*found;
}

bool IsCloudFile(const std::filesystem::path& file) {
  const std::string extension = ExtensionOf(file);
  return extension == ".pcd" || extension == ".ply";
}

CloudFile ReadCloudFile(const std::filesystem::path& file, const CloudSize& size) {
  const std::string bytes = ReadFileBytes(file);
  return ExtensionOf(file) == ".ply" ? ReadPly(bytes, file.string(), size)
                                     : ReadPcd(bytes, file.string());
}

RgbdFrame FrameOfCloud(const CloudFile& cloud, const std::string& name, double unit_m) {
  RgbdFrame frame;
  frame.depth_m = Coordinate(cloud, "z", name, unit_m);
  const Image<float> x_m = Coordinate(cloud, "x", name, unit_m);
  const Image<float> y_m = Coordinate(cloud, "y", name, unit_m);
  for (int i = 0; i < static_cast<int>(frame.depth_m.size()); ++i) {
    float& z = frame.depth_m.data()[i];
    CheckInput(z == 0 || !(std::abs(z) < kMinDepth_m),
               fmt::format("{}: a point is {:g} m away, so its bytes are damaged; get the file "
                           "again, or give the unit of its points",
                           name, z));
    CheckInput(!std::isfinite(z) || std::abs(z) <= kMaxDepth_m,
               fmt::format("{}: a point is {:g} m away, over {:g} m; get the file again, or give "
                           "the unit of its points",
                           name, z, kMaxDepth_m));
    if (z < 0) {  // no reading, but its bytes may be damaged
      const int u = i % cloud.width, v = i / cloud.width;
      RequireSound(x_m(u, v), u, v, name);
      RequireSound(y_m(u, v), u, v, name);
    }
    if (!std::isfinite(z) || z < 0) z = 0;
  }
  frame.intrinsics = FitIntrinsics(frame.depth_m, x_m, y_m, name);
  if (std::optional<Image<Rgb8>> color = ColorOf(cloud, name)) frame.color = *std::move(color);
  return frame;
}

std::string DecompressLzf(const std::string& bytes, size_t size, const std::string& name) {
  std::string out;
  // `size` is from the file. Three bytes give at most 264, so a short block reserves little.
  out.reserve(std::min(size, 88 * bytes.size()));
  const auto require = [&](bool ok) {
    CheckInput(ok, name + ": the compressed data is damaged; get the file again");
  };
  for (size_t i = 0; i < bytes.size();) {
    const auto control = static_cast<uint8_t>(bytes[i++]);
    if (control < 32) {  // literal run
      const size_t length = control + 1u;
      require(i + length <= bytes.size() && out.size() + length <= size);
      out.append(bytes, i, length);
      i += length;
      continue;
    }
    size_t length = control >> 5;
    require(i + (length == 7 ? 2 : 1) <= bytes.size());
    if (length == 7) length += static_cast<uint8_t>(bytes[i++]);
    const size_t back = ((control & 31u) << 8) + static_cast<uint8_t>(bytes[i++]) + 1;
    length += 2;
    require(back <= out.size() && out.size() + length <= size);
    for (size_t k = 0; k < length; ++k) out.push_back(out[out.size() - back]);
  }
  require(out.size() == size);
  return out;
}

}  // namespace pickbed::eval
