#include "scenes/geometry/triangle_mesh.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "scenes/base/error.h"

namespace pickbed::scenes {
namespace {

// Returns twice the area of a triangle times its normal.
Eigen::Vector3d AreaVector(const TriangleMesh& mesh, const Eigen::Vector3i& t) {
  const Eigen::Vector3d& a = mesh.vertices[t[0]];
  return (mesh.vertices[t[1]] - a).cross(mesh.vertices[t[2]] - a);
}

Eigen::Vector3d UnitOrZero(const Eigen::Vector3d& v) {
  const double length = v.norm();
  return length > 0 ? Eigen::Vector3d(v / length) : Eigen::Vector3d(Eigen::Vector3d::Zero());
}

// Finds the farthest pair of points by branch and bound over pairs of nodes of a k-d tree. A pair
// of boxes is skipped if no two of their corners are farther apart than the best pair so far.
class FarthestPair {
 public:
  explicit FarthestPair(const std::vector<Eigen::Vector3d>& points) : points_(points) {
    if (points_.empty()) return;
    Build(0, points_.size());
    best_ = SweepFromFirst();
    Search(0, 0);
  }

  double distance() const { return std::sqrt(best_); }

 private:
  static constexpr size_t kLeafSize = 16;

  struct Node {
    size_t begin, end;
    int left = -1, right = -1;
    Eigen::Vector3d min, max;
  };

  int Build(size_t begin, size_t end) {
    Node node{begin, end, -1, -1, points_[begin], points_[begin]};
    for (size_t i = begin; i < end; ++i) {
      node.min = node.min.cwiseMin(points_[i]);
      node.max = node.max.cwiseMax(points_[i]);
    }
    const int index = static_cast<int>(nodes_.size());
    nodes_.push_back(node);
    if (end - begin <= kLeafSize) return index;
    int axis = 0;
    (node.max - node.min).maxCoeff(&axis);
    const size_t split = (begin + end) / 2;
    std::nth_element(
        points_.begin() + begin, points_.begin() + split, points_.begin() + end,
        [axis](const Eigen::Vector3d& a, const Eigen::Vector3d& b) { return a[axis] < b[axis]; });
    const int left = Build(begin, split);
    const int right = Build(split, end);
    nodes_[index].left = left;
    nodes_[index].right = right;
    return index;
  }

  // Gives a good lower bound: repeatedly takes the point that is farthest from the previous one.
  double SweepFromFirst() const {
    double best = 0;
    Eigen::Vector3d from = points_.front();
    for (int sweep = 0; sweep < 4; ++sweep) {
      const auto farthest = std::max_element(
          points_.begin(), points_.end(), [&](const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
            return (a - from).squaredNorm() < (b - from).squaredNorm();
          });
      best = std::max(best, (*farthest - from).squaredNorm());
      from = *farthest;
    }
    return best;
  }

  // Returns the largest possible squared distance between a point of one box and one of the other.
  static double Bound(const Node& a, const Node& b) {
    return (a.max - b.min).cwiseMax(b.max - a.min).squaredNorm();
  }

  void Search(int ia, int ib) {
    const Node& a = nodes_[ia];
    const Node& b = nodes_[ib];
    if (Bound(a, b) <= best_) return;
    if (a.left < 0 && b.left < 0) {
      for (size_t i = a.begin; i < a.end; ++i) {
        for (size_t j = b.begin; j < b.end; ++j) {
          best_ = std::max(best_, (points_[i] - points_[j]).squaredNorm());
        }
      }
    } else if (ia == ib) {
      Search(a.left, a.right);
      Search(a.left, a.left);
      Search(a.right, a.right);
    } else if (b.left < 0 ||
               (a.left >= 0 && (a.max - a.min).squaredNorm() > (b.max - b.min).squaredNorm())) {
      SearchFartherFirst(ib, a.left, a.right);
    } else {
      SearchFartherFirst(ia, b.left, b.right);
    }
  }

  void SearchFartherFirst(int fixed, int left, int right) {
    if (Bound(nodes_[fixed], nodes_[left]) < Bound(nodes_[fixed], nodes_[right])) {
      std::swap(left, right);
    }
    Search(fixed, left);
    Search(fixed, right);
  }

