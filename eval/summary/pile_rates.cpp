#include "eval/summary/pile_rates.h"

#include <fmt/format.h>

#include <limits>

#include "eval/trial/counts_by_bin.h"

namespace pickbed::eval {

std::string FillBand::name() const {
  return fill_min < 1 ? fmt::format("{:.0f}-{:.0f}", 100 * fill_min, 100 * fill_max) : "100-";
}

std::vector<FillBand> SuccessByFillLevel(const std::vector<TrialResult>& trials) {
  constexpr int kBands = 10;
  const std::vector<int> scenes = ScenesOf(trials);
  std::vector<FillBand> bands;
  for (int i = 0; i <= kBands; ++i) {
    FillBand band{static_cast<double>(i) / kBands, static_cast<double>(i + 1) / kBands, {}};
    if (i == kBands) band.fill_max = std::numeric_limits<double>::infinity();
    band.success =
        ClusterRate(CountByScene(trials, scenes, SuccessByFill(band.fill_min, band.fill_max)));
    if (band.success.samples > 0) bands.push_back(band);
  }
  return bands;
}

std::string LayerRate::name() const { return fmt::format("{}{}", layer, is_last ? "-" : ""); }

std::vector<LayerRate> SuccessByLayers(const std::vector<TrialResult>& trials) {
  constexpr int kLayers = 5;
  const std::vector<int> scenes = ScenesOf(trials);
  std::vector<LayerRate> rates;
  for (int layer = 1; layer <= kLayers; ++layer) {
    LayerRate rate{layer, layer == kLayers, {}};
    const int last = rate.is_last ? std::numeric_limits<int>::max() : layer;
    rate.success = ClusterRate(CountByScene(trials, scenes, SuccessByLayer(layer, last)));
    if (rate.success.samples > 0) rates.push_back(rate);
  }
  return rates;
}

}  // namespace pickbed::eval
