#include "perception/training/held_out.h"

#include <algorithm>
#include <numeric>

#include "perception/features/neighbors.h"
#include "perception/voting/pose_clustering.h"

namespace pickbed::perception {
namespace {

constexpr int kFound = 8;  // nearest entries for recall@8
constexpr int kViewsPerScene = 1;

// Positive patches so near that nearly all are right answers; Choose() drops the others.
PositivePairOptions NearPositives() {
  PositivePairOptions positives;
  positives.pairs_per_instance = 1;
  positives.rotation_rad = 0.03;
  positives.in_plane_rad = 0.03;
  positives.shift_px = 0.5;
  return positives;
}

// Returns at most `count` random pairs whose positive patch is a right answer.
PatchPairs Choose(const PatchPairs& pairs, const PoseDistance& distance, int count, Rng& rng) {
  std::vector<int> rows;
  for (size_t i = 0; i < pairs.size(); ++i) {
    if (distance(pairs.anchors.X_PO[i], pairs.codes.X_PO[i]) < kCorrectDiameters) {
      rows.push_back(static_cast<int>(i));
    }
  }
  for (int i = static_cast<int>(rows.size()) - 1; i > 0; --i) {
    std::swap(rows[i], rows[rng.Index(i + 1)]);
  }
  rows.resize(std::min<size_t>(rows.size(), count));
  PatchPairs chosen;
  for (const int row : rows) {
    AppendPatch(pairs.anchors, row, chosen.anchors);
    AppendPatch(pairs.codes, row, chosen.codes);
  }
  return chosen;
}

// Isolated views with the same range of distances as the object has in the clutter scene.
IsolatedOptions BookViews(const std::vector<LabelledView>& clutter_scene, ObjectId object,
                          int views) {
  IsolatedOptions options;
  options.views = views;
  options.patches_per_view = 4;
  options.focal_px = clutter_scene.front().frame.intrinsics.fx();
  double near_m = 0, far_m = 0;
  for (const LabelledView& view : clutter_scene) {
    for (const LabelledInstance& instance : view.instances) {
      if (instance.object != object) continue;
      const double distance_m = instance.X_CO.translation().norm();
      near_m = near_m > 0 ? std::min(near_m, distance_m) : distance_m;
      far_m = std::max(far_m, distance_m);
    }
  }
  if (far_m > 0) {
    options.distance_m = 0.5 * (near_m + far_m);
    options.distance_spread = std::clamp((far_m - near_m) / (far_m + near_m), 0.02, 0.5);
  }
  return options;
}

// Codebook of all objects: positive patches of object 0, its other patches, positive patches of
// object 1, and so on.
struct Book {
  struct Entry {
    ObjectId object{0};
    const LabelledPatches* patches = nullptr;
    int row = 0;
    const Pose& X_PO() const { return patches->X_PO[row]; }
  };
  std::vector<Entry> entries;
  std::vector<float> descriptors;
};

Book MakeBook(const HeldOutSet& set, const DescribePatches& describe) {
  Book book;
  for (size_t object = 0; object < set.queries.size(); ++object) {
    for (const LabelledPatches* patches : {&set.queries[object].codes, &set.distract[object]}) {
      for (size_t row = 0; row < patches->size(); ++row) {
        book.entries.push_back({ObjectId(object), patches, static_cast<int>(row)});
      }
      const std::vector<float> rows = describe(patches->values);
      book.descriptors.insert(book.descriptors.end(), rows.begin(), rows.end());
    }
  }
  return book;
}

bool IsRight(const Book::Entry& entry, ObjectId object, const Pose& X_PO,
             const PoseDistance& distance) {
  return entry.object == object && distance(entry.X_PO(), X_PO) < kCorrectDiameters;
}

double MeanOfKnown(const std::vector<double>& shares) {
  double sum = 0;
  int count = 0;
  for (const double share : shares) {
    if (share < 0) continue;
    sum += share;
    ++count;
  }
  return count > 0 ? sum / count : 0;
}

}  // namespace

void HeldOutOptions::Visit(SettingsVisitor& v) {
  v.RenamedKey("piles", "clutter_scenes");
  v.Integer("clutter_scenes", clutter_scenes, {1, 1000},
            "number of held-out clutter scenes per object");
  v.Integer("queries", queries, {1, 100000}, "maximum number of held-out patches per object");
  v.Integer("book_views", book_views, {0, 100000},
            "number of isolated views per object in the held-out codebook");
  v.Integer("every", every, {1, 1000000}, "training steps per object between two measurements");
  v.Integer("patience", patience, {0, 10000},
            "measurements without a gain before the schedule is shortened; 0 = never");
  v.Real("gain", gain, {0, 1}, "minimum increase of recall@1 that counts as a gain");
  v.Real("cooling", cooling, {0, 1}, "share of all steps in which a shortened schedule ends");
}

HeldOutSet MakeHeldOut(LabelledViewSource& views, const std::vector<PatchForm>& forms,
                       const HeldOutOptions& options, uint64_t seed,
                       const std::function<bool(double)>& on_share) {
  CheckSettings("HeldOutOptions", options);
  const ObjectSet& objects = views.objects();
  HeldOutSet set;
  set.queries.resize(objects.size());
  set.distract.resize(objects.size());
  std::vector<PatchPairs> pairs(objects.size());
  const int object_count = static_cast<int>(objects.size()),
            clutter_scenes = options.clutter_scenes * object_count;
  for (ObjectId object{0}; object < object_count; ++object) {
    std::vector<LabelledView> seen;
    for (int i = 0; i < options.clutter_scenes; ++i) {
      const int index = object * options.clutter_scenes + i;
      Rng rng = Rng::Derive(seed, index, "training/held_out_pile");
      std::vector<LabelledView> clutter_scene =
          views.ClutterScene({rng.Next(), kViewsPerScene, object, /*typical=*/true});
      AppendPositivePatches(views, clutter_scene, forms, NearPositives(), rng, pairs);
      std::move(clutter_scene.begin(), clutter_scene.end(), std::back_inserter(seen));
      if (!on_share(static_cast<double>(index + 1) / clutter_scenes)) return set;
    }
    if (options.book_views == 0) continue;
    bool go_on = true;
    ForEachIsolatedBlock(views, object, forms[object], BookViews(seen, object, options.book_views),
                         seed, [&](const LabelledPatches& patches, double) {
                           AppendAll(patches, set.distract[object]);
                           return go_on = on_share(static_cast<double>(object + 1) / object_count);
                         });
    if (!go_on) return set;
  }
  for (ObjectId object{0}; object < object_count; ++object) {
    Rng rng = Rng::Derive(seed, object, "training/held_out_choice");
    set.queries[object] =
        Choose(pairs[object], PoseDistance(*objects[object]), options.queries, rng);
  }
  return set;
}

HeldOutRecall MeasureRecall(const HeldOutSet& set, const ObjectSet& objects,
                            const DescribePatches& describe, int length) {
  const Book book = MakeBook(set, describe);
  HeldOutRecall recall;
  for (size_t object = 0; object < objects.size(); ++object) {
    const LabelledPatches& queries = set.queries[object].anchors;
    const PoseDistance distance(*objects[object]);
    const Neighbors found =
        SearchExactly(book.descriptors, describe(queries.values), length, kFound);
    int first = 0, any = 0;
    for (size_t q = 0; q < queries.size(); ++q) {
      for (int k = 0; k < kFound; ++k) {
        const int row = found.rows[q * kFound + k];
        const bool right =
            row >= 0 && IsRight(book.entries[row], ObjectId(object), queries.X_PO[q], distance);
        if (!right) continue;
        first += k == 0;
        ++any;
        break;
      }
    }
    const double count = static_cast<double>(queries.size());
    recall.object_at_1.push_back(count > 0 ? first / count : -1);
    recall.object_at_8.push_back(count > 0 ? any / count : -1);
  }
  recall.at_1 = MeanOfKnown(recall.object_at_1);
  recall.at_8 = MeanOfKnown(recall.object_at_8);
  return recall;
}

std::vector<HeldOutAnswer> AnswersOf(const HeldOutSet& set, const ObjectSet& objects,
                                     const DescribePatches& describe, int length, int per_object) {
  const Book book = MakeBook(set, describe);
  std::vector<HeldOutAnswer> answers;
  for (size_t object = 0; object < objects.size(); ++object) {
    const LabelledPatches& queries = set.queries[object].anchors;
    const PoseDistance distance(*objects[object]);
    const std::vector<float> rows = describe(queries.values);
    const Neighbors found = SearchExactly(book.descriptors, rows, length, 1);
    for (size_t q = 0; q < queries.size() && static_cast<int>(q) < per_object; ++q) {
      HeldOutAnswer& answer = answers.emplace_back();
      answer.object = ObjectId(object);
      answer.query = static_cast<int>(q);
      // The z axis of the patch frame points away from the camera.
      answer.view_O = -queries.X_PO[q].linear().transpose().col(2);
      answer.descriptor = Eigen::Map<const Eigen::VectorXf>(rows.data() + q * length, length);
      const Book::Entry& entry = book.entries.at(found.rows[q]);
      const auto patch = entry.patches->patch(entry.row);
      answer.found_object = entry.object;
      answer.found.assign(patch.begin(), patch.end());
      answer.right = IsRight(entry, answer.object, queries.X_PO[q], distance);
    }
  }
  return answers;
}

int PlateauOf(const std::vector<HeldOutRecall>& history, const HeldOutOptions& options) {
  if (options.patience == 0) return -1;
  double best = -1;
  int without = 0;
  for (size_t i = 0; i < history.size(); ++i) {
    if (history[i].at_1 >= best + options.gain) {
      best = history[i].at_1;
      without = 0;
    } else if (++without == options.patience) {
      return static_cast<int>(i);
    }
  }
  return -1;
}

}  // namespace pickbed::perception
