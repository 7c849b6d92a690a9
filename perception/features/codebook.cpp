#include "perception/features/codebook.h"

#include <fmt/format.h>

#include <cstring>
#include <future>
#include <utility>

#include "scenes/base/error.h"
#include "scenes/base/files.h"

namespace pickbed::perception {
namespace {

// Increase it if the file layout or the making of entries changes.
constexpr uint64_t kFormat = 2;
constexpr uint64_t kMagic = 0x314b4f4f42444350;  // "PCDBOOK1", little endian

struct FileHeader {
  uint64_t magic = kMagic;
  uint64_t format = kFormat;
  uint64_t key = 0;
  uint64_t length = 0;
  uint64_t entries = 0;
  uint64_t payload_hash = 0;
};

size_t PayloadBytes(const FileHeader& header) {
  return header.entries * (header.length * sizeof(float) + 12 * sizeof(float));
}

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

void WriteCodes(const std::filesystem::path& file, const ObjectCodes& codes, uint64_t key) {
  FileHeader header;
  header.key = key;
  header.length = static_cast<uint64_t>(codes.length);
  header.entries = codes.size();
  std::string payload(PayloadBytes(header), '\0');
  const size_t descriptor_bytes = codes.descriptors.size() * sizeof(float);
  if (!payload.empty()) {
    std::memcpy(payload.data(), codes.descriptors.data(), descriptor_bytes);
    std::memcpy(payload.data() + descriptor_bytes, codes.X_PO.data(),
                payload.size() - descriptor_bytes);
  }
  header.payload_hash = HashBytes(payload.data(), payload.size());
  std::string bytes(sizeof header, '\0');
  std::memcpy(bytes.data(), &header, sizeof header);
  WriteFileAtomically(file, bytes + payload);
}

std::optional<ObjectCodes> ReadCodes(const std::filesystem::path& file, uint64_t key) {
  if (!std::filesystem::exists(file)) return std::nullopt;
  const std::string bytes = ReadFileBytes(file);
  FileHeader header;
  if (bytes.size() < sizeof header) return std::nullopt;
  std::memcpy(&header, bytes.data(), sizeof header);
  const char* payload = bytes.data() + sizeof header;
  const size_t size = bytes.size() - sizeof header;
  // The bounds come before the product: a damaged count cannot overflow it.
  const bool whole = header.magic == kMagic && header.format == kFormat && header.key == key &&
                     header.length <= 1024 && header.entries <= size &&
                     size == PayloadBytes(header) &&
                     header.payload_hash == HashBytes(payload, size);
  if (!whole) return std::nullopt;
  ObjectCodes codes;
  codes.length = static_cast<int>(header.length);
  codes.descriptors.resize(header.entries * header.length);
  codes.X_PO.resize(header.entries);
  const size_t descriptor_bytes = codes.descriptors.size() * sizeof(float);
  if (header.entries > 0) {
    std::memcpy(codes.descriptors.data(), payload, descriptor_bytes);
    std::memcpy(codes.X_PO.front().data(), payload + descriptor_bytes, size - descriptor_bytes);
  }
  return codes;
}

}  // namespace pickbed::perception
