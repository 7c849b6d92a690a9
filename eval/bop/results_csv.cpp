#include "eval/bop/results_csv.h"

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <map>
#include <sstream>

#include "eval/bop/read_dataset.h"
#include "scenes/base/error.h"
#include "scenes/base/files.h"

namespace pickbed::eval {
namespace {

constexpr double kFarthest_mm = 1e9;  // as in the files of a data set
constexpr double kLongest_s = 1e7;    // almost four months for an image
constexpr double kSameTime_s = 1e-3;  // maximum difference between the lines of an image

std::vector<std::string> Split(const std::string& text, char separator) {
  std::vector<std::string> words;
  std::stringstream stream(text);
  for (std::string word; std::getline(stream, word, separator);) {
    if (separator != ' ' || !word.empty()) words.push_back(word);
  }
  return words;
}

// First line of the file, without the line end.
std::string Header() {
  const std::string line = HeaderLine(EstimateColumns());
  return line.substr(0, line.size() - 1);
}

std::string Trimmed(const std::string& text) {
  const size_t begin = text.find_first_not_of(" \t\r");
  if (begin == std::string::npos) return "";
  return text.substr(begin, text.find_last_not_of(" \t\r") - begin + 1);
}

// Parser of the fields of one line. Its messages name the line.
struct Line {
  std::string place;  // results.csv:3
  [[noreturn]] void Refuse(const std::string& what) const { throw InputError(place + ": " + what); }

  double Number(const std::string& field, const char* column) const {
    const std::string text = Trimmed(field);
    const char* begin = text.data() + (text.starts_with('+') ? 1 : 0);
    double value = 0;
    const auto [end, error] = std::from_chars(begin, text.data() + text.size(), value);
    if (error != std::errc() || end != text.data() + text.size() || !std::isfinite(value)) {
      Refuse(fmt::format("{} '{}' is no finite number", column, text));
    }
    return value;
  }
  int Id(const std::string& field, const char* column) const {
    const double value = Number(field, column);
    if (value < 0 || value > 1e9 || value != std::floor(value)) {
      Refuse(fmt::format("{} '{}' is not a whole number from 0", column, Trimmed(field)));
    }
    return static_cast<int>(value);
  }
  std::vector<double> Numbers(const std::string& field, size_t count, const char* column) const {
    const std::vector<std::string> words = Split(Trimmed(field), ' ');
    if (words.size() != count) {
      Refuse(fmt::format("{} has {} numbers separated by spaces, not {}", column, words.size(),
                         count));
    }
    std::vector<double> numbers;
    for (const std::string& word : words) numbers.push_back(Number(word, column));
    return numbers;
  }
};

DatasetEstimate ParseLine(const std::string& text, const Line& line) {
  const std::vector<std::string> fields = Split(text, ',');
  if (fields.size() != 7) {
    line.Refuse(fmt::format("has {} columns, not the 7 of {}", fields.size(), Header()));
  }
  DatasetEstimate estimate;
  estimate.place = line.place;
  estimate.scene_id = line.Id(fields[0], "scene_id");
  estimate.image_id = line.Id(fields[1], "im_id");
  estimate.object_id = line.Id(fields[2], "obj_id");
  estimate.score = line.Number(fields[3], "score");
  const std::vector<double> R = line.Numbers(fields[4], 9, "R");
  const std::vector<double> t_mm = line.Numbers(fields[5], 3, "t");
  for (const double number_mm : t_mm) {
    if (std::abs(number_mm) > kFarthest_mm) {
      line.Refuse(fmt::format("t has {}, beyond {:g} mm", number_mm, kFarthest_mm));
    }
  }
  estimate.time_s = line.Number(fields[6], "time");
  if (estimate.time_s > kLongest_s) {
    line.Refuse(fmt::format("time has {} s, over {:g} s", estimate.time_s, kLongest_s));
  }
  if (estimate.time_s < 0 && estimate.time_s != -1) {
    line.Refuse(fmt::format("time has {} s; give -1 if it is unknown", estimate.time_s));
  }
  Eigen::Matrix3d R_CO;
  for (int i = 0; i < 9; ++i) R_CO(i / 3, i % 3) = R[i];
  if (const std::string wrong = RotationFault(R_CO); !wrong.empty()) line.Refuse("R " + wrong);
  estimate.X_CO = MakePose(PublishedRotation(R_CO), 1e-3 * Eigen::Vector3d::Map(t_mm.data()));
  return estimate;
}

}  // namespace

ResultColumns EstimateColumns() {
  return {
      {"scene_id", "number of the scene"},
      {"im_id", "number of the image in its scene"},
      {"obj_id", "number of the object"},
      {"score", "score of the pose; higher is better"},
      {"R", "rotation matrix from the object frame to the camera frame, row by row"},
      {"t", "position of the object frame in the camera frame", "mm"},
      {"time", "time for the whole image, the same on all its lines; -1 = unknown", "s"},
  };
}

std::string WriteEstimates(const std::vector<DatasetEstimate>& estimates) {
  std::string csv = HeaderLine(EstimateColumns());
  for (const DatasetEstimate& estimate : estimates) {
    std::string R;
    for (int i = 0; i < 9; ++i) {
      R += fmt::format("{}{}", i ? " " : "", estimate.X_CO.linear()(i / 3, i % 3));
    }
    const Eigen::Vector3d t_mm = 1e3 * estimate.X_CO.translation();
    csv += fmt::format("{},{},{},{},{},{} {} {},{}\n", estimate.scene_id, estimate.image_id,
                       estimate.object_id, estimate.score, R, t_mm.x(), t_mm.y(), t_mm.z(),
                       estimate.time_s);
  }
  return csv;
}

std::vector<DatasetEstimate> ReadEstimates(const std::filesystem::path& file) {
  std::stringstream stream(ReadFileText(file));
  std::vector<DatasetEstimate> estimates;
  std::map<std::pair<int, int>, double> times_s;
  int number = 0;
  for (std::string text; std::getline(stream, text);) {
    const Line line{fmt::format("{}:{}", file.string(), ++number)};
    if (number == 1) {
      if (Trimmed(text) != Header()) {
        line.Refuse(fmt::format("begins with '{}', not with {}", Trimmed(text), Header()));
      }
      continue;
    }
    if (Trimmed(text).empty()) continue;
    estimates.push_back(ParseLine(text, line));
    const DatasetEstimate& e = estimates.back();
    const auto [known, is_new] = times_s.try_emplace({e.scene_id, e.image_id}, e.time_s);
    if (std::abs(known->second - e.time_s) > kSameTime_s) {
      line.Refuse(
          fmt::format("time is {} s, but an earlier line of scene {} image {} has {}; it must be "
                      "the time of the whole image",
                      e.time_s, e.scene_id, e.image_id, known->second));
    }
  }
  CheckInput(number > 0,
             fmt::format("{}: is empty; it must begin with {}", file.string(), Header()));
  return estimates;
}

}  // namespace pickbed::eval
