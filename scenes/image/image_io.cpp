#include "scenes/image/image_io.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "scenes/base/error.h"
#include "scenes/base/files.h"
#include "scenes/image/image_check.h"

namespace pickbed::scenes {
namespace {

uint64_t BigEndian(const std::string& bytes, size_t at, int count) {
  uint64_t number = 0;
  for (int i = 0; i < count; ++i) number = number << 8 | static_cast<unsigned char>(bytes[at + i]);
  return number;
}

// Returns the number of pixels that the header of a PNG or JPEG names; 0 for other formats.
int64_t PixelsInHeader(const std::string& bytes) {
  constexpr size_t kPngSize = 16, kJpegFrame = 9;
  if (IsPng(bytes) && bytes.size() >= kPngSize + 8) {
    const uint64_t width = BigEndian(bytes, kPngSize, 4),
                   height = BigEndian(bytes, kPngSize + 4, 4);
    return static_cast<int64_t>(std::min(width * height, uint64_t{1} << 62));
  }
  if (!IsJpeg(bytes)) return 0;
  for (size_t at = 2; at + kJpegFrame < bytes.size() && bytes[at] == '\xff';) {
    const auto marker = static_cast<unsigned char>(bytes[at + 1]);
    const bool is_frame =
        marker >= 0xc0 && marker <= 0xcf && marker != 0xc4 && marker != 0xc8 && marker != 0xcc;
    if (is_frame) {
      return static_cast<int64_t>(BigEndian(bytes, at + 5, 2) * BigEndian(bytes, at + 7, 2));
    }
    at += 2 + BigEndian(bytes, at + 2, 2);
  }
  return 0;
}

// Throws InputError with the fault if the bytes are no image, a damaged one, or one that is too
// large.
cv::Mat Decode(const std::string& bytes, int flags) {
  const std::string no_image = "it is no image, or one of more than 67 million pixels";
  CheckInput(!bytes.empty() && PixelsInHeader(bytes) <= kMaxPixels, no_image);
  const std::string fault = FaultOfImage(bytes);
  CheckInput(fault.empty(), fault + "; save the image again");
  const cv::Mat encoded(1, static_cast<int>(bytes.size()), CV_8UC1,
                        const_cast<char*>(bytes.data()));
  cv::Mat pixels;
  try {
    pixels = cv::imdecode(encoded, flags);
  } catch (const cv::Exception&) {  // for instance of a size that OpenCV refuses
  }
  CheckInput(!pixels.empty(), no_image);
  return pixels;
}

// As above, for the bytes of a file, which the error names.
cv::Mat DecodeFile(const std::filesystem::path& path, int flags) {
  const std::string bytes = ReadFileBytes(path);
  try {
    return Decode(bytes, flags);
  } catch (const InputError& error) {
    throw InputError("cannot read '" + path.string() + "': " + error.what());
  }
}

Image<Rgb8> ToRgb(const cv::Mat& bgr) {
  Image<Rgb8> image(bgr.cols, bgr.rows);
  cv::Mat rgb(bgr.rows, bgr.cols, CV_8UC3, image.data());
  cv::cvtColor(bgr, rgb, cv::COLOR_BGR2RGB);
  return image;
}

constexpr int kColor = cv::IMREAD_COLOR | cv::IMREAD_IGNORE_ORIENTATION;

// The level is fixed, so that the same image gives the same bytes. Level 3 is twice as fast as
// zlib's default of 6.
constexpr int kLevel = 3;

std::string Encode(const cv::Mat& image, int level) {
  std::vector<unsigned char> bytes;
  cv::imencode(".png", image, bytes, {cv::IMWRITE_PNG_COMPRESSION, level});
  return std::string(bytes.begin(), bytes.end());
}

template <typename Pixel>
void Write(const std::filesystem::path& path, const Image<Pixel>& image) {
  CheckInput(!image.empty(), "cannot write '" + path.string() + "': the image has no pixels");
  WriteFileAtomically(path, EncodePng(image, kLevel));
}

// Returns a view of the image's own pixels, without a copy.
template <typename Pixel>
cv::Mat MatOf(const Image<Pixel>& image, int type) {
  return cv::Mat(image.height(), image.width(), type, const_cast<Pixel*>(image.data()));
}

// Reads a one-channel image without conversion. `what` describes the expected content in an error.
template <typename Pixel>
Image<Pixel> ReadChannel(const std::filesystem::path& path, int type, const char* what) {
  const cv::Mat pixels = DecodeFile(path, cv::IMREAD_UNCHANGED);
  CheckInput(pixels.type() == type, "cannot read '" + path.string() + "' as " + what);
  Image<Pixel> image(pixels.cols, pixels.rows);
  for (int y = 0; y < pixels.rows; ++y) {
    std::memcpy(image.row(y), pixels.ptr(y), sizeof(Pixel) * pixels.cols);
  }
  return image;
}

}  // namespace

std::string EncodePng(const Image<Rgb8>& image, int level) {
  cv::Mat bgr;
  cv::cvtColor(MatOf(image, CV_8UC3), bgr, cv::COLOR_RGB2BGR);
  return Encode(bgr, level);
}

std::string EncodeJpeg(const Image<Rgb8>& image, int quality) {
  cv::Mat bgr;
  cv::cvtColor(MatOf(image, CV_8UC3), bgr, cv::COLOR_RGB2BGR);
  std::vector<unsigned char> bytes;
  cv::imencode(".jpg", bgr, bytes, {cv::IMWRITE_JPEG_QUALITY, quality});
  return std::string(bytes.begin(), bytes.end());
}

Image<Rgb8> Narrowed(const Image<Rgb8>& image, int width_px) {
  if (image.width() <= width_px) return image;
  const int height_px =
      std::max(1, static_cast<int>(
                      std::lround(static_cast<double>(image.height()) * width_px / image.width())));
  Image<Rgb8> narrowed(width_px, height_px);
  cv::Mat out(height_px, width_px, CV_8UC3, narrowed.data());
  cv::resize(MatOf(image, CV_8UC3), out, out.size(), 0, 0, cv::INTER_AREA);
  return narrowed;
}

std::string EncodePng(const Image<uint16_t>& image, int level) {
  return Encode(MatOf(image, CV_16UC1), level);
}

std::string EncodePng(const Image<uint8_t>& image, int level) {
  return Encode(MatOf(image, CV_8UC1), level);
}

void WritePng(const std::filesystem::path& path, const Image<Rgb8>& image) { Write(path, image); }

void WritePng16(const std::filesystem::path& path, const Image<uint16_t>& image) {
  Write(path, image);
}

Image<uint16_t> DepthUnits(const Image<float>& depth_m, double scale_mm) {
  constexpr double kMaxUnits = 65535;
  Image<uint16_t> units(depth_m.width(), depth_m.height());
  for (size_t i = 0; i < depth_m.size(); ++i) {
    const double value = std::round(depth_m.data()[i] * 1e3 / scale_mm);
    const bool reading = value > 0 && value <= kMaxUnits;  // false for NaN
    units.data()[i] = reading ? static_cast<uint16_t>(value) : 0;
  }
  return units;
}

void WriteDepthPng(const std::filesystem::path& path, const Image<float>& depth_m,
                   double scale_mm) {
  WritePng16(path, DepthUnits(depth_m, scale_mm));
}

Image<Rgb8> DecodeImage(const std::string& bytes) { return ToRgb(Decode(bytes, kColor)); }

Image<Rgb8> ReadPng(const std::filesystem::path& path) { return ToRgb(DecodeFile(path, kColor)); }

Image<uint16_t> ReadPng16(const std::filesystem::path& path) {
  return ReadChannel<uint16_t>(path, CV_16UC1, "depth: it is not 16 bits with one channel");
}

Image<uint8_t> ReadPng8(const std::filesystem::path& path) {
  return ReadChannel<uint8_t>(path, CV_8UC1, "a mask: it is not 8 bits with one channel");
}

}  // namespace pickbed::scenes
