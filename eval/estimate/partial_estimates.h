#pragma once

// Estimates of a data set on disk while the work goes on, so that an interrupt loses none of them.
//
//   FOLDER/NAME.partial.csv         estimates of the finished images (eval/bop/results_csv.h)
//   FOLDER/NAME.partial.images.csv  one line per finished image (eval/frames/image_notes.h)
//   FOLDER/NAME.partial.yaml        text that identifies the inputs of the estimates
//
// The first two grow with each image. A complete run leaves NAME.csv and NAME.images.csv instead of
// these files.

#include <filesystem>
#include <set>
#include <span>
#include <string>

#include "eval/bop/results_csv.h"
#include "eval/bop/targets.h"
#include "eval/frames/image_notes.h"

namespace pickbed::eval {

class PartialEstimates {
 public:
  // Only keeps the names of the files.
  PartialEstimates(const std::filesystem::path& folder, const std::string& name);

  // Begins a run, which writes nothing before the first image. With `resume`, it keeps the images
  // that an interrupted run has finished, and removes the lines of the image in which it ended.
  // `identity` is a text in the form of RunIdentity() (eval/sweep/run.h). Throws InputError
  // - without `resume`, if there are images of an interrupted run,
  // - with `resume`, if there is no interrupted run, if it had another identity, or if its files do
  //   not fit each other.
  void Begin(const std::string& identity, bool resume);
  // Adds a finished image to the files. Throws InputError if they cannot be written.
  void Add(const DatasetImageNote& note, std::span<const DatasetEstimate> estimates);
  // Gives the files their final names. Throws InputError if they cannot be renamed.
  void Finish();

  const std::set<ListedImage>& finished() const { return finished_; }
  size_t poses() const { return poses_; }
  const std::filesystem::path& partial_csv() const { return partial_csv_; }
  const std::filesystem::path& csv() const { return csv_; }
  const std::filesystem::path& images_csv() const { return images_csv_; }

 private:
  void Keep();
  void CreateFiles();
  void RemoveIdentity();

  std::filesystem::path csv_, images_csv_, partial_csv_, partial_images_csv_, identity_file_;
  std::set<ListedImage> finished_;
  size_t poses_ = 0;
  std::string identity_;
  bool has_files_ = false;
};

}  // namespace pickbed::eval
