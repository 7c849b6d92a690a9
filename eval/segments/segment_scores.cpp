#include "eval/segments/segment_scores.h"

#include <algorithm>
#include <map>
#include <stdexcept>
#include <utility>

namespace pickbed::eval {

SegmentScores ScoreSegments(const Image<uint16_t>& labels, const Image<uint16_t>& truth) {
  if (labels.width() != truth.width() || labels.height() != truth.height()) {
    throw std::logic_error("the images of segments and instances have different sizes");
  }
  std::map<int, int> segment_px, instance_px;
  std::map<std::pair<int, int>, int> common_px;  // instance, segment
  for (size_t i = 0; i < labels.size(); ++i) {
    const int segment = labels.data()[i], instance = truth.data()[i];
    if (segment > 0) ++segment_px[segment];
    if (instance > 0) ++instance_px[instance];
    if (segment > 0 && instance > 0) ++common_px[{instance, segment}];
  }
  SegmentScores scores;
  scores.segments = static_cast<int>(segment_px.size());
  std::map<int, SegmentedInstance> instances;
  double all_px = 0;
  for (const auto& [label, pixels] : instance_px) {
    instances[label] = {label, pixels};
    all_px += pixels;
  }
  std::map<int, std::pair<int, int>> assigned;  // segment -> common pixels, instance
  std::map<int, double> segment_iou;
  double under_error_px = 0;
  for (const auto& [pair, common] : common_px) {
    const auto [label, segment] = pair;
    SegmentedInstance& instance = instances[label];
    const int segment_size = segment_px[segment];
    const double iou = static_cast<double>(common) / (instance.pixels + segment_size - common);
    if (iou > instance.iou) {
      instance.iou = iou;
      instance.segment = segment;
    }
    segment_iou[segment] = std::max(segment_iou[segment], iou);
    under_error_px += std::min(common, segment_size - common);
    const auto [known, is_new] = assigned.try_emplace(segment, common, label);
    if (!is_new && common > known->second.first) known->second = {common, label};
  }
  std::map<int, std::pair<int, int>> best;  // instance -> common pixels, representing segment
  for (const auto& [segment, common_and_label] : assigned) {
    const auto [common, label] = common_and_label;
    ++instances[label].segments;
    auto& of_instance = best[label];
    if (common > of_instance.first) of_instance = {common, segment};
  }
  double true_px = 0, false_px = 0, overlap_px = 0;
  for (auto& [label, instance] : instances) {
    overlap_px += instance.pixels * instance.iou;
    if (const auto found = best.find(label); found != best.end()) {
      const auto [common, segment] = found->second;
      instance.in_segment = static_cast<double>(common) / instance.pixels;
      true_px += common;
      false_px += segment_px[segment] - common;
    }
    scores.instances.push_back(instance);
  }
  if (all_px > 0) {
    scores.weighted_overlap = overlap_px / all_px;
    scores.over = 1 - true_px / all_px;
    scores.under = false_px / all_px;
    scores.under_error = under_error_px / all_px;
  }
  for (const auto& [segment, iou] : segment_iou) {
    scores.matched_50 += iou > 0.5;
    scores.matched_75 += iou >= 0.75;
  }
  return scores;
}

}  // namespace pickbed::eval
