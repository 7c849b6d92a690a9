#include "scenes/objects/convex_file.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <Eigen/SVD>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <locale>
#include <sstream>
#include <string_view>

#include "scenes/base/error.h"
#include "scenes/base/files.h"
#include "scenes/base/message_text.h"
#include "scenes/mesh_io/mesh_file_check.h"
#include "scenes/mesh_io/mesh_io.h"
#include "scenes/mesh_io/mesh_text_check.h"
#include "scenes/mesh_io/text_words.h"

namespace pickbed::scenes {
namespace {

constexpr size_t kFewestVertices = 4;   // fewer cannot enclose a volume
constexpr double kMaxCoordinate = 1e7;  // in the unit of the file, as of a mesh
// Thickness over length, see SpansAVolume().
constexpr double kThinnest = 2e-4;

// Returns whether the word is one finite number.
bool IsNumber(const std::string& word) {
  std::istringstream text(word);
  text.imbue(std::locale::classic());
  double number = 0;
  return text >> number && text.peek() == std::istringstream::traits_type::eof() &&
         std::isfinite(number);
}

// The largest index of a vertex among the faces, and its line.
struct FaceCorners {
  int64_t largest = 0;
  int line_of_largest = 0;

  // Adds the corners of a line that begins with "f". Returns false for a corner of index 0.
  bool Add(std::span<const std::string_view> words, int line) {
    if (words.empty() || words.front() != "f") return true;
    for (const std::string_view corner : words.subspan(1)) {
      int64_t index = 0;
      std::from_chars(corner.data(), corner.data() + corner.size(), index);
      if (index == 0) return false;
      if (std::abs(index) <= largest) continue;  // a negative index counts back
      largest = std::abs(index);
      line_of_largest = line;
    }
    return true;
  }
};

}  // namespace

bool SpansAVolume(std::span<const Eigen::Vector3d> points) {
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& p : points) mean += p / static_cast<double>(points.size());
  Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
  for (const Eigen::Vector3d& p : points) spread += (p - mean) * (p - mean).transpose();
  const Eigen::Matrix3d axes =
      Eigen::JacobiSVD<Eigen::Matrix3d>(spread, Eigen::ComputeFullU).matrixU();
  Eigen::AlignedBox3d box;
  for (const Eigen::Vector3d& p : points) box.extend(axes.transpose() * (p - mean));
  return box.sizes().minCoeff() > kThinnest * box.sizes().maxCoeff();
}

std::vector<ConvexPiece> LoadConvexPieces(const std::filesystem::path& path,
                                          const std::string& unit) {
  const double scale = UnitInMeters(unit);
  std::istringstream lines(ReadFileBytes(path));
  CheckMeshFile(path);
  std::vector<ConvexPiece> pieces;
  int number = 0;
  const auto check = [&](bool ok, const std::string& what) {
    CheckInput(ok, fmt::format("{}:{}: {}", path.string(), number, what));
  };
  const auto check_last_piece = [&] {
    check(pieces.empty() || pieces.back().vertices_O.size() >= kFewestVertices,
          fmt::format("a convex piece needs at least {} vertices", kFewestVertices));
    check(pieces.empty() || SpansAVolume(pieces.back().vertices_O),
          "the vertices of a convex piece are in one plane");
  };
  FaceCorners corners;
  bool continues = false;
  int64_t vertices = 0;
  for (std::string line; std::getline(lines, line);) {
    ++number;
    // A backslash at the end continues a long line, as faces have. They are not used.
    const bool is_continued = continues;
    continues =
        line.find_last_not_of(" \t\r") != line.npos && line[line.find_last_not_of(" \t\r")] == '\\';
    const bool is_long = is_continued || continues;
    std::istringstream words(line);
    words.imbue(std::locale::classic());  // a decimal point for every locale of the user
    std::string keyword;
    words >> keyword;
    if (keyword == "o") {
      check_last_piece();
      pieces.emplace_back();
    } else if (keyword == "v") {
      Eigen::Vector3d v;
      words >> v.x() >> v.y() >> v.z();
      check(!words.fail() && v.allFinite(), "'v' needs three numbers");
      for (std::string more; words >> more && more.front() != '#';) {  // a weight or a color
        check(IsNumber(more), fmt::format("'{}' follows the three numbers of 'v'", OneLine(more)));
      }
      check(v.cwiseAbs().maxCoeff() < kMaxCoordinate,
            fmt::format("a coordinate is {:g} or more", kMaxCoordinate));
      check(!pieces.empty(), "a vertex precedes the first 'o' line");
      pieces.back().vertices_O.push_back(scale * v);
      ++vertices;
    } else if (!is_long) {
      const std::vector<std::string_view> statement = WordsOf(std::string_view(line));
      const std::string fault = FaultOfObjLine(statement);
      check(fault.empty(), fmt::format("this line {}; export the pieces again", fault));
      check(corners.Add(statement, number),
            "a face has corner 0, but the first is 1; export the pieces again");
    }
  }
  check_last_piece();
  number = corners.line_of_largest;
  check(corners.largest <= vertices,
        fmt::format("a face has corner {}, but the file has {} vertices; export the pieces again",
                    corners.largest, vertices));
  CheckInput(!pieces.empty(),
             fmt::format("'{}' has no 'o' group and therefore no pieces", path.string()));
  return pieces;
}

}  // namespace pickbed::scenes
