#include <fmt/format.h>

#include <cmath>
#include <filesystem>
#include <string>

#include "scenes/files.h"
#include "scenes/mesh_io.h"
#include "scenes/part_families.h"

namespace pickbed {
namespace {

using Eigen::Vector3d;

std::string Number(double value) { return fmt::format("{:.9g}", value + 0.0); }  // no "-0"

// Rounding noise of sines and cosines would print as 1e-17.
std::string List(const Vector3d& v) {
  const auto clean = [](double x) { return Number(std::round(x * 1e9) / 1e9); };
  return fmt::format("[{}, {}, {}]", clean(v.x()), clean(v.y()), clean(v.z()));
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

std::string ObjectYaml(const MadePart& part, const std::string& help) {
  std::string text = fmt::format("# {}\nmesh: mesh.obj\nunit: m\n", help);
  text += fmt::format("density_kgpm3: {}\nfriction: {}\nconvex: convex.obj\n",
                      Number(part.density_kgpm3), Number(part.friction));
  const SymmetrySet& symmetries = part.symmetries_O;
  if (symmetries.trivial()) return text;
  text += "symmetries:\n";
  if (!symmetries.discrete_O.empty()) text += "  discrete:\n";
  for (const Pose& X : symmetries.discrete_O) {
    const Eigen::AngleAxisd turn(X.linear());
    text += fmt::format("    - {{axis: {}, angle_deg: {}, offset_m: {}}}\n", List(turn.axis()),
                        Number(std::round(turn.angle() * 180 / M_PI * 1e7) / 1e7),
                        List(PointOnAxis(X)));
  }
  if (!symmetries.continuous_O.empty()) text += "  continuous:\n";
  for (const ContinuousSymmetry& s : symmetries.continuous_O) {
    text += fmt::format("    - {{axis: {}, offset_m: {}}}\n", List(s.axis_O), List(s.offset_O));
  }
  return text;
}

}  // namespace

void WritePart(const PartRow& row, const std::filesystem::path& folder) {
  const MadePart part = row.make();
  std::filesystem::create_directories(folder);
  SaveObj(folder / "mesh.obj", part.mesh_O);
  WriteFileAtomically(folder / "convex.obj", ConvexObj(part.convex_parts_O));
  WriteFileAtomically(folder / "object.yaml", ObjectYaml(part, row.help));
}

}  // namespace pickbed
