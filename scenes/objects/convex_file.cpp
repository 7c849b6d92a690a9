#include "scenes/objects/convex_file.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <Eigen/SVD>
#include <cmath>
#include <locale>
#include <sstream>

#include "scenes/base/error.h"
#include "scenes/base/files.h"
#include "scenes/base/message_text.h"
#include "scenes/mesh_io/mesh_io.h"

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
  for (std::string line; std::getline(lines, line);) {
    ++number;
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
    }
  }
  check_last_piece();
  CheckInput(!pieces.empty(),
             fmt::format("'{}' has no 'o' group and therefore no pieces", path.string()));
  return pieces;
}

}  // namespace pickbed::scenes
