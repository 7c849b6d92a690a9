#include "scenes/mesh_io/mesh_inspection.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numeric>
#include <regex>
#include <sstream>
#include <tuple>

#include "scenes/base/error.h"
#include "scenes/base/files.h"
#include "scenes/mesh_io/mesh_checks.h"
#include "scenes/mesh_io/mesh_io.h"

namespace pickbed::scenes {
namespace {

namespace fs = std::filesystem;

constexpr double kSmallestPick_m = 0.005, kLargestPick_m = 0.6;
constexpr double kTypical_m = 0.1;
constexpr double kSmallest_m = 0.003, kLargest_m = 5;
constexpr double kFarOrigin_diameters = 2;
constexpr double kTooFarOrigin_diameters = 100;

std::string ExtensionOf(const fs::path& file) {
  std::string extension = file.extension().string();
  for (char& c : extension) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return extension;
}

// Returns the text after a keyword at the beginning of a line. Names may contain spaces.
std::vector<std::string> LinesAfter(const std::string& text, const std::string& keyword) {
  std::vector<std::string> found;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    const size_t begin = line.find_first_not_of(" \t");
    if (begin == std::string::npos || line.compare(begin, keyword.size(), keyword) != 0) continue;
    const size_t value = line.find_first_not_of(" \t", begin + keyword.size());
    const size_t end = line.find_last_not_of(" \t\r");
    if (value != std::string::npos && value > begin + keyword.size() - 1) {
      found.push_back(line.substr(value, end + 1 - value));
    }
  }
  return found;
}

// Returns the values of "uri" with the extension of an image. Missing buffers are reported by
// assimp.
std::vector<std::string> PicturesInGltf(const fs::path& file) {
  static const std::regex kUri(R"re("uri"\s*:\s*"([^"]+\.(png|jpe?g|webp|bmp))")re",
                               std::regex::icase);
  const std::string text = ReadFileBytes(file);
  std::vector<std::string> names;
  for (std::sregex_iterator match(text.begin(), text.end(), kUri), end; match != end; ++match) {
    names.push_back((*match)[1]);
  }
  return names;
}

// Counts the groups of faces that are connected by edges. Vertices at the same place are one.
int CountShells(const TriangleMesh& mesh) {
  std::vector<int> group(mesh.triangles.size());
  std::iota(group.begin(), group.end(), 0);
  const auto root = [&](int i) {
    while (group[i] != i) i = group[i] = group[group[i]];
    return i;
  };
  std::map<std::tuple<double, double, double>, int> place_of;
  std::map<std::pair<int, int>, int> face_of_edge;
  for (size_t f = 0; f < mesh.triangles.size(); ++f) {
    std::array<int, 3> corner;
    for (int k = 0; k < 3; ++k) {
      const Eigen::Vector3d& p = mesh.vertices[mesh.triangles[f][k]];
      const int next = static_cast<int>(place_of.size());
      corner[k] = place_of.try_emplace({p.x(), p.y(), p.z()}, next).first->second;
    }
    for (int k = 0; k < 3; ++k) {
      const auto edge = std::minmax(corner[k], corner[(k + 1) % 3]);
      const auto [entry, is_new] = face_of_edge.try_emplace(edge, static_cast<int>(f));
      if (!is_new) group[root(static_cast<int>(f))] = root(entry->second);
    }
  }
  int shells = 0;
  for (size_t f = 0; f < group.size(); ++f) shells += group[f] == static_cast<int>(f);
  return shells;
}

void DescribeSurface(const TriangleMesh& as_loaded, InspectedMesh& inspected) {
  const MeshReport report = InspectMesh(as_loaded);
  inspected.watertight = report.watertight();
  inspected.shells = CountShells(as_loaded);
  if (report.volume_m3 < 0)
    inspected.fixed.push_back("faces pointed inwards and were flipped outwards");
  if (!report.watertight()) {
    inspected.notes.push_back(fmt::format(
        "open along {} of its edges: mass and inertia are computed from its convex hull",
        report.open_edges));
  }
  if (report.flipped_edges > 0) {
    inspected.notes.push_back(
        fmt::format("faces disagree about the outside along {} edges: they are drawn from both "
                    "sides or not at all",
                    report.flipped_edges));
  }
  if (inspected.shells > 1) {
    inspected.notes.push_back(
        fmt::format("{} separate shells: they move as one rigid object", inspected.shells));
  }
}

void DescribeOrigin(const std::string& source, bool center, InspectedMesh& inspected) {
  const Bounds bounds = MeshBounds(inspected.mesh_O);
  const double away_m = bounds.center().norm();
  if (center && away_m > 0) {
    inspected.mesh_O = Transformed(inspected.mesh_O, Translation(-bounds.center()));
    inspected.fixed.push_back(fmt::format(
        "the origin was {:.1f} mm from the object center and was moved there", 1e3 * away_m));
  } else if (away_m > kTooFarOrigin_diameters * bounds.size().norm()) {
    throw InputError(
        fmt::format("mesh '{}': its origin is {:.3g} m away from the object, too far for accurate "
                    "rotations; enable centering to move it to the object center",
                    source, away_m));
  } else if (away_m > kFarOrigin_diameters * bounds.size().norm()) {
    inspected.notes.push_back(fmt::format(
        "the origin is {:.3g} m away from the object; centering moves it to the object center",
        away_m));
  }
}

}  // namespace

UnitGuess GuessUnit(double diameter_in_file) {
  const auto size_in = [&](const char* unit) { return diameter_in_file * UnitInMeters(unit); };
  const auto pickable = [&](const char* unit) {
    return size_in(unit) >= kSmallestPick_m && size_in(unit) <= kLargestPick_m;
  };
  const auto guess = [&](const char* unit) {
    return UnitGuess{
        unit, fmt::format(
                  "its coordinates span {:.4g}; in {} this is {:.4g} mm, a size that can be picked",
                  diameter_in_file, unit, 1e3 * size_in(unit))};
  };
  const std::array<const char*, 2> usual{"m", "mm"};
  for (const char* unit : usual) {
    if (pickable(unit)) return guess(unit);
  }
  const std::array<const char*, 4> all{"m", "mm", "cm", "in"};
  const char* nearest =
      *std::min_element(all.begin(), all.end(), [&](const char* a, const char* b) {
        return std::abs(std::log(size_in(a) / kTypical_m)) <
               std::abs(std::log(size_in(b) / kTypical_m));
      });
  return guess(nearest);
}

std::vector<std::string> MissingCompanions(const fs::path& file) {
  std::vector<std::string> missing;
  std::error_code error;
  const auto is_there = [&](std::string name) {
    std::replace(name.begin(), name.end(), '\\', '/');
    return fs::is_regular_file(file.parent_path() / name, error) ||
           fs::is_regular_file(file.parent_path() / fs::path(name).filename(), error);
  };
  std::vector<std::string> textures;
  const std::string extension = ExtensionOf(file);
  if (extension == ".gltf") textures = PicturesInGltf(file);
  if (extension == ".obj") {
    for (const std::string& material : LinesAfter(ReadFileBytes(file), "mtllib")) {
      if (!is_there(material)) {
        missing.push_back(material);
        continue;
      }
      for (const std::string& map :
           LinesAfter(ReadFileBytes(file.parent_path() / material), "map_Kd")) {
        textures.push_back(map);
      }
    }
  }
  std::copy_if(textures.begin(), textures.end(), std::back_inserter(missing),
               [&](const std::string& name) { return !is_there(name); });
  return missing;
}

InspectedMesh InspectMeshFile(const fs::path& file, const std::string& unit, bool center) {
  InspectedMesh inspected;
  MeshLoadReport load;
  TriangleMesh mesh = LoadMesh(file, "m", &load);
  RequireUsableMesh(mesh, file.string());
  const size_t faces = mesh.triangles.size();
  mesh = WithoutRepeatedFaces(std::move(mesh));
  if (mesh.triangles.size() < faces) {
    inspected.fixed.push_back(
        fmt::format("{} duplicate faces were removed", faces - mesh.triangles.size()));
  }
  const int contradictions = InspectMesh(mesh).flipped_edges;
  if (contradictions > 0) {
    mesh = WithAgreeingFaces(std::move(mesh));
    inspected.fixed.push_back(
        fmt::format("faces disagreed about the outside along {} edges and were reversed",
                    contradictions - InspectMesh(mesh).flipped_edges));
  }
  if (load.degenerate_faces > 0) {
    inspected.fixed.push_back(fmt::format(
        "{} faces had two corners at one position and were removed", load.degenerate_faces));
  }
  if (load.bad_normals) {
    inspected.fixed.push_back(
        "some normals were zero or not of unit length and were recomputed from the faces");
  }
  const double diameter = Diameter(mesh);
  inspected.unit = unit;
  if (unit.empty()) {
    const UnitGuess guess = GuessUnit(diameter);
    inspected.unit = guess.unit;
    inspected.notes.push_back(fmt::format(
        "unit guessed: {}, because {}; give the unit if this is wrong", guess.unit, guess.reason));
  }
  const double scale = UnitInMeters(inspected.unit);
  const double diameter_m = scale * diameter;
  CheckInput(diameter_m >= kSmallest_m && diameter_m <= kLargest_m,
             fmt::format("mesh '{}' is {:.3g} m large when read in {}; objects must be between 3 "
                         "mm and 5 m: check the unit",
                         file.string(), diameter_m, inspected.unit));
  mesh = Scaled(mesh, scale);
  DescribeSurface(mesh, inspected);
  inspected.mesh_O = TurnedOutwards(std::move(mesh));
  DescribeOrigin(file.string(), center, inspected);
  for (const std::string& name : MissingCompanions(file)) {
    inspected.notes.push_back(
        fmt::format("'{}' is missing: without it the object is drawn in a plain color", name));
  }
  return inspected;
}

}  // namespace pickbed::scenes
