#include "eval/completion/test_shapes.h"

#include <algorithm>
#include <cmath>

#include "perception/completion/training_sample.h"
#include "scenes/base/error.h"
#include "scenes/base/files.h"
#include "scenes/camera/mesh_raster.h"
#include "scenes/geometry/mesh_query.h"
#include "scenes/mesh_io/mesh_io.h"
#include "scenes/objects/object_catalog.h"
#include "scenes/shape_families/shape_family.h"

namespace pickbed::eval {
namespace {

// Test shapes have seeds that no training draws by chance: a training draws 64 random bits.
constexpr uint64_t kFirstSeed = 1000;
// Meshes larger or smaller than this are bins or are in another unit.
constexpr double kMinDiameter_m = 0.015, kMaxDiameter_m = 0.45;

std::string Lower(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return text;
}

// Files of textured or plain meshes; convex decompositions and second versions are left out.
std::vector<std::filesystem::path> MeshFiles(const std::filesystem::path& folder) {
  std::vector<std::filesystem::path> files;
  if (!std::filesystem::is_directory(folder)) return files;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    const std::string extension = Lower(entry.path().extension().string());
    const std::string stem = Lower(entry.path().stem().string());
    const bool is_mesh = extension == ".obj" || extension == ".stl" || extension == ".dae" ||
                         extension == ".ply" || extension == ".gltf";
    if (is_mesh && !stem.ends_with("_vhacd") && !stem.ends_with("_b")) {
      files.push_back(entry.path());
    }
  }
  std::sort(files.begin(), files.end());
  return files;
}

// Scales a mesh in millimetres to metres.
TriangleMesh InMeters(const TriangleMesh& mesh) {
  return Diameter(mesh) > 2 ? Scaled(mesh, 0.001) : mesh;
}

}  // namespace

struct MeshSolid::Impl {
  explicit Impl(const TriangleMesh& mesh) : raster(mesh), vertices(mesh.vertices) {}
  RasterMesh raster;
  std::vector<Eigen::Vector3d> vertices;
};

MeshSolid::MeshSolid(const TriangleMesh& mesh_O, int grid_cells)
    : impl_(std::make_unique<Impl>(mesh_O)) {
  const Bounds bounds = MeshBounds(mesh_O);
  box_O_ = {bounds.min.cast<float>(), bounds.max.cast<float>()};
  cell_m_ = box_O_.sizes().maxCoeff() / static_cast<float>(grid_cells);
  for (int axis = 0; axis < 3; ++axis) {
    cells_[axis] = std::max(1, static_cast<int>(std::ceil(box_O_.sizes()[axis] / cell_m_)));
  }
  const size_t total = static_cast<size_t>(cells_[0]) * cells_[1] * cells_[2];
  std::vector<uint8_t> votes(total, 0);
  const MeshQuery query(mesh_O);
  const auto center = [&](int axis, int cell) {
    return static_cast<double>(box_O_.min()[axis]) + (cell + 0.5) * static_cast<double>(cell_m_);
  };
  for (int axis = 0; axis < 3; ++axis) {
    const int u = (axis + 1) % 3, v = (axis + 2) % 3;
    for (int i = 0; i < cells_[u]; ++i) {
      for (int k = 0; k < cells_[v]; ++k) {
        // A line through an edge or a corner may count it twice; a small shift avoids them.
        Eigen::Vector3d origin;
        origin[axis] = center(axis, 0) - static_cast<double>(cell_m_);
        origin[u] = center(u, i) + 1.1e-7;
        origin[v] = center(v, k) + 0.7e-7;
        const auto hits = query.AllHits(origin, Eigen::Vector3d::Unit(axis));
        size_t passed = 0;
        for (int cell = 0; cell < cells_[axis]; ++cell) {
          const double along = (cell + 1) * static_cast<double>(cell_m_);
          while (passed < hits.size() && hits[passed].distance < along) ++passed;
          int index[3];
          index[axis] = cell;
          index[u] = i;
          index[v] = k;
          const size_t place =
              (static_cast<size_t>(index[2]) * cells_[1] + index[1]) * cells_[0] + index[0];
          votes[place] += passed % 2;
        }
      }
    }
  }
  grid_.resize(total);
  for (size_t i = 0; i < total; ++i) grid_[i] = votes[i] >= 2;
}

