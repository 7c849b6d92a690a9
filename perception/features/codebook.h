#pragma once

// Codebook: descriptors of patches with a known object pose. A query patch with a similar
// descriptor votes for the pose X_CO = X_CP * X_PO. Codebooks are made from isolated noisy views
// and cached on disk.

#include <filesystem>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "perception/features/labelled_patches.h"
#include "perception/features/pose_targets.h"
#include "scenes/base/ids.h"

namespace pickbed::perception {

// Maps count patches to count x length values; each row is a descriptor of unit norm.
using DescribePatches = std::function<std::vector<float>(std::span<const int8_t> patches)>;

// Codebook entries of one object.
struct ObjectCodes {
  int length = 0;                  // values of one descriptor
  std::vector<float> descriptors;  // entries x length
  std::vector<Eigen::Matrix<float, 3, 4>> X_PO;
  size_t size() const { return X_PO.size(); }
};

// Returns X_PO of an entry: the object pose in the patch frame.
Pose CodePose(const ObjectCodes& codes, size_t entry);

// Describes the patches and appends them to the entries.
void AppendCodes(const LabelledPatches& patches, const DescribePatches& describe,
                 ObjectCodes& codes);

// Renders isolated views of the object and returns its entries. With threads > 1 one block is
// described while the next is rendered. on_share receives the progress, 0..1; it may be empty.
ObjectCodes MakeObjectCodes(LabelledViewSource& views, ObjectId object, const PatchForm& form,
                            int length, const DescribePatches& describe,
                            const IsolatedOptions& options, uint64_t seed, int threads,
                            const std::function<void(double share)>& on_share);

// Returns the cache file of one object (scenes/base/cache_file.h). `key` is a hash of everything
// that the entries depend on: weights, mesh, sensor and options.
std::filesystem::path CodesFile(const std::filesystem::path& cache_dir, const ObjectModel& model,
                                uint64_t key);
// Returns the content of the cache file.
std::string CodesToBytes(const ObjectCodes& codes, uint64_t key);
// Returns the entries of a content; nullopt if they were made for another key. Throws InputError if
// the content is cut short, or its lists have sizes that do not fit together.
std::optional<ObjectCodes> CodesFromBytes(std::string_view content, uint64_t key);

// Network functions that pose voting uses, without the network itself.
struct PatchVoter {
  PatchChannels channels = PatchChannels::kDepthNormals;  // channels of the input patches
  DescribePatches describe;
  RegressPoses regress;  // empty if the network regresses no poses
  int object_count = 1;  // number of objects whose poses it regresses
};

}  // namespace pickbed::perception
