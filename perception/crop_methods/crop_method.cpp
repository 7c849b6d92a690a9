#include "perception/crop_methods/crop_method.h"

#include "perception/crop_methods/crop_lookup.h"
#include "perception/crop_methods/hog.h"
#include "perception/crop_methods/linemod.h"
#include "perception/training/wohlhart_training.h"

namespace pickbed::perception {
namespace {

std::unique_ptr<CropMethod> MakeWohlhart(const CropMethodSetup& setup,
                                         const WohlhartOptions& options, const char* name) {
  WohlhartJob job{*setup.training_set, setup.options.seed, {}, {}, setup.threads};
  if (!setup.folder.empty()) job.checkpoint = setup.folder / (std::string(name) + ".checkpoint");
  if (setup.on_progress) {
    job.on_progress = [&](double share, double) { return setup.on_progress(share); };
  }
  const std::shared_ptr<const WohlhartNetwork> network = TrainWohlhart(job, options);
  if (network == nullptr) return nullptr;
  return MakeCropLookup(
      setup.training_set,
      [network](const CropSet& crops, int threads) { return network->Describe(crops, threads); },
      network->length(), setup.threads);
}

std::unique_ptr<CropMethod> MakeDefaultWohlhart(const CropMethodSetup& setup) {
  return MakeWohlhart(setup, setup.options.wohlhart, "wohlhart");
}

std::unique_ptr<CropMethod> MakeShortWohlhart(const CropMethodSetup& setup) {
  WohlhartOptions options = setup.options.wohlhart;
  options.descriptor = 16;
  return MakeWohlhart(setup, options, "wohlhart_16");
}

std::unique_ptr<CropMethod> MakeDepthWohlhart(const CropMethodSetup& setup) {
  WohlhartOptions options = setup.options.wohlhart;
  options.input = "depth";
  return MakeWohlhart(setup, options, "wohlhart_depth");
}

std::unique_ptr<CropMethod> MakeColorWohlhart(const CropMethodSetup& setup) {
  WohlhartOptions options = setup.options.wohlhart;
  options.input = "rgb";
  return MakeWohlhart(setup, options, "wohlhart_rgb");
}

std::unique_ptr<CropMethod> MakeHog(const CropMethodSetup& setup) {
  return MakeCropLookup(setup.training_set, DescribeByHog, kHogLength, setup.threads);
}

// Returns random templates: the lower bound for any method.
class RandomMethod : public CropMethod {
 public:
  explicit RandomMethod(const CropMethodSetup& setup)
      : training_set_(setup.training_set), seed_(setup.options.seed) {}

  std::vector<std::vector<CropAnswer>> Answer(const CropSet& crops, int k, int) const override {
    std::vector<std::vector<CropAnswer>> answers(crops.size());
    for (size_t i = 0; i < crops.size(); ++i) {
      // The seed depends on the crop, so objects and conditions get different answers.
      Rng rng(HashBytes(crops.depth_of(i).data(), crops.depth_of(i).size_bytes(), seed_));
      for (int n = 0; n < k; ++n) {
        const ObjectCrops& of_object =
            training_set_->templates[rng.Index(static_cast<int>(training_set_->templates.size()))];
        answers[i].push_back({of_object.object,
                              of_object.R_CO[rng.Index(static_cast<int>(of_object.R_CO.size()))],
                              static_cast<double>(n)});
      }
    }
    return answers;
  }

 private:
  std::shared_ptr<const CropTrainingSet> training_set_;
  uint64_t seed_;
};

std::unique_ptr<CropMethod> MakeRandom(const CropMethodSetup& setup) {
  return std::make_unique<RandomMethod>(setup);
}

constexpr CropMethodRow kRows[] = {
    {"wohlhart", "learned descriptor of the whole crop, Wohlhart and Lepetit 2015",
     &MakeDefaultWohlhart},
    {"wohlhart_16", "the same with a descriptor of 16 values", &MakeShortWohlhart},
    {"wohlhart_depth", "the same from depth only", &MakeDepthWohlhart},
    {"wohlhart_rgb", "the same from color only", &MakeColorWohlhart},
    {"hog", "histograms of oriented gradients of depth and grey, OpenCV", &MakeHog},
    {"linemod", "templates of color gradients and surface normals, Hinterstoisser 2012, OpenCV",
     &MakeLinemodMethod},
    {"random", "a random template, as the lower limit", &MakeRandom},
};

}  // namespace

void CropMethodOptions::Visit(SettingsVisitor& v) {
  v.Seed("seed", seed, "random seed of weights and batches");
  v.Group(
      "wohlhart", [&](SettingsVisitor& g) { wohlhart.Visit(g); }, "the learned descriptor");
}

std::span<const CropMethodRow> CropMethodTable() { return kRows; }

}  // namespace pickbed::perception
