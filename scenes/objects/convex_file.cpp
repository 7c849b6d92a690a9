#include "scenes/objects/convex_file.h"

#include <fmt/format.h>

#include <cmath>
#include <locale>
#include <sstream>

#include "scenes/base/error.h"
#include "scenes/base/files.h"
#include "scenes/mesh_io/mesh_io.h"

namespace pickbed::scenes {
namespace {

constexpr size_t kFewestVertices = 4;  // fewer cannot enclose a volume

}  // namespace

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
