#include "scenes/image/number_image.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <opencv2/imgcodecs.hpp>
#include <regex>
#include <type_traits>
#include <vector>

#include "scenes/base/error.h"
#include "scenes/base/files.h"
#include "scenes/base/message_text.h"
#include "scenes/image/image_check.h"

namespace pickbed::scenes {
namespace {

constexpr char kNumpyMagic[] = "\x93NUMPY";
constexpr int kMaxSide = 1 << 16;

std::string ExtensionOf(const std::filesystem::path& path) {
  std::string extension = path.extension().string();
  for (char& c : extension) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return extension;
}

// OpenCV reads OpenEXR files only if this variable is set. A value of the user stays.
void AllowExr() { setenv("OPENCV_IO_ENABLE_OPENEXR", "1", /*overwrite=*/0); }

cv::Mat DecodeAny(const std::string& bytes) {
  AllowExr();
  if (bytes.empty()) return {};
  const cv::Mat encoded(1, static_cast<int>(bytes.size()), CV_8UC1,
                        const_cast<char*>(bytes.data()));
  try {
    return cv::imdecode(encoded, cv::IMREAD_UNCHANGED);
  } catch (const cv::Exception&) {
    return {};  // a damaged file
  }
}

template <typename T>
void CopyPixels(const cv::Mat& pixels, Image<float>& values) {
  for (int y = 0; y < pixels.rows; ++y) {
    const T* row = pixels.ptr<T>(y);
    for (int x = 0; x < pixels.cols; ++x) values(x, y) = static_cast<float>(row[x]);
  }
}

NumberImage FromPixels(const cv::Mat& pixels, const std::string& name) {
  CheckInput(pixels.channels() == 1,
             "cannot read '" + name + "' as depth: it has " + std::to_string(pixels.channels()) +
                 " channels; give the image whose pixels are distances, not its colors");
  NumberImage image;
  image.values = Image<float>(pixels.cols, pixels.rows);
  image.bits = static_cast<int>(8 * pixels.elemSize1());
  switch (pixels.depth()) {
    case CV_8U:
      CopyPixels<uint8_t>(pixels, image.values);
      break;
    case CV_8S:
      CopyPixels<int8_t>(pixels, image.values);
      break;
    case CV_16U:
      CopyPixels<uint16_t>(pixels, image.values);
      break;
    case CV_16S:
      CopyPixels<int16_t>(pixels, image.values);
      break;
    case CV_32S:
      CopyPixels<int32_t>(pixels, image.values);
      break;
    case CV_32F:
      CopyPixels<float>(pixels, image.values);
      break;
    default:
      CopyPixels<double>(pixels, image.values);
      break;
  }
  image.is_float = pixels.depth() == CV_32F || pixels.depth() == CV_64F;
  return image;
}

// ---- NumPy arrays, format versions 1 to 3: numpy.lib.format ----

struct NumpyHeader {
  char kind = ' ';  // u, i or f
  int bytes = 0;    // of an element
  std::vector<int> shape;
  size_t end = 0;  // first byte of the data
};

NumpyHeader ReadNumpyHeader(const std::string& bytes, const std::string& name) {
  const auto require = [&](bool ok, const std::string& what) {
    CheckInput(ok, "cannot read '" + name + "': " + what);
  };
  constexpr size_t kPreamble = 12;
  require(bytes.size() >= kPreamble, "the NumPy file ends in its header; get it again");
  const int major = bytes[6], minor = bytes[7];
  require(major >= 1 && major <= 3 && minor == 0,
          fmt::format("it has the unknown NumPy version {}.{}; save it again", major, minor));
  const bool is_first = major == 1;
  uint32_t length = 0;
  std::memcpy(&length, bytes.data() + 8, is_first ? 2 : 4);
  NumpyHeader header;
  header.end = (is_first ? 10 : 12) + size_t{length};
  require(header.end <= bytes.size(), "the NumPy file ends in its header; get it again");
  const std::string text = bytes.substr(0, header.end);
  const size_t last = text.find_last_not_of(" \n");
  require(last != std::string::npos && text[last] == '}',
          "its NumPy header has more than a dictionary; get it again");
  const auto value_of = [&](const std::string& key) {
    const size_t at = text.find("'" + key + "':");
    require(at != std::string::npos, "its NumPy header has no '" + key + "'");
    const size_t from = text.find_first_not_of(' ', at + key.size() + 3);
    require(from != std::string::npos, "its NumPy header has no value of '" + key + "'");
    return text.substr(from);
  };
  const std::string type = value_of("descr");
  require(type.size() > 4 && type[0] == '\'' && (type[1] == '<' || type[1] == '|'),
          "its numbers are not little-endian; save it with array.astype('float32')");
  header.kind = type[2];
  header.bytes = type[3] - '0';
  const bool known = header.kind == 'f' ? header.bytes == 4 || header.bytes == 8
                                        : header.kind == 'u' || header.kind == 'i';
  require(known && type[4] == '\'' &&
              (header.bytes == 1 || header.bytes == 2 || header.bytes == 4 || header.bytes == 8),
          "its numbers have the type " + OneLine(type.substr(1, type.find('\'', 1) - 1)) +
              "; save it with array.astype('float32')");
  require(value_of("fortran_order").starts_with("False"),
          "its order is by columns; save it with numpy.ascontiguousarray(array)");
  const std::string shape = value_of("shape");
  for (const char* at = shape.c_str() + 1; *at != '\0' && *at != ')';) {
    int size = 0;
    const auto [end, error] = std::from_chars(at, shape.c_str() + shape.size(), size);
    if (error != std::errc()) {
      ++at;
      continue;
    }
    header.shape.push_back(size);
    at = end;
  }
  if (header.shape.size() == 3 && header.shape[2] == 1) header.shape.pop_back();
  require(header.shape.size() == 2, "the array has the shape " +
                                        OneLine(shape.substr(0, shape.find(')') + 1)) +
                                        "; depth has the shape (height, width)");
  // Keys of the dictionary may have any order. Python 2 wrote sizes as 6L.
  static const std::regex kHeader(
      R"(\{('(descr|fortran_order|shape)':('[^']*'|False|\([0-9L,]*\))(,|(?=\}))){3}\})");
  std::string dictionary = text.substr(is_first ? 10 : 12);
  std::erase_if(dictionary, [](char c) { return c == ' ' || c == '\n'; });
  require(std::regex_match(dictionary, kHeader),
          "its NumPy header is no dictionary of descr, fortran_order and shape; get it again");
  require(header.shape[0] > 0 && header.shape[1] > 0 && header.shape[0] <= kMaxSide &&
              header.shape[1] <= kMaxSide,
          "the array has no pixels or too many of them");
  return header;
}

template <typename T>
void CopyArray(const std::string& bytes, size_t begin, Image<float>& values) {
  for (size_t i = 0; i < values.size(); ++i) {
    T value;
    std::memcpy(&value, bytes.data() + begin + i * sizeof(T), sizeof(T));
    values.data()[i] = static_cast<float>(value);
  }
}

NumberImage ReadNumpy(const std::string& bytes, const std::string& name) {
  const NumpyHeader header = ReadNumpyHeader(bytes, name);
  NumberImage image;
  image.values = Image<float>(header.shape[1], header.shape[0]);
  image.bits = 8 * header.bytes;
  image.is_float = header.kind == 'f';
  CheckInput(bytes.size() - header.end >= image.values.size() * header.bytes,
             "cannot read '" + name + "': the NumPy file is too short; get it again");
  CheckInput(bytes.size() - header.end == image.values.size() * header.bytes,
             "cannot read '" + name +
                 "': the NumPy file is longer than its header says, so it "
                 "may be damaged; get it again");
  const auto copy = [&](auto type) { CopyArray<decltype(type)>(bytes, header.end, image.values); };
  if (image.is_float) {
    header.bytes == 4 ? copy(float{}) : copy(double{});
  } else if (header.kind == 'u') {
    header.bytes == 1   ? copy(uint8_t{})
    : header.bytes == 2 ? copy(uint16_t{})
    : header.bytes == 4 ? copy(uint32_t{})
                        : copy(uint64_t{});
  } else {
    header.bytes == 1   ? copy(int8_t{})
    : header.bytes == 2 ? copy(int16_t{})
    : header.bytes == 4 ? copy(int32_t{})
                        : copy(int64_t{});
  }
  return image;
}

std::string NumpyBytes(const Image<float>& values) {
  std::string text = "{'descr': '<f4', 'fortran_order': False, 'shape': (" +
                     std::to_string(values.height()) + ", " + std::to_string(values.width()) +
                     "), }";
  constexpr size_t kPreamble = 10, kAlignment = 64;
  while ((kPreamble + text.size() + 1) % kAlignment != 0) text += ' ';
  text += '\n';
  const auto length = static_cast<uint16_t>(text.size());
  std::string bytes(kNumpyMagic, sizeof(kNumpyMagic) - 1);
  bytes += {'\x01', '\x00', static_cast<char>(length & 0xff), static_cast<char>(length >> 8)};
  bytes += text;
  bytes.append(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(float));
  return bytes;
}

}  // namespace

NumberImage ReadNumberImage(const std::filesystem::path& path) {
  const std::string bytes = ReadFileBytes(path);
  if (bytes.starts_with(kNumpyMagic)) return ReadNumpy(bytes, path.string());
  const std::string fault = FaultOfImage(bytes);
  CheckInput(fault.empty(), "cannot read '" + path.string() + "': " + fault);
  const cv::Mat pixels = DecodeAny(bytes);
  CheckInput(!pixels.empty(), "cannot read '" + path.string() +
                                  "': it is no PNG, TIFF, OpenEXR or NumPy file with one channel");
  return FromPixels(pixels, path.string());
}

bool HasColorChannels(const std::filesystem::path& path) {
  const std::string bytes = ReadFileBytes(path);
  return !bytes.starts_with(kNumpyMagic) && DecodeAny(bytes).channels() > 1;
}

void WriteFloats(const std::filesystem::path& path, const Image<float>& values) {
  CheckInput(!values.empty(), "cannot write '" + path.string() + "': the image has no pixels");
  const std::string extension = ExtensionOf(path);
  if (extension == ".npy") return WriteFileAtomically(path, NumpyBytes(values));
  CheckInput(extension == ".exr" || extension == ".tif" || extension == ".tiff",
             "cannot write '" + path.string() + "': use the extension .exr, .tif, .tiff or .npy");
  AllowExr();
  const cv::Mat pixels(values.height(), values.width(), CV_32F, const_cast<float*>(values.data()));
  std::vector<unsigned char> encoded;
  cv::imencode(extension, pixels, encoded);
  WriteFileAtomically(path, std::string(encoded.begin(), encoded.end()));
}

}  // namespace pickbed::scenes