  std::vector<Eigen::Vector3d> points_;
  std::vector<Node> nodes_;
  double best_ = 0;  // m^2
};

void ExpandBaseColor(TriangleMesh& mesh) {
  if (mesh.colors.empty()) mesh.colors.assign(mesh.vertices.size(), mesh.base_color);
}

template <typename T>
void AppendOrClear(const std::vector<T>& other, size_t size_before, std::vector<T>& values) {
  if (values.size() == size_before && !other.empty()) {
    values.insert(values.end(), other.begin(), other.end());
  } else {
    values.clear();
  }
}

}  // namespace

Eigen::Matrix<double, 3, 8> Bounds::Corners() const {
  Eigen::Matrix<double, 3, 8> corners;
  for (int i = 0; i < 8; ++i) {
    corners.col(i) = Eigen::Vector3d(i & 1 ? max.x() : min.x(), i & 2 ? max.y() : min.y(),
                                     i & 4 ? max.z() : min.z());
  }
  return corners;
}

Bounds MeshBounds(const TriangleMesh& mesh) {
  if (mesh.vertices.empty()) return {};
  Bounds bounds{mesh.vertices.front(), mesh.vertices.front()};
  for (const Eigen::Vector3d& v : mesh.vertices) {
    bounds.min = bounds.min.cwiseMin(v);
    bounds.max = bounds.max.cwiseMax(v);
  }
  return bounds;
}

double Diameter(const TriangleMesh& mesh) { return FarthestPair(mesh.vertices).distance(); }

double SurfaceArea(const TriangleMesh& mesh) {
  double twice_area = 0;
  for (const Eigen::Vector3i& t : mesh.triangles) twice_area += AreaVector(mesh, t).norm();
  return 0.5 * twice_area;
}

std::vector<Eigen::Vector3d> FaceNormals(const TriangleMesh& mesh) {
  std::vector<Eigen::Vector3d> normals;
  normals.reserve(mesh.triangles.size());
  for (const Eigen::Vector3i& t : mesh.triangles)
    normals.push_back(UnitOrZero(AreaVector(mesh, t)));
  return normals;
}

TriangleMesh Transformed(const TriangleMesh& mesh_B, const Pose& X_AB) {
  TriangleMesh mesh_A = mesh_B;
  for (Eigen::Vector3d& v : mesh_A.vertices) v = X_AB * v;
  for (Eigen::Vector3d& n : mesh_A.normals) n = X_AB.linear() * n;
  return mesh_A;
}

TriangleMesh Scaled(const TriangleMesh& mesh, double factor) {
  if (!(factor > 0)) throw std::invalid_argument("Scaled needs a positive factor");
  TriangleMesh scaled = mesh;
  for (Eigen::Vector3d& v : scaled.vertices) v *= factor;
  return scaled;
}

void Append(const TriangleMesh& other, TriangleMesh& mesh) {
  if (other.vertices.empty()) return;
  if (mesh.vertices.empty()) {
    mesh = other;
    return;
  }
  const size_t before = mesh.vertices.size();
  if (!mesh.colors.empty() || !other.colors.empty() || mesh.base_color != other.base_color) {
    ExpandBaseColor(mesh);
    const std::vector<Rgb8> plain(other.vertices.size(), other.base_color);
    const std::vector<Rgb8>& more = other.colors.empty() ? plain : other.colors;
    mesh.colors.insert(mesh.colors.end(), more.begin(), more.end());
  }
  AppendOrClear(other.normals, before, mesh.normals);
  const bool one_texture = mesh.texture == other.texture;
  AppendOrClear(one_texture ? other.uvs : std::vector<Eigen::Vector2d>(), before, mesh.uvs);
  if (mesh.uvs.empty()) mesh.texture = {};
  mesh.vertices.insert(mesh.vertices.end(), other.vertices.begin(), other.vertices.end());
  const Eigen::Vector3i shift = Eigen::Vector3i::Constant(static_cast<int>(before));
  mesh.triangles.reserve(mesh.triangles.size() + other.triangles.size());
  for (const Eigen::Vector3i& t : other.triangles) mesh.triangles.push_back(t + shift);
}

SurfaceSamples SampleSurface(const TriangleMesh& mesh, int count, Rng& rng) {
  std::vector<double> area_until(mesh.triangles.size());
  double total = 0;
  for (size_t i = 0; i < mesh.triangles.size(); ++i) {
    area_until[i] = total += AreaVector(mesh, mesh.triangles[i]).norm();
  }
  CheckInput(total > 0, "a mesh without area has no surface to sample");
  const int last = static_cast<int>(area_until.size()) - 1;  // rounding may go past the last index
  SurfaceSamples samples;
  samples.points.reserve(count);
  samples.normals.reserve(count);
  samples.triangles.reserve(count);
  for (int i = 0; i < count; ++i) {
    const auto place =
        std::upper_bound(area_until.begin(), area_until.end(), rng.Uniform() * total);
    const int index = std::min(static_cast<int>(place - area_until.begin()), last);
    const Eigen::Vector3i& t = mesh.triangles[index];
    const double root = std::sqrt(rng.Uniform());  // uniform over the triangle (Turk 1990)
    const double along = rng.Uniform();
    samples.points.push_back((1 - root) * mesh.vertices[t[0]] +
                             root * (1 - along) * mesh.vertices[t[1]] +
                             root * along * mesh.vertices[t[2]]);
    samples.normals.push_back(UnitOrZero(AreaVector(mesh, t)));
    samples.triangles.push_back(index);
  }
  return samples;
}

uint64_t MeshHash(const TriangleMesh& mesh) {
  const uint64_t counts[2] = {mesh.vertices.size(), mesh.triangles.size()};
  uint64_t hash = HashBytes(counts, sizeof(counts));
  hash = HashBytes(mesh.vertices.data(), mesh.vertices.size() * sizeof(Eigen::Vector3d), hash);
  return HashBytes(mesh.triangles.data(), mesh.triangles.size() * sizeof(Eigen::Vector3i), hash);
}

}  // namespace pickbed::scenes
