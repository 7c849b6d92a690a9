#include "scenes/objects/object_catalog.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <system_error>

#include "scenes/base/error.h"
#include "scenes/base/math.h"
#include "scenes/base/settings.h"
#include "scenes/geometry/decompositions.h"
#include "scenes/mesh_io/mesh_checks.h"
#include "scenes/mesh_io/mesh_io.h"
#include "scenes/objects/convex_file.h"
#include "scenes/objects/object_settings.h"
#include "scenes/objects/sampled_object.h"
#include "scenes/shape_families/sampled_names.h"

namespace pickbed::scenes {
namespace {

namespace fs = std::filesystem;

// ---- object.yaml ----

struct AxisSettings {
  Eigen::Vector3d axis = Eigen::Vector3d::Zero();
  Eigen::Vector3d offset_m = Eigen::Vector3d::Zero();
  double angle_deg = 0;  // only for a discrete symmetry

  void Visit(SettingsVisitor& v, bool discrete) {
    v.Vector3("axis", axis, {-1e3, 1e3},
              "direction of the axis in the object frame, of any length");
    v.Vector3("offset_m", offset_m, {-10, 10}, "point on the axis in the object frame, m");
    if (discrete) v.Real("angle_deg", angle_deg, {-360, 360}, "angle of the rotation, degrees");
  }
};

struct RestingSettings {
  Eigen::Vector3d up = Eigen::Vector3d::UnitZ();
  double probability = 0;

  void Visit(SettingsVisitor& v) {
    v.Vector3("up", up, {-1, 1}, "up direction of the world in the object frame, of any length");
    v.Real("probability", probability, {0, 1},
           "probability that a dropped object comes to rest in this pose");
  }
};

struct ObjectSettings {
  std::string mesh = "mesh.obj";
  std::string unit = "m";
  double mass_kg = 0;
  double density_kgpm3 = 0;
  Eigen::Vector3d com_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d inertia_diagonal_kgm2 = Eigen::Vector3d::Zero();
  Eigen::Vector3d inertia_products_kgm2 = Eigen::Vector3d::Zero();
  double friction = 0.5;
  std::string convex;
  std::vector<AxisSettings> discrete;
  std::vector<AxisSettings> continuous;
  std::vector<RestingSettings> resting;

  void Visit(SettingsVisitor& v) {
    v.Text("mesh", mesh, {}, "mesh file in the same folder");
    v.Text("unit", unit, {"m", "cm", "mm", "in"},
           "unit of the coordinates in the mesh file and the convex file");
    v.Real("mass_kg", mass_kg, {0, kMaxObjectMass_kg},
           "mass of the object, kg; give either this or density_kgpm3");
    v.Real("density_kgpm3", density_kgpm3, {0, 25000},
           "density of the object, kg/m3; give either this or mass_kg");
    v.Vector3("com_m", com_m, {-10, 10},
              "center of mass in the object frame, m; only with inertia_diagonal_kgm2");
    v.Vector3("inertia_diagonal_kgm2", inertia_diagonal_kgm2, {0, 1e3},
              "moments of inertia xx, yy, zz about the center of mass, kg m2");
    v.Vector3("inertia_products_kgm2", inertia_products_kgm2, {-1e3, 1e3},
              "products of inertia xy, xz, yz about the center of mass, kg m2");
    v.Real("friction", friction, {0.01, 2}, "coefficient of friction against a gripper pad");
    v.Text("convex", convex, {}, "OBJ file with one 'o' group for each convex piece");
    v.Group(
        "symmetries", [this](SettingsVisitor& group) { VisitSymmetries(group); },
        "rotations that map the object onto itself");
    v.List(
        "resting_poses", resting.size(), [this](size_t n) { resting.resize(n); },
        [this](size_t i, SettingsVisitor& item) { resting[i].Visit(item); },
        "stable poses on a plane");
  }

