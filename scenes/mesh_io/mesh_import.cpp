#include "scenes/mesh_io/mesh_import.h"

#include <assimp/DefaultIOSystem.h>
#include <assimp/config.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <fmt/format.h>

#include <algorithm>
#include <assimp/DefaultLogger.hpp>
#include <assimp/Importer.hpp>
#include <assimp/LogStream.hpp>
#include <cmath>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "scenes/base/error.h"
#include "scenes/base/files.h"
#include "scenes/base/message_text.h"
#include "scenes/image/image_check.h"
#include "scenes/image/image_io.h"
#include "scenes/mesh_io/material_check.h"
#include "scenes/mesh_io/mesh_file_check.h"
#include "scenes/mesh_io/mesh_join.h"
#include "scenes/mesh_io/mesh_text_check.h"

namespace pickbed::scenes {
namespace {

// In the unit of the file. Larger ones are damaged, also in micrometres.
constexpr double kMaxCoordinate = 1e7;
// Computations leave 0 or more, so a number nearer to 0 is made of other bytes.
constexpr double kMinCoordinate = 1e-37;
// Some programs write normals of the length of the face's area.
constexpr double kMaxNormal = kMaxCoordinate * kMaxCoordinate;

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

// Loads each color texture of a file once and finds it by name.
class TextureLoader {
 public:
  // `used` receives the names of the files that were looked for.
  TextureLoader(const aiScene& scene, const fs::path& path, std::set<fs::path>& used)
      : scene_(scene), path_(path), folder_(path.parent_path()), used_(used) {}

  // Returns the index of the material's texture, or kNoTexture if there is none, or one of a format
  // that cannot be read. Throws InputError for a damaged one.
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

  void RequireNumbers(const Eigen::Vector2d& uv) const {
    CheckInput(uv.allFinite(), "mesh '" + path_.string() +
                                   "' has a texture coordinate that is no number; export it again");
  }

 private:
  std::optional<Image<Rgb8>> Read(const std::string& name) const {
    if (const aiTexture* embedded = scene_.GetEmbeddedTexture(name.c_str())) {
      if (embedded->mHeight != 0) return FromTexels(*embedded);
      return Decode(name,
                    std::string(reinterpret_cast<const char*>(embedded->pcData), embedded->mWidth));
    }
    // Exporters write paths of their own machine. The image is then often in the mesh's folder.
    std::string portable = name;
    std::replace(portable.begin(), portable.end(), '\\', '/');
    for (const fs::path& path : {folder_ / portable, folder_ / fs::path(portable).filename()}) {
      std::error_code error;
      used_.insert(path);
      if (fs::is_regular_file(path, error)) return Decode(path, ReadFileBytes(path));
    }
    return std::nullopt;
  }

  // A PNG or JPEG must be whole. Other formats can be ones that OpenCV does not know.
  std::optional<Image<Rgb8>> Decode(const fs::path& name, const std::string& bytes) const {
    const std::string extension = LowerExtension(name);
    const bool is_known = IsPng(bytes) || IsJpeg(bytes) || extension == ".png" ||
                          extension == ".jpg" || extension == ".jpeg";
    try {
      return DecodeImage(bytes);
    } catch (const InputError& error) {
      if (!is_known) return std::nullopt;
      RefuseUnreadable(path_, fmt::format("its texture '{}': {}", name.string(), error.what()));
    }
  }

  static Image<Rgb8> FromTexels(const aiTexture& texture) {
    Image<Rgb8> image(static_cast<int>(texture.mWidth), static_cast<int>(texture.mHeight));
    for (size_t i = 0; i < image.size(); ++i) {
      image.data()[i] = {texture.pcData[i].r, texture.pcData[i].g, texture.pcData[i].b};
    }
    return image;
  }

  const aiScene& scene_;
  const fs::path& path_;  // of the mesh
  fs::path folder_;
  std::set<fs::path>& used_;
  std::map<std::string, int> index_by_name_;
  std::vector<Image<Rgb8>> images_;
};

// Returns the material's color, or the mesh's default color if the file defines none. In this
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
                    TextureLoader& loader) {
  Submesh submesh;
  TriangleMesh& mesh = submesh.mesh;
  mesh.base_color = BaseColor(material);
  if (source.HasTextureCoords(0)) submesh.texture = loader.IndexOf(material);
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
        loader.RequireNumbers(mesh.uvs.back());
      }
      if (source.HasVertexColors(0)) mesh.colors.push_back(ToRgb(source.mColors[0][i]));
    }
  }
  return submesh;
}

