#pragma once

// Building blocks of the part families: closed shells from flat faces and bands, and convex pieces
// for physics. Lengths here are MILLIMETRES, as on a drawing; FinishPart turns them into metres.

#include <Eigen/Core>
#include <array>
#include <vector>

#include "scenes/part_families.h"
#include "scenes/polygon_triangulation.h"

namespace pickbed {

using Loop = std::vector<Eigen::Vector3d>;  // closed polygon in space, last point not repeated

// `count` points of a circle about z, counter-clockwise seen from +z, the first at `phase_rad`.
Loop Circle(double radius, int count, double z = 0, double phase_rad = 0);
// Points on the arc from `begin_rad` to `end_rad`, both ends included.
Outline Arc(const Eigen::Vector2d& center, double radius, double begin_rad, double end_rad,
            int segments);
Outline CircleOutline(const Eigen::Vector2d& center, double radius, int count,
                      double phase_rad = 0);
Loop AtHeight(const Outline& outline, double z);
Loop Moved(const Loop& loop, const Pose& X_AB);
Loop Reversed(const Loop& loop);
// Frame with its x, y, z axes along a permutation of the world's: z to `z_axis`, x to `x_axis`.
Pose Frame(const Eigen::Vector3d& x_axis, const Eigen::Vector3d& z_axis,
           const Eigen::Vector3d& origin = Eigen::Vector3d::Zero());

// Gathers triangles. Points that agree to 1 nm are one; a shell closes when neighbours use the same
// points along their common outline.
class ShellBuilder {
 public:
  // A flat face, counter-clockwise seen from outside; holes in either winding.
  void Face(const Loop& outer, const std::vector<Loop>& holes = {});
  // The closed band between two loops of equal length. For loops that run counter-clockwise about
  // an axis, the outside is away from it when `upper` is further along the axis.
  void Band(const Loop& lower, const Loop& upper);
  // An open net of quads, rows[r][c]; outside is where (next column) x (next row) points.
  void Net(const std::vector<Loop>& rows);
  // One quad, counter-clockwise seen from outside, cut along its shorter diagonal.
  void Quad(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c,
            const Eigen::Vector3d& d);
  // A straight prism along z between z0 < z1, with its caps.
  void Prism(const Outline& outer, const std::vector<Outline>& holes, double z0, double z1);
  // The solid of revolution about z of a profile (radius, z) that starts and ends on the axis and
  // runs upwards on its outside. `count` facets.
  void Revolve(const Outline& profile, int count);
  // The same for a profile that is a closed loop off the axis, counter-clockwise in (radius, z).
  void RevolveRing(const Outline& profile, int count);

  void Transform(const Pose& X_AB);

  // Mesh with vertex normals that are smooth over edges flatter than `crease_deg`.
  TriangleMesh Build(double crease_deg) const;

 private:
  void Triangle(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c);

  std::vector<std::array<Eigen::Vector3d, 3>> triangles_;
};

// Convex pieces, in millimetres.
ConvexPiece BoxPiece(const Eigen::Vector3d& min, const Eigen::Vector3d& max);
ConvexPiece PrismPiece(const Outline& convex, double z0, double z1);
// Those of `points` that are corners of their convex hull.
ConvexPiece HullPiece(const Loop& points);
// Hull of two loops, e.g. a frustum.
ConvexPiece LoftPiece(const Loop& lower, const Loop& upper);
// Radius of the corners of a regular polygon whose corners stand as far outside of a circle as its
// sides cut inside.
double BalancedRadius(double radius, int corners);
// Hull of circles about z. See BalancedRadius.
ConvexPiece DiscPiece(double lower_radius, double upper_radius, double z0, double z1, int count);

// A wall between two radii cut into sectors. The inner side of each is a chord that is as far
// outside of the bore at its ends as it is inside at its middle.
struct RingSpec {
  double inner_radius;
  double outer_radius;
  double z0;
  double z1;
  int sectors;
  double begin_rad = 0;
  double sweep_rad = 2 * M_PI;
  int outer_segments = 3;  // a sector
};
std::vector<ConvexPiece> RingPieces(const RingSpec& spec);

void MovePieces(const Pose& X_AB, std::vector<ConvexPiece>& pieces);
void AppendPieces(const std::vector<ConvexPiece>& more, std::vector<ConvexPiece>& pieces);

// Rotation about `axis` through the origin.
Pose Turn(const Eigen::Vector3d& axis, double angle_deg);
// Turns by 360/order about z, without the identity.
std::vector<Pose> CyclicZ(int order);
// CyclicZ and `order` half turns about axes in the xy plane, the first along x.
std::vector<Pose> DihedralZ(int order);

struct PartMaterial {
  double density_kgpm3;
  double friction;
  Rgb8 color;
};

// Puts the origin into the middle of the bounding box and turns millimetres into metres.
// `symmetries` are about the drawing's origin, in millimetres.
MadePart FinishPart(const TriangleMesh& mesh_mm, const std::vector<ConvexPiece>& pieces_mm,
                    const SymmetrySet& symmetries_mm, const PartMaterial& material);

}  // namespace pickbed
