#include "scenes/mesh_io/mesh_io.h"

#include <assimp/config.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <assimp/Importer.hpp>
#include <cctype>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <iterator>
#include <map>
#include <optional>
#include <utility>

#include "scenes/base/error.h"
#include "scenes/base/files.h"
#include "scenes/image/image_io.h"
#include "scenes/mesh_io/mesh_join.h"

namespace pickbed::scenes {
namespace {

namespace fs = std::filesystem;

constexpr int kNoTexture = -1;

Eigen::Vector3d ToEigen(const aiVector3D& v) { return {v.x, v.y, v.z}; }

Eigen::Affine3d ToEigen(const aiMatrix4x4& m) {
  Eigen::Affine3d T;
  T.matrix() << m.a1, m.a2, m.a3, m.a4, m.b1, m.b2, m.b3, m.b4, m.c1, m.c2, m.c3, m.c4, 0, 0, 0, 1;
  return T;
}

uint8_t ToByte(float channel) {
  return static_cast<uint8_t>(std::lround(255 * std::clamp(channel, 0.f, 1.f)));
}

Rgb8 ToRgb(const aiColor4D& c) { return {ToByte(c.r), ToByte(c.g), ToByte(c.b)}; }

// ---- Materials ----

// Loads each colour texture of a file once and finds it by name.
class TextureShelf {
 public:
  TextureShelf(const aiScene& scene, const fs::path& folder) : scene_(scene), folder_(folder) {}

  // Returns the index of the material's texture, or kNoTexture if it has none or it is unreadable.
  int IndexOf(const aiMaterial& material) {
    aiString name;
    if (material.GetTexture(aiTextureType_BASE_COLOR, 0, &name) != aiReturn_SUCCESS &&
        material.GetTexture(aiTextureType_DIFFUSE, 0, &name) != aiReturn_SUCCESS) {
      return kNoTexture;
    }
    const auto [known, is_new] = index_by_name_.try_emplace(name.C_Str(), kNoTexture);
    if (!is_new) return known->second;
    std::optional<Image<Rgb8>> image = Read(name.C_Str());
    if (!image) return kNoTexture;
    images_.push_back(*std::move(image));
    return known->second = static_cast<int>(images_.size()) - 1;
  }

  const Image<Rgb8>& image(int index) const { return images_[index]; }

 private:
  std::optional<Image<Rgb8>> Read(const std::string& name) const {
    if (const aiTexture* embedded = scene_.GetEmbeddedTexture(name.c_str())) {
      if (embedded->mHeight != 0) return FromTexels(*embedded);
      return DecodeImage(
          std::string(reinterpret_cast<const char*>(embedded->pcData), embedded->mWidth));
    }
    // Exporters write paths of their own machine. The image is then often in the mesh's folder.
    std::string portable = name;
    std::replace(portable.begin(), portable.end(), '\\', '/');
    for (const fs::path& path : {folder_ / portable, folder_ / fs::path(portable).filename()}) {
      std::error_code error;
      if (fs::is_regular_file(path, error)) return DecodeImage(ReadFileBytes(path));
    }
    return std::nullopt;
  }

  static Image<Rgb8> FromTexels(const aiTexture& texture) {
    Image<Rgb8> image(static_cast<int>(texture.mWidth), static_cast<int>(texture.mHeight));
    for (size_t i = 0; i < image.size(); ++i) {
      image.data()[i] = {texture.pcData[i].r, texture.pcData[i].g, texture.pcData[i].b};
    }
    return image;
  }

