#pragma once

// The code book: descriptors of patches of known pose. A query patch that is described alike votes
// for that pose: X_CO = X_CP * X_PO. Made from isolated noisy views and cached on disk.

#include <filesystem>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "perception/labelled_patches.h"

namespace pickbed {

// Gives count x length values, rows of unit length, for count patches.
using DescribePatches = std::function<std::vector<float>(std::span<const int8_t> patches)>;

// The entries of one part.
struct ObjectCodes {
  int length = 0;                  // of a descriptor
  std::vector<float> descriptors;  // entries x length
  std::vector<Eigen::Matrix<float, 3, 4>> X_PO;
  size_t size() const { return X_PO.size(); }
};

Pose CodePose(const ObjectCodes& codes, size_t entry);

void AppendCodes(const LabelledPatches& patches, const DescribePatches& describe,
                 ObjectCodes& codes);

// Renders and describes the part's entries; for threads > 1 one block is described while the next
// is rendered. on_share(0..1) may be empty.
ObjectCodes MakeObjectCodes(LabelledViewSource& views, int object, const PatchForm& form,
                            int length, const DescribePatches& describe,
                            const IsolatedOptions& options, uint64_t seed, int threads,
                            const std::function<void(double share)>& on_share);

// One file a part in the cache. `key` names all that the entries depend on: weights, mesh, sensor,
// options. Reading gives nothing for an absent, damaged or foreign file: it is made anew.
std::filesystem::path CodesFile(const std::filesystem::path& cache_dir, const ObjectModel& model,
                                uint64_t key);
void WriteCodes(const std::filesystem::path& file, const ObjectCodes& codes, uint64_t key);
std::optional<ObjectCodes> ReadCodes(const std::filesystem::path& file, uint64_t key);

}  // namespace pickbed
