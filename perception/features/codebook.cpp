#include "perception/features/codebook.h"

#include <fmt/format.h>

#include <cstring>
#include <future>
#include <utility>

#include "scenes/base/byte_blocks.h"
#include "scenes/base/error.h"

namespace pickbed::perception {
namespace {

// Increase it if the content of the file or the making of entries changes.
constexpr int kFormat = 3;
constexpr size_t kValuesOfPose = 12;

}  // namespace

Pose CodePose(const ObjectCodes& codes, size_t entry) {
  Pose X_PO = Pose::Identity();
  X_PO.matrix().topRows<3>() = codes.X_PO[entry].cast<double>();
  return X_PO;
}

void AppendCodes(const LabelledPatches& patches, const DescribePatches& describe,
                 ObjectCodes& codes) {
  const std::vector<float> rows = describe(patches.values);
  codes.descriptors.insert(codes.descriptors.end(), rows.begin(), rows.end());
  for (const Pose& X_PO : patches.X_PO) {
    codes.X_PO.push_back(X_PO.matrix().topRows<3>().cast<float>());
  }
}

ObjectCodes MakeObjectCodes(LabelledViewSource& views, ObjectId object, const PatchForm& form,
                            int length, const DescribePatches& describe,
                            const IsolatedOptions& options, uint64_t seed, int threads,
                            const std::function<void(double)>& on_share) {
  const auto when = threads > 1 ? std::launch::async : std::launch::deferred;
  ObjectCodes codes;
  codes.length = length;
  std::future<void> described;
  ForEachIsolatedBlock(
      views, object, form, options, seed, [&](LabelledPatches patches, double share) {
        if (described.valid()) described.get();
        described = std::async(
            when, [&, block = std::move(patches)] { AppendCodes(block, describe, codes); });
        if (on_share) on_share(share);
        return true;
      });
  if (described.valid()) described.get();
  return codes;
}

std::filesystem::path CodesFile(const std::filesystem::path& cache_dir, const ObjectModel& model,
                                uint64_t key) {
  return cache_dir / fmt::format("codes-v{}-{}-{:016x}.bin", kFormat, model.name, key);
}

std::string CodesToBytes(const ObjectCodes& codes, uint64_t key) {
  BlockWriter writer;
  writer.Put(&key, sizeof key);
  writer.Put(&codes.length, sizeof codes.length);
  writer.Put(codes.descriptors);
  writer.Put(codes.X_PO.data(), codes.size() * kValuesOfPose * sizeof(float));
  return writer.body();
}

std::optional<ObjectCodes> CodesFromBytes(std::string_view content, uint64_t key) {
  BlockReader reader(content);
  const std::vector<uint64_t> keys = reader.TakeAll<uint64_t>();
  const std::vector<int> lengths = reader.TakeAll<int>();
  CheckInput(keys.size() == 1 && lengths.size() == 1 && lengths[0] > 0, "its head is damaged");
  if (keys[0] != key) return std::nullopt;
  ObjectCodes codes;
  codes.length = lengths[0];
  codes.descriptors = reader.TakeAll<float>();
  const std::vector<float> poses = reader.TakeAll<float>();
  reader.RequireEnd();
  const size_t entries = poses.size() / kValuesOfPose;
  CheckInput(poses.size() == entries * kValuesOfPose &&
                 codes.descriptors.size() == entries * static_cast<size_t>(codes.length),
             "its descriptors and poses do not fit together");
  codes.X_PO.resize(entries);
  if (entries > 0)
    std::memcpy(codes.X_PO.front().data(), poses.data(), poses.size() * sizeof(float));
  return codes;
}

}  // namespace pickbed::perception