 private:
  void VisitSymmetries(SettingsVisitor& v) {
    v.List(
        "discrete", discrete.size(), [this](size_t n) { discrete.resize(n); },
        [this](size_t i, SettingsVisitor& item) { discrete[i].Visit(item, true); },
        "discrete symmetry rotations, without the identity");
    v.List(
        "continuous", continuous.size(), [this](size_t n) { continuous.resize(n); },
        [this](size_t i, SettingsVisitor& item) { continuous[i].Visit(item, false); },
        "axes of continuous rotational symmetry");
  }
};

SymmetrySet ToSymmetrySet(const ObjectSettings& settings) {
  SymmetrySet symmetries;
  for (const AxisSettings& a : settings.discrete) {
    const double angle_rad = Radians(a.angle_deg);
    symmetries.discrete_O.push_back(TurnAbout({a.axis.normalized(), a.offset_m}, angle_rad));
  }
  for (const AxisSettings& a : settings.continuous) {
    symmetries.continuous_O.push_back({a.axis.normalized(), a.offset_m});
  }
  return symmetries;
}

void ApplyInertia(const ObjectSettings& settings, MassProperties& mass) {
  mass.com_O = settings.com_m;
  mass.inertia_com_O = settings.inertia_diagonal_kgm2.asDiagonal();
  const Eigen::Vector3d& products = settings.inertia_products_kgm2;
  mass.inertia_com_O(0, 1) = mass.inertia_com_O(1, 0) = products.x();
  mass.inertia_com_O(0, 2) = mass.inertia_com_O(2, 0) = products.y();
  mass.inertia_com_O(1, 2) = mass.inertia_com_O(2, 1) = products.z();
}

ObjectSettings ReadObjectFile(const fs::path& file) {
  ObjectSettings settings;
  ReadSettingsFile(file, [&](SettingsVisitor& v) { settings.Visit(v); });
  const std::string name = file.string();
  constexpr double kMinMass_kg = 1e-6, kMinDensity_kgpm3 = 0.1;
  CheckInput(settings.mass_kg == 0 || settings.mass_kg >= kMinMass_kg,
             fmt::format("{}: mass_kg = {:g} is under {:g}", name, settings.mass_kg, kMinMass_kg));
  CheckInput(settings.density_kgpm3 == 0 || settings.density_kgpm3 >= kMinDensity_kgpm3,
             fmt::format("{}: density_kgpm3 = {:g} is under {:g}", name, settings.density_kgpm3,
                         kMinDensity_kgpm3));
  CheckInput((settings.mass_kg > 0) != (settings.density_kgpm3 > 0),
             name + ": give exactly one of mass_kg and density_kgpm3, above 0");
  CheckInput(settings.inertia_diagonal_kgm2.norm() == 0 || settings.mass_kg > 0,
             name + ": inertia_diagonal_kgm2 needs mass_kg, not density_kgpm3; give mass_kg");
  CheckInput(settings.inertia_diagonal_kgm2.norm() > 0 ||
                 (settings.com_m.isZero(0) && settings.inertia_products_kgm2.isZero(0)),
             name +
                 ": com_m and inertia_products_kgm2 need inertia_diagonal_kgm2; give all three, or "
                 "none of them to compute them from the mesh");
  CheckInput(
      settings.inertia_diagonal_kgm2.norm() == 0 || settings.inertia_diagonal_kgm2.minCoeff() > 0,
      name + ": inertia_diagonal_kgm2 must be positive");
  for (const RestingSettings& resting : settings.resting) {
    CheckInput(resting.up.norm() > 0, name + ": resting_poses: up must not be [0, 0, 0]");
  }
  for (const AxisSettings& a : settings.discrete) {
    CheckInput(a.axis.norm() > 0, name + ": symmetries.discrete: axis must not be [0, 0, 0]");
    CheckInput(a.angle_deg != 0, name + ": symmetries.discrete: angle_deg must not be 0");
  }
  for (const AxisSettings& a : settings.continuous) {
    CheckInput(a.axis.norm() > 0, name + ": symmetries.continuous: axis must not be [0, 0, 0]");
  }
  return settings;
}

// ---- Mass of scanned meshes ----

TriangleMesh BoxMesh(const Bounds& bounds) {
  TriangleMesh box;
  for (int corner = 0; corner < 8; ++corner) {
    const auto side = [&](int k) { return (corner >> k & 1) ? bounds.max[k] : bounds.min[k]; };
    box.vertices.emplace_back(side(0), side(1), side(2));
  }
  box.triangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                   {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
  return box;
}

// Returns whether a solid within the bounds can have these properties. Holes and repeated faces can
// make them impossible. The volume limit has a tolerance for rounding, because a box fills its
// bounds.
bool Plausible(const MassProperties& mass, const Bounds& bounds) {
  const Eigen::Vector3d beyond = (bounds.min - mass.com_O).cwiseMax(mass.com_O - bounds.max);
  const Eigen::Matrix3d second = 0.5 * mass.inertia_com_O.trace() * Eigen::Matrix3d::Identity() -
                                 mass.inertia_com_O;  // integral of x x^T: positive definite
  return beyond.maxCoeff() <= 0 && mass.volume_m3 <= (1 + 1e-6) * bounds.size().prod() &&
         EigenOfSymmetric3(second).values.minCoeff() > 0;
}

// The sum over tetrahedra is also a good approximation for an open mesh with small holes. If its
// result is impossible, the mass properties of the bounding box are used.
MassProperties SolidProperties(const TriangleMesh& mesh, double density_kgpm3) {
  const MassProperties mass = UniformDensityProperties(mesh, density_kgpm3);
  const Bounds bounds = MeshBounds(mesh);
  return Plausible(mass, bounds) ? mass : UniformDensityProperties(BoxMesh(bounds), density_kgpm3);
}

// Contacts in the physics are a few tenths of a millimetre thick, so smaller objects are refused.
constexpr double kSmallestDiameter_m = 0.003;

struct Weight {
  double mass_kg = 0;        // > 0, or else
  double density_kgpm3 = 0;  // > 0
};

std::shared_ptr<ObjectModel> MakeModel(const std::string& name, const fs::path& mesh_file,
                                       const std::string& unit, const Weight& weight) {
  auto model = std::make_shared<ObjectModel>();
  model->name = name;
  model->mesh_O = LoadMesh(mesh_file, unit);
  RequireUsableMesh(model->mesh_O, mesh_file.string());
  model->mesh_O = TurnedOutwards(WithAgreeingFaces(std::move(model->mesh_O)));
  model->mass = SolidProperties(model->mesh_O, weight.mass_kg > 0 ? 1.0 : weight.density_kgpm3);
  if (weight.mass_kg > 0) {
    model->mass.inertia_com_O *= weight.mass_kg / model->mass.mass_kg;
    model->mass.mass_kg = weight.mass_kg;
  }
  model->diameter_m = Diameter(model->mesh_O);
  CheckInput(
      model->diameter_m >= kSmallestDiameter_m,
      fmt::format("{}: is {:.3g} mm large when read in '{}'; objects under {:g} mm are too small "
                  "for the physics; check its unit",
                  mesh_file.string(), 1e3 * model->diameter_m, unit, 1e3 * kSmallestDiameter_m));
  model->mesh_hash = MeshHash(model->mesh_O);
  return model;
}

// Hulls are larger than the object, but not by much.
void RequireAtMesh(const ObjectModel& model, const fs::path& convex_file) {
  const Bounds bounds = MeshBounds(model.mesh_O);
  const double margin_m = 0.5 * model.diameter_m;
  for (const ConvexPiece& piece : model.convex_pieces_O) {
    for (const Eigen::Vector3d& p_O : piece.vertices_O) {
      const double outside_m =
          std::max((p_O - bounds.max).maxCoeff(), (bounds.min - p_O).maxCoeff());
      CheckInput(outside_m <= margin_m,
                 fmt::format("{}: a vertex is {:.3g} m outside of the mesh; the file must have the "
                             "frame and the unit of the mesh",
                             convex_file.string(), outside_m));
    }
  }
}

}  // namespace

void VisitObjectSettings(SettingsVisitor& v) { ObjectSettings().Visit(v); }

std::shared_ptr<const ObjectModel> LoadMeshObject(const std::string& name,
                                                  const MeshObjectSpec& spec) {
  CheckInput(std::isfinite(spec.mass_kg) && (spec.mass_kg > 0 || spec.density_kgpm3 > 0),
             "object '" + name + "': mass_kg = " + std::to_string(spec.mass_kg) +
                 " is not positive; give the object's mass in kilograms");
  CheckInput(std::isfinite(spec.friction) && spec.friction > 0,
             "object '" + name + "': friction = " + std::to_string(spec.friction) +
                 " is not positive; 0.5 suits most objects");
  std::shared_ptr<ObjectModel> model =
      MakeModel(name, spec.mesh, spec.unit, {spec.mass_kg, spec.density_kgpm3});
  model->friction = spec.friction;
  model->symmetries_O = spec.symmetries_O;
  return model;
}

ObjectCatalog::ObjectCatalog(std::vector<fs::path> roots) : roots_(std::move(roots)) {}

std::vector<std::string> ObjectCatalog::Names() const {
  std::set<std::string> names;
  for (const fs::path& root : roots_) {
    std::error_code error;  // a missing root has no objects
    for (const fs::directory_entry& entry : fs::directory_iterator(root, error)) {
      if (fs::is_regular_file(entry.path() / kObjectFile, error)) {
        names.insert(entry.path().filename().string());
      }
    }
  }
  return {names.begin(), names.end()};
}

std::shared_ptr<const ObjectModel> ObjectCatalog::Load(const std::string& name) const {
  if (IsSampledName(name)) {
    return std::make_shared<ObjectModel>(SampledObject(name, SampleShapeByName(name)));
  }
  const std::vector<std::string> names = Names();
  CheckInput(std::binary_search(names.begin(), names.end(), name),
             UnknownNameMessage("object", name, names));
  const auto root = std::find_if(roots_.begin(), roots_.end(), [&](const fs::path& candidate) {
    return fs::is_regular_file(candidate / name / kObjectFile);
  });
  const fs::path folder = *root / name;
  const ObjectSettings settings = ReadObjectFile(folder / kObjectFile);
  std::shared_ptr<ObjectModel> model = MakeModel(name, folder / settings.mesh, settings.unit,
                                                 {settings.mass_kg, settings.density_kgpm3});
  if (settings.inertia_diagonal_kgm2.norm() > 0) {
    ApplyInertia(settings, model->mass);
    CheckInput(Plausible(model->mass, MeshBounds(model->mesh_O)),
               fmt::format("{}: no solid within the mesh has this com_m and this inertia; check "
                           "their units, m and kg m^2",
                           (folder / kObjectFile).string()));
  }
  model->friction = settings.friction;
  model->symmetries_O = ToSymmetrySet(settings);
  for (const RestingSettings& resting : settings.resting) {
    model->resting_O.push_back({resting.up.normalized(), resting.probability});
  }
  if (!settings.convex.empty()) {
    model->convex_pieces_O = LoadConvexPieces(folder / settings.convex, settings.unit);
    RequireAtMesh(*model, folder / settings.convex);
  }
  return model;
}

}  // namespace pickbed::scenes