// A normal that is not a number is allowed: some programs write it for a face without area.
void CheckNormals(const std::filesystem::path& path, const aiScene& scene) {
  for (unsigned m = 0; m < scene.mNumMeshes; ++m) {
    const aiMesh& mesh = *scene.mMeshes[m];
    for (unsigned i = 0; mesh.HasNormals() && i < mesh.mNumVertices; ++i) {
      const aiVector3D& normal = mesh.mNormals[i];
      for (const double component : {normal.x, normal.y, normal.z}) {
        CheckInput(!(std::abs(component) > kMaxNormal),
                   fmt::format("mesh '{}' has a normal with the component {:g}; export it again",
                               path.string(), component));
      }
    }
  }
}

// A texture coordinate that is not a number is allowed if there is no texture.
void CheckTextureCoordinates(const std::filesystem::path& path, const aiScene& scene) {
  for (unsigned m = 0; m < scene.mNumMeshes; ++m) {
    const aiMesh& mesh = *scene.mMeshes[m];
    for (unsigned i = 0; mesh.HasTextureCoords(0) && i < mesh.mNumVertices; ++i) {
      const aiVector3D& uv = mesh.mTextureCoords[0][i];
      for (const double coordinate : {uv.x, uv.y}) {
        CheckInput(!(std::abs(coordinate) > kMaxTextureCoordinate),
                   fmt::format("mesh '{}' has the texture coordinate {:g}; export it again",
                               path.string(), coordinate));
      }
    }
  }
}

void CollectSubmeshes(const aiScene& scene, const aiNode& node, const Eigen::Affine3d& parent,
                      TextureLoader& loader, std::vector<Submesh>& submeshes) {
  const Eigen::Affine3d T = parent * ToEigen(node.mTransformation);
  for (unsigned i = 0; i < node.mNumMeshes; ++i) {
    const aiMesh& mesh = *scene.mMeshes[node.mMeshes[i]];
    submeshes.push_back(MakeSubmesh(mesh, T, *scene.mMaterials[mesh.mMaterialIndex], loader));
  }
  for (unsigned i = 0; i < node.mNumChildren; ++i) {
    CollectSubmeshes(scene, *node.mChildren[i], T, loader, submeshes);
  }
}

// Replaces a texture by vertex colors, for files with several textures.
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

// Joins the submeshes into one mesh. A mesh has only one texture, so several become vertex colors.
TriangleMesh Joined(std::vector<Submesh> submeshes, const TextureLoader& loader) {
  const bool one_texture = std::all_of(
      submeshes.begin(), submeshes.end(),
      [&](const Submesh& submesh) { return submesh.texture == submeshes.front().texture; });
  TriangleMesh mesh;
  for (Submesh& submesh : submeshes) {
    if (!one_texture && submesh.texture != kNoTexture)
      BakeTexture(loader.image(submesh.texture), submesh.mesh);
    Append(submesh.mesh, mesh);
  }
  if (!mesh.uvs.empty()) mesh.texture = loader.image(submeshes.front().texture);
  return mesh;
}

size_t CountFaces(const aiScene& scene, const aiNode& node) {
  size_t faces = 0;
  for (unsigned i = 0; i < node.mNumMeshes; ++i) faces += scene.mMeshes[node.mMeshes[i]]->mNumFaces;
  for (unsigned i = 0; i < node.mNumChildren; ++i) faces += CountFaces(scene, *node.mChildren[i]);
  return faces;
}

// assimp's triangulation reads these indices unchecked, and asserts that a face has some.
void CheckFaces(const fs::path& path, const aiScene& scene) {
  size_t faces = 0;
  for (unsigned m = 0; m < scene.mNumMeshes; ++m) {
    const aiMesh& mesh = *scene.mMeshes[m];
    faces += mesh.mNumFaces;
    for (unsigned f = 0; f < mesh.mNumFaces; ++f) {
      const aiFace& face = mesh.mFaces[f];
      if (face.mNumIndices == 0) RefuseUnreadable(path, "a face has no vertices");
      for (unsigned k = 0; k < face.mNumIndices; ++k) {
        if (face.mIndices[k] < mesh.mNumVertices) continue;
        RefuseUnreadable(path, fmt::format("face {} has vertex {}, but there are {} vertices", f,
                                           face.mIndices[k], mesh.mNumVertices));
      }
    }
  }
  const size_t promised = FacesInHeader(path);
  if (faces < promised) {
    RefuseUnreadable(path,
                     fmt::format("its header names {} faces, but it has {}", promised, faces));
  }
}

// Notes the files that an importer looks for beside the mesh: materials and buffers.
class NotingFiles : public Assimp::DefaultIOSystem {
 public:
  explicit NotingFiles(std::set<fs::path>& used) : used_(used) {}
  bool Exists(const char* file) const override {
    used_.insert(file);
    return DefaultIOSystem::Exists(file);
  }
  Assimp::IOStream* Open(const char* file, const char* mode) override {
    used_.insert(file);
    return DefaultIOSystem::Open(file, mode);
  }

