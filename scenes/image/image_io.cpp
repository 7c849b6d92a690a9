#include "scenes/image/image_io.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "scenes/base/error.h"
#include "scenes/base/files.h"

namespace pickbed::scenes {
namespace {

cv::Mat Decode(const std::string& bytes, int flags) {
  if (bytes.empty()) return {};
  const cv::Mat encoded(1, static_cast<int>(bytes.size()), CV_8UC1,
                        const_cast<char*>(bytes.data()));
  return cv::imdecode(encoded, flags);
}

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
  const cv::Mat pixels = Decode(ReadFileBytes(path), cv::IMREAD_UNCHANGED);
  CheckInput(!pixels.empty(), "cannot read '" + path.string() + "': it is no image");
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

std::optional<Image<Rgb8>> DecodeImage(const std::string& bytes) {
  const cv::Mat bgr = Decode(bytes, cv::IMREAD_COLOR | cv::IMREAD_IGNORE_ORIENTATION);
  if (bgr.empty()) return std::nullopt;
  Image<Rgb8> image(bgr.cols, bgr.rows);
  cv::Mat rgb(bgr.rows, bgr.cols, CV_8UC3, image.data());
  cv::cvtColor(bgr, rgb, cv::COLOR_BGR2RGB);
  return image;
}

Image<Rgb8> ReadPng(const std::filesystem::path& path) {
  std::optional<Image<Rgb8>> image = DecodeImage(ReadFileBytes(path));
  CheckInput(image.has_value(), "cannot read '" + path.string() + "': it is no image");
  return *std::move(image);
}

Image<uint16_t> ReadPng16(const std::filesystem::path& path) {
  return ReadChannel<uint16_t>(path, CV_16UC1, "depth: it is not 16 bits with one channel");
}

Image<uint8_t> ReadPng8(const std::filesystem::path& path) {
  return ReadChannel<uint8_t>(path, CV_8UC1, "a mask: it is not 8 bits with one channel");
}

}  // namespace pickbed::scenes