MeshSolid::~MeshSolid() = default;

Image<float> MeshSolid::Depth(const CameraIntrinsics& intrinsics, const Pose& X_CO) const {
  Image<float> depth_m(intrinsics.width(), intrinsics.height(), 0);
  FaceRaster raster;
  raster.Begin(intrinsics, {0, 0, intrinsics.width(), intrinsics.height()});
  raster.Draw(impl_->raster, X_CO, /*cull_back=*/false);
  for (int y = 0; y < depth_m.height(); ++y) {
    const float* inverse = raster.InverseDepths(y);
    for (int x = 0; x < depth_m.width(); ++x) {
      if (inverse[x] > 0) depth_m(x, y) = 1 / inverse[x];
    }
  }
  raster.Clean();
  return depth_m;
}

void MeshSolid::Inside(std::span<const Eigen::Vector3f> points_O, std::span<uint8_t> inside) const {
  for (size_t i = 0; i < points_O.size(); ++i) {
    const Eigen::Vector3f at = (points_O[i] - box_O_.min()) / cell_m_;
    int index[3];
    bool within = true;
    for (int axis = 0; axis < 3; ++axis) {
      index[axis] = static_cast<int>(std::floor(at[axis]));
      within = within && index[axis] >= 0 && index[axis] < cells_[axis];
    }
    inside[i] =
        within &&
        grid_[(static_cast<size_t>(index[2]) * cells_[1] + index[1]) * cells_[0] + index[0]];
  }
}

float MeshSolid::LowestAlong(const Eigen::Vector3f& normal_O) const {
  const Eigen::Vector3d normal = normal_O.cast<double>();
  double lowest = 1e9;
  for (const Eigen::Vector3d& vertex : impl_->vertices) {
    lowest = std::min(lowest, normal.dot(vertex));
  }
  return static_cast<float>(lowest);
}

std::vector<std::string> TestSetNames() {
  return {"seen", "unseen_sizes", "outside", "unseen_families", "catalog", "ycb", "industrial"};
}

std::vector<TestShape> TestShapesOf(const std::string& set, int count,
                                    const std::filesystem::path& data_folder) {
  std::vector<TestShape> shapes;
  if (set == "catalog") {
    const ObjectCatalog catalog({AssetsDir() / "objects"});
    for (const std::string& name : catalog.Names()) {
      shapes.push_back({set, name, std::make_shared<MeshSolid>(catalog.Load(name)->mesh_O)});
    }
  } else if (set == "ycb" || set == "industrial") {
    for (const auto& file : MeshFiles(data_folder / set)) {
      const TriangleMesh mesh = InMeters(LoadMesh(file));
      const double diameter_m = Diameter(mesh);
      if (diameter_m < kMinDiameter_m || diameter_m > kMaxDiameter_m) continue;
      shapes.push_back({set, file.stem().string(), std::make_shared<MeshSolid>(mesh)});
    }
  } else {
    const std::vector<std::string> names = TestSetNames();
    CheckInput(std::find(names.begin(), names.end(), set) != names.end(),
               UnknownNameMessage("test set", set, names));
    const bool unseen = set == "unseen_families";
    const ShapeSplit split = unseen || set == "seen" ? ShapeSplit::kSeen : ShapeSplitFromName(set);
    for (const ShapeFamilyRow& family : ShapeFamilyTable()) {
      if (family.held_out != unseen) continue;
      for (int i = 0; i < count; ++i) {
        std::shared_ptr<const ViewedSolid> solid =
            SolidOf(SampleShape(family, split, kFirstSeed + i).solid);
        shapes.push_back({set, family.name + std::string("_") + std::to_string(i), solid});
      }
    }
  }
  return shapes;
}

}  // namespace pickbed::eval
