#include "scenes/objects/object_writer.h"

#include <fmt/format.h>

#include <cmath>

#include "scenes/base/error.h"
#include "scenes/base/files.h"
#include "scenes/base/math.h"
#include "scenes/mesh_io/mesh_io.h"
#include "scenes/objects/object_catalog.h"

namespace pickbed::scenes {
namespace {

using Eigen::Vector3d;

std::string Number(double value) { return fmt::format("{:.9g}", value + 0.0); }  // no "-0"

// Rounds to 1e-9, because rounding noise of sines and cosines would print as 1e-17.
std::string List(const Vector3d& v) {
  const auto clean = [](double x) { return Number(std::round(x * 1e9) / 1e9); };
  return fmt::format("[{}, {}, {}]", clean(v.x()), clean(v.y()), clean(v.z()));
}

// Does not round, because inertia may be as small as the noise that List() removes.
std::string ExactList(const Vector3d& v) {
  return fmt::format("[{}, {}, {}]", Number(v.x()), Number(v.y()), Number(v.z()));
}

std::string ConvexObj(const std::vector<ConvexPiece>& pieces) {
  std::string text;
  for (size_t i = 0; i < pieces.size(); ++i) {
    text += fmt::format("o piece_{}\n", i);
    for (const Vector3d& p : pieces[i].vertices_O) {
      text += fmt::format("v {} {} {}\n", Number(p.x()), Number(p.y()), Number(p.z()));
    }
  }
  return text;
}

std::string MassYaml(const ObjectRecord& record) {
  if (record.density_kgpm3 > 0) {
    return fmt::format("density_kgpm3: {}\n", Number(record.density_kgpm3));
  }
  const Eigen::Matrix3d& I = record.mass.inertia_com_O;
  return fmt::format(
      "mass_kg: {}\ncom_m: {}\ninertia_diagonal_kgm2: {}\ninertia_products_kgm2: {}\n",
      Number(record.mass.mass_kg), ExactList(record.mass.com_O), ExactList(I.diagonal()),
      ExactList({I(0, 1), I(0, 2), I(1, 2)}));
}

std::string SymmetriesYaml(const SymmetrySet& symmetries) {
  if (symmetries.trivial()) return "";
  std::string text = "symmetries:\n";
  if (!symmetries.discrete_O.empty()) text += "  discrete:\n";
  for (const Pose& X : symmetries.discrete_O) {
    const Eigen::AngleAxisd turn(X.linear());
    text +=
        fmt::format("    - {{axis: {}, angle_deg: {}, offset_m: {}}}\n", List(turn.axis()),
                    Number(std::round(Degrees(turn.angle()) * 1e7) / 1e7), List(PointOnAxis(X)));
  }
  if (!symmetries.continuous_O.empty()) text += "  continuous:\n";
  for (const ContinuousSymmetry& s : symmetries.continuous_O) {
    text += fmt::format("    - {{axis: {}, offset_m: {}}}\n", List(s.axis_O), List(s.offset_O));
  }
  return text;
}

std::string RestingYaml(const std::vector<RestingDirection>& resting) {
  if (resting.empty()) return "";
  std::string text = "resting_poses:\n";
  for (const RestingDirection& direction : resting) {
    text += fmt::format("  - {{up: {}, probability: {}}}\n", List(direction.up_O),
                        Number(std::round(direction.probability * 1e6) / 1e6));
  }
  return text;
}

std::string ObjectYaml(const ObjectRecord& record) {
  return fmt::format("# {}\nmesh: mesh.obj\nunit: m\n", record.help) + MassYaml(record) +
         fmt::format("friction: {}\nconvex: convex.obj\n", Number(record.friction)) +
         SymmetriesYaml(record.symmetries_O) + RestingYaml(record.resting_O);
}

}  // namespace

void WriteObject(const ObjectRecord& record, const std::filesystem::path& folder) {
  MakeFolder(folder);
  SaveObj(folder / "mesh.obj", record.mesh_O);
  WriteFileAtomically(folder / "convex.obj", ConvexObj(record.convex_pieces_O));
  WriteFileAtomically(folder / kObjectFile, ObjectYaml(record));
}

}  // namespace pickbed::scenes