  const aiScene& scene_;
  fs::path folder_;
  std::map<std::string, int> index_by_name_;
  std::vector<Image<Rgb8>> images_;
};

// Returns the material's colour, or the mesh's default colour if the file defines none. In this
// case assimp gives a material with its default name or, also for a missing .mtl, a grey of 0.6.
Rgb8 BaseColor(const aiMaterial& material) {
  const aiColor4D unstated(0.6f, 0.6f, 0.6f, 1.f);
  aiString name;
  material.Get(AI_MATKEY_NAME, name);
  if (name == aiString(AI_DEFAULT_MATERIAL_NAME)) return TriangleMesh().base_color;
  aiColor4D color = unstated;
  if (material.Get(AI_MATKEY_BASE_COLOR, color) != aiReturn_SUCCESS) {
    material.Get(AI_MATKEY_COLOR_DIFFUSE, color);
  }
  return color == unstated ? TriangleMesh().base_color : ToRgb(color);
}

// ---- Submeshes: one assimp mesh at one node ----

// A mesh with three own vertices for each triangle; vertices are not yet joined.
struct Submesh {
  TriangleMesh mesh;
  int texture = kNoTexture;
};

Submesh MakeSubmesh(const aiMesh& source, const Eigen::Affine3d& T, const aiMaterial& material,
                    TextureShelf& shelf) {
  Submesh submesh;
  TriangleMesh& mesh = submesh.mesh;
  mesh.base_color = BaseColor(material);
  if (source.HasTextureCoords(0)) submesh.texture = shelf.IndexOf(material);
  const Eigen::Matrix3d linear = T.linear();
  const bool mirrored = linear.determinant() < 0;
  const bool has_normals = source.HasNormals() && linear.determinant() != 0;
  const Eigen::Matrix3d for_normals = has_normals ? Eigen::Matrix3d(linear.inverse().transpose())
                                                  : Eigen::Matrix3d(Eigen::Matrix3d::Identity());
  for (unsigned f = 0; f < source.mNumFaces; ++f) {
    const aiFace& face = source.mFaces[f];
    if (face.mNumIndices != 3) continue;  // a point or a line
    const int first = static_cast<int>(mesh.vertices.size());
    mesh.triangles.emplace_back(first, first + (mirrored ? 2 : 1), first + (mirrored ? 1 : 2));
    for (int k = 0; k < 3; ++k) {
      const unsigned i = face.mIndices[k];
      mesh.vertices.push_back(T * ToEigen(source.mVertices[i]));
      if (has_normals) {
        mesh.normals.push_back((for_normals * ToEigen(source.mNormals[i])).normalized());
      }
      if (submesh.texture != kNoTexture) {
        const aiVector3D& uv = source.mTextureCoords[0][i];
        mesh.uvs.emplace_back(uv.x, 1.0 - uv.y);  // assimp counts v from the bottom row
      }
      if (source.HasVertexColors(0)) mesh.colors.push_back(ToRgb(source.mColors[0][i]));
    }
  }
  return submesh;
}

void CollectSubmeshes(const aiScene& scene, const aiNode& node, const Eigen::Affine3d& parent,
                      TextureShelf& shelf, std::vector<Submesh>& submeshes) {
  const Eigen::Affine3d T = parent * ToEigen(node.mTransformation);
  for (unsigned i = 0; i < node.mNumMeshes; ++i) {
    const aiMesh& mesh = *scene.mMeshes[node.mMeshes[i]];
    submeshes.push_back(MakeSubmesh(mesh, T, *scene.mMaterials[mesh.mMaterialIndex], shelf));
  }
  for (unsigned i = 0; i < node.mNumChildren; ++i) {
    CollectSubmeshes(scene, *node.mChildren[i], T, shelf, submeshes);
  }
}

// Replaces a texture by vertex colours, for files with several textures.
void BakeTexture(const Image<Rgb8>& texture, TriangleMesh& mesh) {
  mesh.colors.clear();
  for (const Eigen::Vector2d& uv : mesh.uvs) {
    const Eigen::Vector2d wrapped = uv - uv.array().floor().matrix();
    const int x = std::min(static_cast<int>(wrapped.x() * texture.width()), texture.width() - 1);
    const int y = std::min(static_cast<int>(wrapped.y() * texture.height()), texture.height() - 1);
    mesh.colors.push_back(texture(x, y));
  }
  mesh.uvs.clear();
}

// Joins the submeshes into one mesh. A mesh has only one texture, so several become vertex colours.
TriangleMesh Joined(std::vector<Submesh> submeshes, const TextureShelf& shelf) {
  const bool one_texture = std::all_of(
      submeshes.begin(), submeshes.end(),
      [&](const Submesh& submesh) { return submesh.texture == submeshes.front().texture; });
  TriangleMesh mesh;
  for (Submesh& submesh : submeshes) {
    if (!one_texture && submesh.texture != kNoTexture)
      BakeTexture(shelf.image(submesh.texture), submesh.mesh);
    Append(submesh.mesh, mesh);
  }
  if (!mesh.uvs.empty()) mesh.texture = shelf.image(submeshes.front().texture);
  return mesh;
}

std::string LowerExtension(const fs::path& path) {
  std::string extension = path.extension().string();
  for (char& c : extension) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return extension;
}

[[noreturn]] void RefuseUnreadable(const fs::path& path, const std::string& reason) {
  throw InputError("cannot read mesh '" + path.string() + "': " + reason +
                   "; check that the file is complete and that its extension matches its format "
                   "(.obj .ply .stl .dae .gltf .glb)");
}

void CheckFaceCount(const fs::path& path, size_t faces) {
  CheckInput(faces <= kMaxMeshFaces,
             fmt::format("mesh '{}' has {} faces; reduce it to {} or fewer, for instance with "
                         "MeshLab's quadric edge collapse",
                         path.string(), faces, kMaxMeshFaces));
}

// Rejects a PLY whose header has no end, such as a truncated file. assimp 5.2 never returns from
// it.
void CheckPlyHeader(const fs::path& path) {
  constexpr size_t kLongestLine = 4096;
  std::ifstream file(path, std::ios::binary);
  std::string line;
  for (bool first = true; std::getline(file, line); first = false) {
    if (!line.empty() && line.back() == '\r') line.pop_back();
    if (line == "end_header") return;
    if (first && line != "ply") break;
    if (line.size() > kLongestLine) break;
    size_t faces = 0;
    if (std::sscanf(line.c_str(), "element face %zu", &faces) == 1) CheckFaceCount(path, faces);
  }
  RefuseUnreadable(path, "it has no PLY header, or one without end");
}

// Checks the face count in the header before a large file is read.
void CheckHeader(const fs::path& path) {
  constexpr size_t kStlHeader = 84, kStlFace = 50;  // bytes of a binary STL
  const std::string extension = LowerExtension(path);
  if (extension == ".ply") CheckPlyHeader(path);
  if (extension != ".stl") return;
  std::ifstream file(path, std::ios::binary);
  std::array<char, kStlHeader> header{};
  if (!file.read(header.data(), kStlHeader)) return;
  uint32_t faces = 0;
  std::memcpy(&faces, header.data() + 80, sizeof(faces));
  if (fs::file_size(path) == kStlHeader + kStlFace * faces) CheckFaceCount(path, faces);
}

size_t CountFaces(const aiScene& scene, const aiNode& node) {
  size_t faces = 0;
  for (unsigned i = 0; i < node.mNumMeshes; ++i) faces += scene.mMeshes[node.mMeshes[i]]->mNumFaces;
  for (unsigned i = 0; i < node.mNumChildren; ++i) faces += CountFaces(scene, *node.mChildren[i]);
  return faces;
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
  const std::string name = path.string();
  std::error_code error;
  CheckInput(fs::is_regular_file(path, error),
             "mesh '" + name + "' does not exist; check the path");
  CheckHeader(path);
  Assimp::Importer importer;
  importer.SetPropertyBool(AI_CONFIG_IMPORT_COLLADA_IGNORE_UP_DIRECTION, true);
  const aiScene* scene = importer.ReadFile(path.string(), aiProcess_Triangulate);
  if (scene == nullptr || scene->mRootNode == nullptr) {
    RefuseUnreadable(path, importer.GetErrorString());
  }
  CheckFaceCount(path, CountFaces(*scene, *scene->mRootNode));
  TextureShelf shelf(*scene, path.parent_path());
  std::vector<Submesh> submeshes;
  CollectSubmeshes(*scene, *scene->mRootNode, Eigen::Affine3d(Eigen::Scaling(scale)), shelf,
                   submeshes);
  std::erase_if(submeshes, [](const Submesh& submesh) { return submesh.mesh.triangles.empty(); });
  CheckInput(!submeshes.empty(), "mesh '" + name + "' has no faces; export it as triangles");
  TriangleMesh mesh = Joined(std::move(submeshes), shelf);
  const size_t faces = mesh.triangles.size();
  DropDegenerate(mesh);
  if (report != nullptr) {
    report->degenerate_faces = static_cast<int>(faces - mesh.triangles.size());
    report->bad_normals = !NormalsAreUnit(mesh);
  }
  CheckInput(SurfaceArea(mesh) != 0, "mesh '" + name + "' has only faces without area");
  DropFlatNormals(mesh);
  return WithEqualVerticesJoined(mesh);
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