 private:
  std::set<fs::path>& used_;
};

// Notes the warnings with which Assimp drops faces.
class DropWarnings {
 public:
  DropWarnings() {
    Assimp::DefaultLogger::create("", Assimp::Logger::NORMAL, /*defStreams=*/0);
    Assimp::DefaultLogger::get()->attachStream(new Stream(warning_), Assimp::Logger::Warn);
  }
  ~DropWarnings() { Assimp::DefaultLogger::kill(); }  // deletes the stream
  DropWarnings(const DropWarnings&) = delete;
  DropWarnings& operator=(const DropWarnings&) = delete;
  // Returns the last warning, or an empty text.
  const std::string& last() const { return warning_; }

 private:
  class Stream : public Assimp::LogStream {
   public:
    explicit Stream(std::string& warning) : warning_(warning) {}
    void write(const char* message) override {
      // Texts of Assimp 5.2. Its other losses are lines, which are not loaded.
      const std::string_view text(message);
      for (const char* loss : {"out-of-range indices", "with the TRIANGLES mode"}) {
        if (text.find(loss) != std::string_view::npos) warning_ = message;
      }
    }

   private:
    std::string& warning_;
  };
  std::string warning_;
};

}  // namespace

ImportedMesh ImportMesh(const fs::path& path, double scale) {
  CheckMeshFile(path);
  CheckMeshText(path);
  ImportedMesh imported;
  const DropWarnings warnings;
  Assimp::Importer importer;
  importer.SetIOHandler(new NotingFiles(imported.used));  // the importer owns it
  importer.SetPropertyBool(AI_CONFIG_IMPORT_COLLADA_IGNORE_UP_DIRECTION, true);
  const aiScene* scene = importer.ReadFile(path.string(), aiProcess_ValidateDataStructure);
  CheckMaterials(path, imported.used);
  if (scene == nullptr || scene->mRootNode == nullptr) {
    RefuseUnreadable(path, importer.GetErrorString());
  }
  if (!warnings.last().empty()) RefuseUnreadable(path, OneLine(warnings.last()));
  CheckFaces(path, *scene);
  CheckNormals(path, *scene);
  CheckTextureCoordinates(path, *scene);
  scene = importer.ApplyPostProcessing(aiProcess_Triangulate);
  if (scene == nullptr) RefuseUnreadable(path, importer.GetErrorString());
  CheckFaceCount(path, CountFaces(*scene, *scene->mRootNode));
  TextureLoader loader(*scene, path, imported.used);
  std::vector<Submesh> submeshes;
  CollectSubmeshes(*scene, *scene->mRootNode, Eigen::Affine3d(Eigen::Scaling(scale)), loader,
                   submeshes);
  std::erase_if(submeshes, [](const Submesh& submesh) { return submesh.mesh.triangles.empty(); });
  CheckInput(!submeshes.empty(),
             "mesh '" + path.string() + "' has no faces; export it as triangles");
  TriangleMesh& mesh = imported.mesh;
  mesh = Joined(std::move(submeshes), loader);
  const auto is_finite = [](const Eigen::Vector3d& vertex) { return vertex.allFinite(); };
  CheckInput(std::ranges::all_of(mesh.vertices, is_finite),
             "mesh '" + path.string() + "' has vertices that are not numbers; export it again");
  const double largest = kMaxCoordinate * scale;
  const auto is_near = [largest](const Eigen::Vector3d& vertex) {
    return vertex.cwiseAbs().maxCoeff() <= largest;
  };
  CheckInput(std::ranges::all_of(mesh.vertices, is_near),
             fmt::format("mesh '{}' has a coordinate over {:g}; export it again", path.string(),
                         kMaxCoordinate));
  const double smallest = kMinCoordinate * std::min(1.0, scale);
  const auto has_remains = [smallest](const Eigen::Vector3d& vertex) {
    return (vertex.array() != 0 && vertex.array().abs() < smallest).any();
  };
  CheckInput(
      std::ranges::none_of(mesh.vertices, has_remains),
      fmt::format("mesh '{}' has a coordinate that is nearer to 0 than {:g}, so its bytes are "
                  "damaged; export it again",
                  path.string(), kMinCoordinate));
  const size_t faces = mesh.triangles.size();
  DropDegenerate(mesh);
  imported.report.degenerate_faces = static_cast<int>(faces - mesh.triangles.size());
  imported.report.bad_normals = !NormalsAreUnit(mesh);
  CheckInput(SurfaceArea(mesh) != 0, "mesh '" + path.string() + "' has only faces without area");
  DropFlatNormals(mesh);
  mesh = WithEqualVerticesJoined(mesh);
  imported.used.erase(path);
  return imported;
}

}  // namespace pickbed::scenes
