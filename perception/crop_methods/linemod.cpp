#include "perception/crop_methods/linemod.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <opencv2/imgproc.hpp>
#include <opencv2/rgbd/linemod.hpp>

#include "scenes/base/error.h"
#include "scenes/base/parallel.h"

namespace pickbed::perception {
namespace {

namespace linemod = cv::linemod;

constexpr int kPixels = 128;  // side of an enlarged crop
// Border on each side, px. OpenCV refines no match nearer to the image edge than 8 T. It also
// writes 16 pixels at once to the rows of both levels, which crashes unless the widths are
// multiples of 16.
constexpr int kBorder = 48;
constexpr float kThreshold = 50;   // similarity below which OpenCV reports no match, %
constexpr int kLevels[] = {4, 8};  // T of each level: distance over which features are spread, px
static_assert((kPixels + 2 * kBorder) % 32 == 0 && kBorder >= 8 * kLevels[0]);
constexpr double kPixelPitch = 1000.0 / 1150;  // mm at 1 m for the focal length in DepthNormal
constexpr int kCenterDepth_mm = 1000;          // depth of the crop center, mm
constexpr uint16_t kNoReading = 60000;         // beyond the range of DepthNormal

cv::Mat WithBorder(const cv::Mat& image, int kind) {
  cv::Mat wider;
  cv::copyMakeBorder(image, wider, kBorder, kBorder, kBorder, kBorder, kind);
  return wider;
}

// Returns color (BGR) and depth (mm) as input of LINEMOD. Depth uses the pixel pitch of the
// enlarged crop, so that surface slopes are right for objects of any size.
std::vector<cv::Mat> Sources(const CropSet& crops, size_t i) {
  cv::Mat color(kCropPixels, kCropPixels, CV_8UC3), depth(kCropPixels, kCropPixels, CV_16U);
  const auto of_color = crops.color_of(i);
  const auto of_depth = crops.depth_of(i);
  for (int p = 0; p < kCropArea; ++p) {
    color.at<cv::Vec3b>(p) = {of_color[p].b, of_color[p].g, of_color[p].r};
    const double relative = of_depth[p] / kCropDepthUnit;
    depth.at<uint16_t>(p) =
        relative >= 1
            ? kNoReading
            : cv::saturate_cast<uint16_t>(kCenterDepth_mm + relative * kPixels * kPixelPitch);
  }
  cv::resize(color, color, {kPixels, kPixels}, 0, 0, cv::INTER_LINEAR);
  cv::resize(depth, depth, {kPixels, kPixels}, 0, 0, cv::INTER_NEAREST);
  return {WithBorder(color, cv::BORDER_REPLICATE), WithBorder(depth, cv::BORDER_REPLICATE)};
}

cv::Mat MaskOf(const CropSet& crops, size_t i) {
  cv::Mat mask(kCropPixels, kCropPixels, CV_8U);
  std::transform(crops.masks.begin() + i * kCropArea, crops.masks.begin() + (i + 1) * kCropArea,
                 mask.data, [](uint8_t inside) { return static_cast<uint8_t>(255 * inside); });
  cv::resize(mask, mask, {kPixels, kPixels}, 0, 0, cv::INTER_NEAREST);
  return WithBorder(mask, cv::BORDER_CONSTANT);
}

class LinemodMethod : public CropMethod {
 public:
  explicit LinemodMethod(const CropMethodSetup& setup)
      : training_set_(setup.training_set),
        detector_({cv::makePtr<linemod::ColorGradient>(), cv::makePtr<linemod::DepthNormal>()},
                  {std::begin(kLevels), std::end(kLevels)}) {
    cv::setNumThreads(1);
    views_.resize(training_set_->templates.size());
    for (size_t object = 0; object < views_.size(); ++object) {
      const CropSet& crops = training_set_->templates[object].crops;
      for (size_t i = 0; i < crops.size(); ++i) {
        const int added =
            detector_.addTemplate(Sources(crops, i), std::to_string(object), MaskOf(crops, i));
        if (added >= 0) views_[object].push_back(static_cast<int>(i));
      }
      CheckInput(!views_[object].empty(),
                 fmt::format("object '{}' has too few gradients and normals for LINEMOD",
                             training_set_->objects[object]->name));
    }
  }

  std::vector<std::vector<CropAnswer>> Answer(const CropSet& crops, int k,
                                              int threads) const override {
    std::vector<std::vector<CropAnswer>> answers(crops.size());
    ForRanges(static_cast<int>(crops.size()), threads, [&](int begin, int end) {
      for (int i = begin; i < end; ++i) answers[i] = AnswerOne(crops, i, k);
    });
    return answers;
  }

 private:
  std::vector<CropAnswer> AnswerOne(const CropSet& crops, size_t i, int k) const {
    std::vector<linemod::Match> matches;
    detector_.match(Sources(crops, i), kThreshold, matches);
    std::map<std::pair<int, int>, float> best;  // similarity by object and template
    for (const linemod::Match& match : matches) {
      float& similarity = best[{std::stoi(match.class_id), match.template_id}];
      similarity = std::max(similarity, match.similarity);
    }
    std::vector<CropAnswer> answers;
    for (const auto& [key, similarity] : best) {
      const auto [object, added] = key;
      answers.push_back({training_set_->templates[object].object,
                         training_set_->templates[object].R_CO[views_[object][added]],
                         100.0 - similarity});
    }
    const size_t kept = std::min<size_t>(k, answers.size());
    std::stable_sort(answers.begin(), answers.end(), [](const CropAnswer& a, const CropAnswer& b) {
      return a.distance < b.distance;
    });
    answers.resize(kept);
    return answers;
  }

  std::shared_ptr<const CropTrainingSet> training_set_;
  linemod::Detector detector_;
  std::vector<std::vector<int>> views_;  // by object: crop index of each added template
};

}  // namespace

std::unique_ptr<CropMethod> MakeLinemodMethod(const CropMethodSetup& setup) {
  return std::make_unique<LinemodMethod>(setup);
}

}  // namespace pickbed::perception
