#include "eval/train/draw.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "eval/draw/overlay.h"
#include "eval/draw/plot.h"
#include "perception/features/patch.h"
#include "scenes/geometry/decompositions.h"

namespace pickbed::eval {
namespace {

constexpr Rgb8 kBackground{28, 30, 36}, kPaper{250, 250, 250};
constexpr int kGap_px = 3;

// Twelve colors that are easy to distinguish; further objects repeat them.
constexpr std::array<Rgb8, 12> kObjectColors{{{0, 114, 178},
                                              {213, 94, 0},
                                              {0, 158, 115},
                                              {204, 121, 167},
                                              {230, 159, 0},
                                              {86, 180, 233},
                                              {20, 20, 20},
                                              {140, 86, 75},
                                              {128, 60, 190},
                                              {120, 140, 20},
                                              {230, 40, 60},
                                              {130, 130, 130}}};

uint8_t Byte(double share) {
  return static_cast<uint8_t>(std::lround(255 * std::clamp(share, 0.0, 1.0)));
}

Rgb8 PixelColor(std::span<const int8_t> patch, PatchChannels channels, int pixel) {
  if (IsUnknownAt(patch, pixel)) return kBackground;
  if (channels == PatchChannels::kDepthColor) return PatchColorAt(patch, pixel);
  const int8_t* values = patch.data() + pixel;
  const double depth = values[0] / 127.0;
  const Eigen::Vector3d normal(values[kPatchArea], values[2 * kPatchArea], values[3 * kPatchArea]);
  const double light = 0.75 - 0.25 * depth;
  if (normal.isZero()) return {Byte(0.5 * light), Byte(0.5 * light), Byte(0.5 * light)};
  const Eigen::Vector3d n = normal / 127.0;
  return {Byte(light * (0.5 + 0.5 * n.x())), Byte(light * (0.5 - 0.5 * n.y())),
          Byte(light * (0.5 - 0.5 * n.z()))};
}

Image<Rgb8> SideBySide(const std::vector<Image<Rgb8>>& pictures) {
  const int width = pictures.front().width(), height = pictures.front().height();
  const int count = static_cast<int>(pictures.size());
  Image<Rgb8> joined(count * (width + kGap_px) - kGap_px, height, kPaper);
  for (int i = 0; i < count; ++i) {
    for (int y = 0; y < height; ++y) {
      std::copy_n(pictures[i].row(y), width, joined.row(y) + i * (width + kGap_px));
    }
  }
  return joined;
}

// Returns the indices of the right or the wrong answers, alternating between objects.
std::vector<size_t> Spread(const std::vector<HeldOutAnswer>& answers, bool right) {
  std::vector<size_t> rows;
  for (size_t i = 0; i < answers.size(); ++i) {
    if (answers[i].right == right) rows.push_back(i);
  }
  std::stable_sort(rows.begin(), rows.end(), [&](size_t a, size_t b) {
    return std::pair(answers[a].query, answers[a].object) <
           std::pair(answers[b].query, answers[b].object);
  });
  return rows;
}

}  // namespace

Image<Rgb8> DrawPatch(std::span<const int8_t> patch, PatchChannels channels, int zoom) {
  Image<Rgb8> image(zoom * kPatchPixels, zoom * kPatchPixels);
  for (int y = 0; y < image.height(); ++y) {
    for (int x = 0; x < image.width(); ++x) {
      image(x, y) = PixelColor(patch, channels, y / zoom * kPatchPixels + x / zoom);
    }
  }
  return image;
}

Image<Rgb8> DrawPairs(const std::vector<PatchPairs>& pairs, PatchChannels channels,
                      const ObjectSet& objects, int per_object) {
  std::vector<Image<Rgb8>> tiles;
  std::vector<std::string> captions;
  for (size_t object = 0; object < pairs.size(); ++object) {
    const size_t count = std::min<size_t>(per_object, pairs[object].size());
    for (size_t i = 0; i < count; ++i) {
      tiles.push_back(SideBySide({DrawPatch(pairs[object].anchors.patch(i), channels, 3),
                                  DrawPatch(pairs[object].codes.patch(i), channels, 3)}));
      captions.push_back(objects[object]->name);
    }
  }
  return ContactSheet(tiles, captions, 6);
}

Image<Rgb8> DrawAnswers(const std::vector<HeldOutAnswer>& answers, const HeldOutSet& set,
                        PatchChannels channels, const ObjectSet& objects, int count) {
  std::vector<size_t> wrong = Spread(answers, false), right = Spread(answers, true);
  const size_t half = count / 2;
  const size_t wrong_kept =
      std::min(wrong.size(), std::max(half, count - std::min<size_t>(count, right.size())));
  wrong.resize(wrong_kept);
  right.resize(std::min(right.size(), count - wrong_kept));
  wrong.insert(wrong.end(), right.begin(), right.end());
  std::vector<Image<Rgb8>> tiles;
  std::vector<std::string> captions;
  for (const size_t row : wrong) {
    const HeldOutAnswer& answer = answers[row];
    const PatchPairs& pairs = set.queries[answer.object];
    tiles.push_back(SideBySide({DrawPatch(pairs.anchors.patch(answer.query), channels, 3),
                                DrawPatch(answer.found, channels, 3),
                                DrawPatch(pairs.codes.patch(answer.query), channels, 3)}));
    std::string caption = objects[answer.object]->name;
    if (answer.found_object != answer.object)
      caption += " as " + objects[answer.found_object]->name;
    captions.push_back(caption + (answer.right ? ": right" : ": wrong"));
  }
  return ContactSheet(tiles, captions, 4);
}

Eigen::MatrixX2f PrincipalCoordinates(const Eigen::MatrixXf& rows) {
  const Eigen::MatrixXf centred = rows.rowwise() - rows.colwise().mean();
  const Eigen::MatrixXd scatter = (centred.transpose() * centred).cast<double>();
  const Eigen::MatrixXf axes = EigenOfSymmetric(scatter).vectors.cast<float>();
  // Eigenvalues are in ascending order.
  return centred * axes.rightCols<2>().rowwise().reverse();
}

Image<Rgb8> DrawEmbedding(const std::vector<HeldOutAnswer>& answers, const ObjectSet& objects,
                          int width, int height) {
  if (answers.size() < 2) return Image<Rgb8>(width, height, kPaper);
  Eigen::MatrixXf rows(answers.size(), answers.front().descriptor.size());
  for (size_t i = 0; i < answers.size(); ++i) rows.row(i) = answers[i].descriptor;
  Eigen::MatrixX2f places = PrincipalCoordinates(rows);
  // The y axis of the chart begins at 0.
  places.rowwise() -= places.colwise().minCoeff().eval();
  const bool one_object = objects.size() == 1;
  Chart chart{"first principal axis", "second principal axis", {}};
  if (!one_object) {
    for (size_t object = 0; object < objects.size(); ++object) {
      chart.series.push_back(
          {objects[object]->name, {}, kObjectColors[object % kObjectColors.size()], true});
    }
  }
  for (size_t i = 0; i < answers.size(); ++i) {
    const Eigen::Vector2d place = places.row(i).transpose().cast<double>();
    const Eigen::Vector3d side = 0.45 * (answers[i].view_O + Eigen::Vector3d::Ones());
    if (one_object) {
      chart.series.push_back({"", {place}, {Byte(side.x()), Byte(side.y()), Byte(side.z())}, true});
    } else {
      chart.series[answers[i].object].points.push_back(place);
    }
  }
  return DrawChart(chart, width, height);
}

}  // namespace pickbed::eval
