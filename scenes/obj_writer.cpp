#include <fmt/format.h>

#include <iterator>

#include "scenes/files.h"
#include "scenes/image_io.h"
#include "scenes/mesh_io.h"

namespace pickbed {
namespace {

// Fixed notation, as importers read exponents badly; 10 decimals are a tenth of a nanometre.
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

}  // namespace pickbed
