#include "perception/crop_methods/crop_lookup.h"

#include <limits>

#include "perception/features/neighbors.h"

namespace pickbed::perception {
namespace {

class CropLookup : public CropMethod {
 public:
  CropLookup(std::shared_ptr<const CropTrainingSet> training_set, DescribeCrops describe,
             int length, int threads)
      : training_set_(std::move(training_set)),
        describe_(std::move(describe)),
        index_(TemplateRows(threads), length, Exact()) {}

  std::vector<std::vector<CropAnswer>> Answer(const CropSet& crops, int k,
                                              int threads) const override {
    const Neighbors found = index_.Search(describe_(crops, threads), k, threads);
    std::vector<std::vector<CropAnswer>> answers(crops.size());
    for (size_t i = 0; i < crops.size(); ++i) {
      for (int n = 0; n < k; ++n) {
        const int row = found.rows[i * k + n];
        if (row < 0) break;
        const Entry& entry = entries_[row];
        answers[i].push_back({entry.object, training_set_->templates[entry.object].R_CO[entry.view],
                              found.squared[i * k + n], entry.view});
      }
    }
    return answers;
  }

 private:
  struct Entry {
    ObjectId object{0};
    int view = 0;
  };

  // There are only some thousands of templates, so exact search is fast enough.
  static NeighborOptions Exact() {
    NeighborOptions options;
    options.linear_below = NeighborOptions::kAlwaysLinear;
    return options;
  }

  std::vector<float> TemplateRows(int threads) {
    std::vector<float> rows;
    for (const ObjectCrops& of_object : training_set_->templates) {
      const std::vector<float> described = describe_(of_object.crops, threads);
      rows.insert(rows.end(), described.begin(), described.end());
      for (size_t i = 0; i < of_object.crops.size(); ++i) {
        entries_.push_back({of_object.object, static_cast<int>(i)});
      }
    }
    return rows;
  }

  std::shared_ptr<const CropTrainingSet> training_set_;
  DescribeCrops describe_;
  std::vector<Entry> entries_;  // by row of the index
  NeighborIndex index_;
};

}  // namespace

std::unique_ptr<CropMethod> MakeCropLookup(std::shared_ptr<const CropTrainingSet> training_set,
                                           DescribeCrops describe, int length, int threads) {
  return std::make_unique<CropLookup>(std::move(training_set), std::move(describe), length,
                                      threads);
}

}  // namespace pickbed::perception
