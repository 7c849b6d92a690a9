#include "eval/segments/labelled_cloud.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <map>
#include <sstream>
#include <vector>

#include "scenes/base/error.h"
#include "scenes/base/files.h"

namespace pickbed::eval {
namespace {

constexpr size_t kFieldBytes = 4;

struct Header {
  std::vector<std::string> fields;
  std::vector<std::string> types;  // by field: F, U or I
  int width = 0, height = 0;
  std::string data;  // binary or binary_compressed
  size_t end = 0;    // first byte of the data
};

Header ReadHeader(const std::string& bytes, const std::string& name) {
  Header header;
  while (header.data.empty()) {
    const size_t end = bytes.find('\n', header.end);
    CheckInput(end != std::string::npos,
               name + ": the header of a PCD file has no line DATA; give a PCD file");
    std::istringstream line(bytes.substr(header.end, end - header.end));
    header.end = end + 1;
    std::string key, word;
    line >> key;
    if (key == "FIELDS") {
      while (line >> word) header.fields.push_back(word);
    } else if (key == "TYPE") {
      while (line >> word) header.types.push_back(word);
    } else if (key == "SIZE" || key == "COUNT") {
      const std::string wanted = key == "SIZE" ? "4" : "1";
      while (line >> word) {
        CheckInput(word == wanted, fmt::format("{}: {} has {}; only fields with one value of four "
                                               "bytes are read, so write the cloud with these",
                                               name, key, word));
      }
    } else if (key == "WIDTH") {
      line >> header.width;
    } else if (key == "HEIGHT") {
      line >> header.height;
    } else if (key == "DATA") {
      line >> header.data;
    }
  }
  constexpr int kMaxSide = 1 << 14;
  CheckInput(
      header.width > 1 && header.height > 1 && header.width < kMaxSide && header.height < kMaxSide,
      fmt::format("{}: the cloud is {}x{}; give an organised cloud, with the width and the "
                  "height of the image",
                  name, header.width, header.height));
  return header;
}

// Returns the values of all fields, field by field.
std::string FieldBytes(const std::string& bytes, const Header& header, const std::string& name) {
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
  std::string by_field(size, '\0');
  for (size_t i = 0; i < points * fields; ++i) {
    std::memcpy(&by_field[(i % fields * points + i / fields) * kFieldBytes],
                &bytes[header.end + i * kFieldBytes], kFieldBytes);
  }
  return by_field;
}

// Checks the type of a field. The same four bytes are another value as another type.
void RequireType(const Header& header, const std::string& key, bool is_float,
                 const std::string& name) {
  for (size_t i = 0; i < std::min(header.fields.size(), header.types.size()); ++i) {
    CheckInput(header.fields[i] != key || (header.types[i] == "F") == is_float,
               fmt::format("{}: field {} has TYPE {}; write it with TYPE {}", name, key,
                           header.types[i], is_float ? "F" : "U"));
  }
}

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

CameraIntrinsics FitIntrinsics(const Image<float>& depth_m, const Image<float>& x_m,
                               const Image<float>& y_m, const std::string& name) {
  Line columns, rows;
  for (int v = 0; v < depth_m.height(); ++v) {
    for (int u = 0; u < depth_m.width(); ++u) {
      if (!(depth_m(u, v) > 0)) continue;
      columns.Add(u, x_m(u, v) / depth_m(u, v));
      rows.Add(v, y_m(u, v) / depth_m(u, v));
    }
  }
  const double fx = 1 / columns.Slope(), fy = 1 / rows.Slope();
  CheckInput(columns.n > 2 && std::isfinite(fx) && std::isfinite(fy) && fx > 0 && fy > 0,
             name +
                 ": the points have no layout of an image; give an organised cloud in the "
                 "camera frame");
  return {depth_m.width(), depth_m.height(), fx, fy, columns.Zero(), rows.Zero()};
}

}  // namespace

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

LabelledCloud ReadLabelledCloud(const std::filesystem::path& file) {
  const std::string name = file.string(), bytes = ReadFileBytes(file);
  const Header header = ReadHeader(bytes, name);
  const std::string data = FieldBytes(bytes, header, name);
  const size_t points = static_cast<size_t>(header.width) * header.height;
  const auto field = [&](const std::string& key) -> const char* {
    const auto found = std::find(header.fields.begin(), header.fields.end(), key);
    if (found == header.fields.end()) return nullptr;
    return data.data() + (found - header.fields.begin()) * points * kFieldBytes;
  };
  const auto image_of = [&](const std::string& key) {
    const char* values = field(key);
    CheckInput(values != nullptr,
               fmt::format("{}: the cloud has no field {}; give x, y, z and label", name, key));
    Image<float> image(header.width, header.height);
    std::memcpy(image.data(), values, points * kFieldBytes);
    return image;
  };
  for (const char* key : {"x", "y", "z"}) RequireType(header, key, true, name);
  RequireType(header, "label", false, name);
  LabelledCloud cloud;
  cloud.frame.depth_m = image_of("z");
  for (float& z : cloud.frame.depth_m.pixels()) {
    if (!std::isfinite(z) || z < 0) z = 0;
  }
  cloud.frame.intrinsics = FitIntrinsics(cloud.frame.depth_m, image_of("x"), image_of("y"), name);
  const Image<float> labels = image_of("label");
  cloud.labels = Image<uint16_t>(header.width, header.height);
  for (size_t i = 0; i < points; ++i) {
    uint32_t label = 0;
    std::memcpy(&label, labels.data() + i, sizeof(label));
    cloud.labels.data()[i] = static_cast<uint16_t>(std::min<uint32_t>(label, 0xffff));
  }
  const char* colors = field("rgba") != nullptr ? field("rgba") : field("rgb");
  if (colors == nullptr) return cloud;
  cloud.frame.color = Image<Rgb8>(header.width, header.height);
  for (size_t i = 0; i < points; ++i) {
    uint32_t packed = 0;
    std::memcpy(&packed, colors + i * kFieldBytes, sizeof(packed));
    cloud.frame.color.data()[i] = {static_cast<uint8_t>(packed >> 16),
                                   static_cast<uint8_t>(packed >> 8), static_cast<uint8_t>(packed)};
  }
  return cloud;
}

}  // namespace pickbed::eval
