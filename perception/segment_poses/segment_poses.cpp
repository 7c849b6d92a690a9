#include "perception/segment_poses/segment_poses.h"

#include <fmt/format.h>

#include <algorithm>
#include <numeric>
#include <optional>

#include "perception/completion/completion_file.h"
#include "perception/completion/segment_window.h"
#include "scenes/base/cache_file.h"
#include "scenes/base/files.h"

namespace pickbed::perception {
namespace {

// Hash of everything that a codebook depends on.
uint64_t BookKey(const SegmentPoseOptions& options, const ObjectModel& model,
                 const std::string& views) {
  CompletionOptions completion = options.completion;  // Visit() is not const
  VolumeBookOptions book = options.book;
  std::string text = WriteSettingsKey([&](SettingsVisitor& v) { completion.Visit(v); });
  text += WriteSettingsKey([&](SettingsVisitor& v) { book.Visit(v); });
  text += fmt::format("{:016x} {}", model.mesh_hash, views);
  for (const CompleterRow& row : CompleterTable()) {
    const bool has_model = row.name == completion.method && row.kind != nullptr;
    if (has_model) text += ReadFileBytes(TrainedFile(completion.model));
  }
  return HashBytes(text.data(), text.size());
}

VolumeBook BookOf(const SegmentPoseSetup& setup, ObjectId object, ShapeCompleter& completer,
                  const SegmentPoseOptions& options) {
  const ObjectModel& model = *setup.views.objects()[object];
  const auto make = [&] {
    return MakeVolumeBook(setup.views, object, completer, options.book, [&](double share) {
      if (setup.on_progress) setup.on_progress("completed views of " + model.name, share);
    });
  };
  if (setup.cache_dir.empty()) return make();
  const uint64_t key = BookKey(options, model, setup.views.IsolatedSettings());
  const auto read = [key](const std::string& content) { return VolumeBookFromBytes(content, key); };
  const auto write = [key](const VolumeBook& book) { return VolumeBookToBytes(book, key); };
  return Cached(
      setup.cache_dir / fmt::format("volumes-v2-{}-{:016x}.bin", model.name, key), read,
      // The file has rounded values. The first use must give the same poses as later ones.
      [&] { return read(write(make())).value(); }, write);
}

}  // namespace

SegmentPoseOptions::SegmentPoseOptions() {
  completion.cells = kInputCells;
  completion.turns = 1;
}

void SegmentPoseOptions::Visit(SettingsVisitor& v) {
  v.Group(
      "completion", [this](SettingsVisitor& g) { completion.Visit(g); },
      "settings of the completion");
  v.Group(
      "segmenter", [this](SettingsVisitor& g) { segmenter.Visit(g); },
      "settings of the segmentation");
  v.Integer("poses", poses, {1, 1000}, "raw poses of each object for each segment");
  v.Real("min_occluded", min_occluded, {0, 1},
         "share of its border from which a segment counts as occluded");
  v.Integer("max_segments", max_segments, {1, 100000},
            "number of segments that are completed, the largest first");
  v.Group(
      "book", [this](SettingsVisitor& g) { book.Visit(g); }, "settings of the codebook");
}

SegmentPoses::SegmentPoses(const SegmentPoseSetup& setup, const SegmentPoseOptions& options)
    : options_(options) {
  CheckSettings("SegmentPoseOptions", options_);
  completer_ = MakeCompleter(options_.completion);
  for (size_t i = 0; i < setup.views.objects().size(); ++i) {
    books_.push_back(BookOf(setup, ObjectId(i), *completer_, options_));
  }
}

std::vector<std::vector<PoseVote>> SegmentPoses::Propose(const OrganizedCloud& cloud,
                                                         StageSeconds& seconds) const {
  std::vector<SegmentView> views;
  {
    const StageTimer timer(seconds, "segments");
    const ObjectSegments found = SegmentCloud(cloud, options_.segmenter);
    std::vector<int> order(found.segments.size());
    std::iota(order.begin(), order.end(), 0);
    std::stable_sort(order.begin(), order.end(), [&](int a, int b) {
      return found.segments[a].pixels > found.segments[b].pixels;
    });
    for (const int i : order) {
      if (static_cast<int>(views.size()) >= options_.max_segments) break;
      SegmentView view =
          SegmentWindow(cloud.depth_m, cloud.intrinsics, found.labels, found.segments[i], i + 1);
      if (SegmentPixels(view) < kMinSegmentPixels) continue;
      view.occluders = MarkOccluders(view);
      if (OccludedBorder(view) >= options_.min_occluded) views.push_back(std::move(view));
    }
  }
  std::vector<CompletedVolume> volumes;
  {
    const StageTimer timer(seconds, "completion");
    volumes = completer_->CompleteAll(views);
  }
  const StageTimer timer(seconds, "volumes");
  std::vector<std::vector<PoseVote>> poses(books_.size());
  for (size_t segment = 0; segment < volumes.size(); ++segment) {
    const std::optional<Pose> X_CF = VolumeFrame(volumes[segment]);
    if (!X_CF) continue;
    for (size_t object = 0; object < books_.size(); ++object) {
      for (const Pose& X_FO :
           NearestVolumes(books_[object], volumes[segment], *X_CF, options_.poses)) {
        poses[object].push_back({*X_CF * X_FO, kNoPatch});
      }
    }
  }
  return poses;
}

double OccludedBorder(const SegmentView& view) {
  constexpr int kNear_px = 2;
  const Image<uint8_t> occluders = view.occluders.empty() ? MarkOccluders(view) : view.occluders;
  int border = 0, hidden = 0;
  for (int y = 0; y < view.segment.height(); ++y) {
    for (int x = 0; x < view.segment.width(); ++x) {
      if (!view.segment(x, y)) continue;
      const auto is_outside = [&](int column, int row) {
        return view.segment.Contains(column, row) && !view.segment(column, row);
      };
      if (!is_outside(x - 1, y) && !is_outside(x + 1, y) && !is_outside(x, y - 1) &&
          !is_outside(x, y + 1)) {
        continue;
      }
      ++border;
      bool is_hidden = false;
      for (int dy = -kNear_px; dy <= kNear_px; ++dy) {
        for (int dx = -kNear_px; dx <= kNear_px; ++dx) {
          is_hidden |= occluders.Contains(x + dx, y + dy) && occluders(x + dx, y + dy) != 0;
        }
      }
      hidden += is_hidden;
    }
  }
  return border == 0 ? 0 : static_cast<double>(hidden) / border;
}

}  // namespace pickbed::perception
