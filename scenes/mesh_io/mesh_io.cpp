#include "scenes/mesh_io/mesh_io.h"

#include <fmt/format.h>

#include <iterator>
#include <map>
#include <optional>
#include <string_view>
#include <utility>
#include <vector>

#include "scenes/base/byte_blocks.h"
#include "scenes/base/cache_file.h"
#include "scenes/base/error.h"
#include "scenes/base/files.h"
#include "scenes/base/isolated_call.h"
#include "scenes/base/random.h"
#include "scenes/geometry/mesh_bytes.h"
#include "scenes/image/image_io.h"
#include "scenes/mesh_io/mesh_file_check.h"
#include "scenes/mesh_io/mesh_import.h"

namespace pickbed::scenes {
namespace {

namespace fs = std::filesystem;

// Part of the file name. Raise it when the import gives another mesh.
constexpr int kImportVersion = 4;

// Hash of the content of a file, 0 = there is none.
uint64_t HashOfFile(const fs::path& file) {
  std::error_code error;
  if (!fs::is_regular_file(file, error)) return 0;
  const std::string bytes = ReadFileBytes(file);
  return HashBytes(bytes.data(), bytes.size());
}

// The blocks are the names of the used files, their hashes, the report and the mesh.
std::string ToBytes(const ImportedMesh& imported) {
  std::string names;
  std::vector<uint64_t> hashes;
  for (const fs::path& file : imported.used) {
    names += file.string() + '\0';
    hashes.push_back(HashOfFile(file));
  }
  BlockWriter writer;
  writer.Put(names);
  writer.Put(hashes);
  writer.Put(std::vector<int>{imported.report.degenerate_faces, imported.report.bad_normals});
  writer.Put(MeshToBytes(imported.mesh));
  return writer.body();
}

// Returns nullopt if a used file has changed since.
std::optional<ImportedMesh> FromBytes(std::string_view bytes) {
  BlockReader reader(bytes);
  ImportedMesh imported;
  std::string_view names = reader.Take();
  for (const uint64_t hash : reader.TakeAll<uint64_t>()) {
    const size_t end = names.find('\0');
    CheckInput(end != std::string_view::npos, "the names of its files are damaged");
    const fs::path file = names.substr(0, end);
    if (HashOfFile(file) != hash) return std::nullopt;
    imported.used.insert(file);
    names.remove_prefix(end + 1);
  }
  const std::vector<int> report = reader.TakeAll<int>();
  CheckInput(report.size() == 2, "its report is damaged");
  imported.report = {report[0], report[1] != 0};
  imported.mesh = MeshFromBytes(reader.Take());
  reader.RequireEnd();
  return imported;
}

// The key has the folder, because files beside the mesh belong to it.
fs::path CacheFileOf(const fs::path& path, double scale) {
  const std::string bytes = ReadFileBytes(path);
  const std::string rest = fmt::format("{} {} {}", path.extension().string(),
                                       fs::absolute(path).parent_path().string(), scale);
  const uint64_t hash = HashBytes(rest.data(), rest.size(), HashBytes(bytes.data(), bytes.size()));
  return CacheDir() / "meshes" / fmt::format("{:016x}-v{}.mesh", hash, kImportVersion);
}

ImportedMesh ImportIsolated(const fs::path& path, double scale) {
  try {
    const std::string bytes = CallIsolated([&] { return ToBytes(ImportMesh(path, scale)); });
    return FromBytes(bytes).value();
  } catch (const IsolationError& error) {
    RefuseUnreadable(path, std::string("the importer failed: ") + error.what());
  }
}

}  // namespace

double UnitInMeters(const std::string& unit) {
  static const std::map<std::string, double> kUnits = {
      {"m", 1.0}, {"cm", 0.01}, {"mm", 0.001}, {"in", 0.0254}};
  const auto known = kUnits.find(unit);
  CheckInput(known != kUnits.end(), "unknown unit '" + unit + "'; known: m, cm, mm, in");
  return known->second;
}

TriangleMesh LoadMesh(const fs::path& path, const std::string& unit, MeshLoadReport* report) {
  const double scale = UnitInMeters(unit);
  std::error_code error;
  CheckInput(fs::is_regular_file(path, error),
             "mesh '" + path.string() + "' does not exist; check the path");
  CheckMeshFile(path);
  ImportedMesh imported = Cached(
      CacheFileOf(path, scale), FromBytes, [&] { return ImportIsolated(path, scale); }, ToBytes);
  if (report != nullptr) *report = imported.report;
  return std::move(imported.mesh);
}

namespace {

// Uses fixed notation, because some importers do not read exponents correctly. 10 decimals are a
// tenth of a nanometre.
void AppendNumber(double value, std::string& text) {
  const size_t begin = text.size();
  fmt::format_to(std::back_inserter(text), " {:.10f}", value);
  text.erase(text.find_last_not_of('0') + 1);
  if (text.back() == '.') text.pop_back();
  if (text.compare(begin, std::string::npos, " -0") == 0) text.erase(begin + 1, 1);
}

template <typename Vector>
void AppendLine(const char* keyword, const Vector& numbers, std::string& text) {
  text += keyword;
  for (const double number : numbers) AppendNumber(number, text);
  text += '\n';
}

Eigen::Vector3d ToUnit(const Rgb8& c) { return Eigen::Vector3d(c.r, c.g, c.b) / 255; }

std::string FacesText(const TriangleMesh& mesh) {
  const bool has_uv = !mesh.uvs.empty(), has_normal = !mesh.normals.empty();
  std::string text;
  for (const Eigen::Vector3i& t : mesh.triangles) {
    text += 'f';
    for (const int index : t) {
      const std::string i = std::to_string(index + 1);
      text += ' ' + i;
      if (has_uv || has_normal) text += '/';
      if (has_uv) text += i;
      if (has_normal) text += '/' + i;
    }
    text += '\n';
  }
  return text;
}

std::string MaterialText(const TriangleMesh& mesh, const std::string& texture_name) {
  std::string text = "newmtl part\n";
  AppendLine("Kd", ToUnit(mesh.base_color), text);
  if (!texture_name.empty()) text += "map_Kd " + texture_name + "\n";
  return text;
}

}  // namespace

void SaveObj(const std::filesystem::path& path, const TriangleMesh& mesh) {
  std::filesystem::path material = path, texture = path;
  material.replace_extension(".mtl");
  texture.replace_extension(".png");
  const bool has_texture = !mesh.texture.empty();
  const bool has_material = has_texture || mesh.base_color != TriangleMesh().base_color;
  std::string text;
  if (has_material) text += "mtllib " + material.filename().string() + "\n";
  for (size_t i = 0; i < mesh.vertices.size(); ++i) {
    if (mesh.colors.empty()) {
      AppendLine("v", mesh.vertices[i], text);
    } else {
      Eigen::Matrix<double, 6, 1> place_and_color;
      place_and_color << mesh.vertices[i], ToUnit(mesh.colors[i]);
      AppendLine("v", place_and_color, text);
    }
  }
  for (const Eigen::Vector2d& uv : mesh.uvs) {  // OBJ counts v from the bottom row
    AppendLine("vt", Eigen::Vector2d(uv.x(), 1 - uv.y()), text);
  }
  for (const Eigen::Vector3d& n : mesh.normals) AppendLine("vn", n, text);
  if (has_material) text += "usemtl part\n";
  text += FacesText(mesh);
  WriteFileAtomically(path, text);
  if (has_texture) WritePng(texture, mesh.texture);
  if (has_material) {
    WriteFileAtomically(material,
                        MaterialText(mesh, has_texture ? texture.filename().string() : ""));
  }
}

}  // namespace pickbed::scenes
