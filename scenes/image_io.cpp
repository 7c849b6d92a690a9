#include "scenes/image_io.h"

#include <cmath>
#include <cstring>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "scenes/check.h"
#include "scenes/files.h"

namespace pickbed {
namespace {

cv::Mat Decode(const std::string& bytes, int flags) {
  if (bytes.empty()) return {};
  const cv::Mat encoded(1, static_cast<int>(bytes.size()), CV_8UC1,
                        const_cast<char*>(bytes.data()));
  return cv::imdecode(encoded, flags);
}

void Encode(const std::filesystem::path& path, const cv::Mat& image) {
  CheckInput(!image.empty(), "cannot write '" + path.string() + "': the image has no pixels");
  std::vector<unsigned char> bytes;
  // A fixed level, so that the same image gives the same bytes; 3 is twice as fast as zlib's 6.
  cv::imencode(".png", image, bytes, {cv::IMWRITE_PNG_COMPRESSION, 3});
  WriteFileAtomically(path, std::string(bytes.begin(), bytes.end()));
}

}  // namespace

void WritePng(const std::filesystem::path& path, const Image<Rgb8>& image) {
  const cv::Mat rgb(image.height(), image.width(), CV_8UC3, const_cast<Rgb8*>(image.data()));
  cv::Mat bgr;
  if (!image.empty()) cv::cvtColor(rgb, bgr, cv::COLOR_RGB2BGR);
  Encode(path, bgr);
}

void WritePng16(const std::filesystem::path& path, const Image<uint16_t>& image) {
  Encode(path,
         cv::Mat(image.height(), image.width(), CV_16UC1, const_cast<uint16_t*>(image.data())));
}

void WriteDepthPng(const std::filesystem::path& path, const Image<float>& depth_m,
                   double scale_mm) {
  constexpr double kMostUnits = 65535;
  Image<uint16_t> units(depth_m.width(), depth_m.height());
  for (size_t i = 0; i < depth_m.size(); ++i) {
    const double value = std::round(depth_m.data()[i] * 1e3 / scale_mm);
    const bool reading = value > 0 && value <= kMostUnits;  // false for NaN
    units.data()[i] = reading ? static_cast<uint16_t>(value) : 0;
  }
  WritePng16(path, units);
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
  const cv::Mat units = Decode(ReadFileBytes(path), cv::IMREAD_UNCHANGED);
  CheckInput(!units.empty(), "cannot read '" + path.string() + "': it is no image");
  CheckInput(units.type() == CV_16UC1,
             "cannot read '" + path.string() + "' as depth: it is not 16 bits with one channel");
  Image<uint16_t> image(units.cols, units.rows);
  for (int y = 0; y < units.rows; ++y) {
    std::memcpy(image.row(y), units.ptr(y), sizeof(uint16_t) * units.cols);
  }
  return image;
}

}  // namespace pickbed
