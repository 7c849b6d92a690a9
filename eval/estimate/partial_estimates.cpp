#include "eval/estimate/partial_estimates.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <array>
#include <charconv>
#include <vector>

#include "eval/store/settings_difference.h"
#include "scenes/base/error.h"
#include "scenes/base/files.h"

namespace pickbed::eval {
namespace {

namespace fs = std::filesystem;

// Returns the end of each complete record of a CSV text, after its line end. A quoted cell may have
// line ends.
std::vector<size_t> RecordEnds(const std::string& text) {
  std::vector<size_t> ends;
  bool is_quoted = false;
  for (size_t i = 0; i < text.size(); ++i) {
    if (text[i] == '"') is_quoted = !is_quoted;
    if (text[i] == '\n' && !is_quoted) ends.push_back(i + 1);
  }
  return ends;
}

// Reads the leading whole numbers of a line, each with a comma behind it. Returns whether it begins
// with so many.
template <size_t kCount>
bool ReadNumbers(std::string_view line, std::array<int, kCount>& numbers) {
  const char* at = line.data();
  const char* const end = at + line.size();
  for (int& number : numbers) {
    const auto [next, error] = std::from_chars(at, end, number);
    if (error != std::errc() || next == end || *next != ',' || number < 0) return false;
    at = next + 1;
  }
  return true;
}

// Removes what follows the first `size` bytes.
void CutFile(const fs::path& file, size_t size) {
  std::error_code error;
  fs::resize_file(file, size, error);
  CheckInput(!error, fmt::format("cannot write {}: {}", file.string(), error.message()));
}

void Rename(const fs::path& from, const fs::path& to) {
  std::error_code error;
  fs::rename(from, to, error);
  CheckInput(!error, fmt::format("cannot rename {} to {}: {}", from.string(), to.string(),
                                 error.message()));
}

// Text of a results file without its header.
std::string Lines(std::span<const DatasetEstimate> estimates) {
  const std::string text = WriteEstimates({estimates.begin(), estimates.end()});
  return text.substr(text.find('\n') + 1);
}

}  // namespace

PartialEstimates::PartialEstimates(const fs::path& folder, const std::string& name)
    : csv_(folder / (name + ".csv")),
      images_csv_(folder / (name + ".images.csv")),
      partial_csv_(folder / (name + ".partial.csv")),
      partial_images_csv_(folder / (name + ".partial.images.csv")),
      identity_file_(folder / (name + ".partial.yaml")) {}

void PartialEstimates::Begin(const std::string& identity, bool resume) {
  identity_ = identity;
  const bool has_lists = Exists(partial_csv_) || Exists(partial_images_csv_);
  if (Exists(identity_file_) && !has_lists) RemoveIdentity();  // killed at the end of Finish()
  const bool is_interrupted = Exists(identity_file_);
  if (resume) {
    CheckInput(is_interrupted,
               fmt::format("there is no {} of an interrupted run to resume; start a new one",
                           identity_file_.string()));
    const std::vector<std::string> differences =
        SettingsDifferences(ReadFileText(identity_file_), identity);
    CheckInput(differences.empty(),
               fmt::format("{} has the estimates of other inputs ({}); choose another results "
                           "folder",
                           partial_csv_.string(), fmt::join(differences, "; ")));
    if (Exists(partial_images_csv_)) Keep();
  } else if (is_interrupted && Exists(partial_images_csv_)) {
    const size_t records = RecordEnds(ReadFileText(partial_images_csv_)).size();
    CheckInput(records < 2,
               fmt::format("{} has the estimates of an interrupted run (images: {}); resume it, "
                           "or choose another results folder",
                           partial_csv_.string(), records - 1));
  }
}

void PartialEstimates::RemoveIdentity() {
  std::error_code none;
  fs::remove(identity_file_, none);
}

// The identity is written last, so that it never belongs to files of another run.
void PartialEstimates::CreateFiles() {
  WriteFileAtomically(partial_csv_, WriteEstimates({}));
  WriteFileAtomically(partial_images_csv_, DatasetImagesCsv({}));
  WriteFileAtomically(identity_file_, identity_);
  has_files_ = true;
}

// An image is finished if its line in the list of images is complete, which is written last.
void PartialEstimates::Keep() {
  // The earlier run ended in Finish(), or the file was removed.
  const bool is_renamed = !Exists(partial_csv_) && Exists(csv_);
  const std::string images = ReadFileBytes(partial_images_csv_);
  const std::string estimates = ReadFileBytes(is_renamed ? csv_ : partial_csv_);
  const auto require = [&](bool fits) {
    CheckInput(fits, fmt::format("{} and {} do not fit each other; choose another results folder",
                                 partial_csv_.string(), partial_images_csv_.string()));
  };
  const std::vector<size_t> image_ends = RecordEnds(images), ends = RecordEnds(estimates);
  require(images.starts_with(DatasetImagesCsv({})) && estimates.starts_with(WriteEstimates({})));
  size_t next = 1;  // record of the estimates; the first is the header
  for (size_t record = 1; record < image_ends.size(); ++record) {
    std::array<int, 3> image{};  // scene, image, poses
    require(ReadNumbers(std::string_view(images).substr(image_ends[record - 1]), image));
    const size_t poses = image[2];
    require(poses <= ends.size() - next);
    for (const size_t last = next + poses; next < last; ++next) {
      std::array<int, 2> place{};
      require(ReadNumbers(std::string_view(estimates).substr(ends[next - 1]), place) &&
              place[0] == image[0] && place[1] == image[1]);
    }
    require(finished_.insert({image[0], image[1]}).second);
    poses_ += poses;
  }
  if (is_renamed) {
    // The results of an earlier run have estimates of other images, too.
    require(next == ends.size());
    Rename(csv_, partial_csv_);
  }
  CutFile(partial_images_csv_, image_ends.back());
  CutFile(partial_csv_, ends[next - 1]);
  has_files_ = true;
}

void PartialEstimates::Add(const DatasetImageNote& note,
                           std::span<const DatasetEstimate> estimates) {
  if (!has_files_) CreateFiles();
  AppendToFile(partial_csv_, Lines(estimates));
  const std::string text = DatasetImagesCsv({note});
  AppendToFile(partial_images_csv_, text.substr(text.find('\n') + 1));
  finished_.insert({note.scene_id, note.image_id});
  poses_ += estimates.size();
}

void PartialEstimates::Finish() {
  if (!has_files_) CreateFiles();
  Rename(partial_csv_, csv_);
  Rename(partial_images_csv_, images_csv_);
  RemoveIdentity();
}

}  // namespace pickbed::eval
