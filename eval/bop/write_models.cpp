#include <fmt/format.h>

#include "eval/bop/json.h"
#include "eval/bop/layout.h"
#include "eval/bop/write_scene.h"
#include "scenes/base/files.h"
#include "scenes/image/image_io.h"

namespace pickbed::eval {
namespace {

namespace fs = std::filesystem;

constexpr double kToMm = 1e3;

// A mesh without vertex normals gets flat faces: each face has its own three corners and its
// normal.
TriangleMesh WithNormals(const TriangleMesh& mesh) {
  if (!mesh.normals.empty()) return mesh;
  TriangleMesh split;
  split.base_color = mesh.base_color;
  split.texture = mesh.texture;
  const std::vector<Eigen::Vector3d> face_normals = FaceNormals(mesh);
  for (size_t f = 0; f < mesh.triangles.size(); ++f) {
    const int first = static_cast<int>(split.vertices.size());
    split.triangles.emplace_back(first, first + 1, first + 2);
    for (const int i : mesh.triangles[f]) {
      split.vertices.push_back(mesh.vertices[i]);
      split.normals.push_back(face_normals[f]);
      if (!mesh.uvs.empty()) split.uvs.push_back(mesh.uvs[i]);
      if (!mesh.colors.empty()) split.colors.push_back(mesh.colors[i]);
    }
  }
  return split;
}

std::string Ply(const TriangleMesh& mesh, const std::string& texture_file) {
  const bool textured = !texture_file.empty();
  std::string text = "ply\nformat ascii 1.0\n";
  if (textured) text += fmt::format("comment TextureFile {}\n", texture_file);
  text += fmt::format("element vertex {}\n", mesh.vertices.size());
  for (const char* name : {"x", "y", "z", "nx", "ny", "nz"}) {
    text += fmt::format("property float {}\n", name);
  }
  text += textured ? "property float texture_u\nproperty float texture_v\n"
                   : "property uchar red\nproperty uchar green\nproperty uchar blue\n";
  text += fmt::format("element face {}\nproperty list uchar int vertex_indices\nend_header\n",
                      mesh.triangles.size());
  for (size_t i = 0; i < mesh.vertices.size(); ++i) {
    const Eigen::Vector3d p_mm = kToMm * mesh.vertices[i];
    const Eigen::Vector3d& n = mesh.normals[i];
    text += fmt::format("{:.7g} {:.7g} {:.7g} {:.7g} {:.7g} {:.7g}", p_mm.x(), p_mm.y(), p_mm.z(),
                        n.x(), n.y(), n.z());
    if (textured) {
      text += fmt::format(" {:.7g} {:.7g}\n", mesh.uvs[i].x(), 1 - mesh.uvs[i].y());
    } else {
      const Rgb8 color = mesh.colors.empty() ? mesh.base_color : mesh.colors[i];
      text += fmt::format(" {} {} {}\n", color.r, color.g, color.b);
    }
  }
  for (const Eigen::Vector3i& t : mesh.triangles) {
    text += fmt::format("3 {} {} {}\n", t.x(), t.y(), t.z());
  }
  return text;
}

ParsedJson ToJson(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }

ParsedJson InfoOf(const ObjectModel& model) {
  const Bounds bounds = MeshBounds(model.mesh_O);
  const Eigen::Vector3d low_mm = kToMm * bounds.min, size_mm = kToMm * bounds.size();
  ParsedJson info{{"diameter", kToMm * model.diameter_m},
                  {"min_x", low_mm.x()},
                  {"min_y", low_mm.y()},
                  {"min_z", low_mm.z()},
                  {"size_x", size_mm.x()},
                  {"size_y", size_mm.y()},
                  {"size_z", size_mm.z()},
                  {"name", model.name}};
  for (const Pose& X_OO : model.symmetries_O.discrete_O) {
    ParsedJson matrix = ParsedJson::array();
    for (int i = 0; i < 16; ++i) {
      matrix.push_back((i % 4 == 3 && i < 12 ? kToMm : 1) * X_OO.matrix()(i / 4, i % 4));
    }
    info["symmetries_discrete"].push_back(matrix);
  }
  for (const ContinuousSymmetry& axis : model.symmetries_O.continuous_O) {
    info["symmetries_continuous"].push_back(
        {{"axis", ToJson(axis.axis_O)}, {"offset", ToJson(kToMm * axis.offset_O)}});
  }
  return info;
}

}  // namespace

void WriteModels(const fs::path& folder, const ObjectSet& objects) {
  ParsedJson infos = ParsedJson::object();
  for (size_t i = 0; i < objects.size(); ++i) {
    const int id = static_cast<int>(i) + 1;
    const TriangleMesh mesh = WithNormals(objects[i]->mesh_O);
    const fs::path file = folder / ModelFileName(id);
    std::string texture_file;
    if (!mesh.uvs.empty() && !mesh.texture.empty()) {
      texture_file = file.stem().string() + ".png";
      WritePng(folder / texture_file, mesh.texture);
    }
    WriteFileAtomically(file, Ply(mesh, texture_file));
    infos[std::to_string(id)] = InfoOf(*objects[i]);
  }
  WriteFileAtomically(folder / kModelsInfoFile, infos.dump(2) + "\n");
}

void WriteDatasetCamera(const fs::path& file, const CameraIntrinsics& k) {
  const ParsedJson camera{{"cx", k.cx()},
                          {"cy", k.cy()},
                          {"fx", k.fx()},
                          {"fy", k.fy()},
                          {"width", k.width()},
                          {"height", k.height()},
                          {"depth_scale", kDepthScale_mm}};
  WriteFileAtomically(file, camera.dump(2) + "\n");
}

}  // namespace pickbed::eval
