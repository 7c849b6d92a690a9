#pragma once

// Building blocks for objects made by code: closed shells from flat faces and bands, and convex
// pieces for physics. Lengths here are MILLIMETRES, as on a drawing. FinishObject() converts them
// to metres.

#include <Eigen/Core>
#include <array>
#include <vector>

#include "scenes/geometry/polygon_triangulation.h"
#include "scenes/part_families/part_families.h"

namespace pickbed::scenes {

// Edges sharper than this get separate normals on both sides.
inline constexpr double kCrease_deg = 35;

using Loop = std::vector<Eigen::Vector3d>;  // closed polygon in space, last point not repeated

// Returns `count` points of a circle about z, counter-clockwise as seen from +z. The first one is
// at the angle `phase_rad`.
Loop Circle(double radius, int count, double z = 0, double phase_rad = 0);
// Returns points on the arc from `begin_rad` to `end_rad`, including both ends.
Outline Arc(const Eigen::Vector2d& center, double radius, double begin_rad, double end_rad,
            int segments);
// Returns `count` points of a circle, counter-clockwise. The first one is at the angle `phase_rad`.
Outline CircleOutline(const Eigen::Vector2d& center, double radius, int count,
                      double phase_rad = 0);
// Returns the outline as a loop in the plane at the height `z`.
Loop AtHeight(const Outline& outline, double z);
// Returns the loop, given in frame B, in frame A.
Loop Moved(const Loop& loop, const Pose& X_AB);
// Returns the loop in the opposite order of its points.
Loop Reversed(const Loop& loop);
// Returns the pose of a frame with the given x and z axes, which must be perpendicular unit
// vectors.
Pose Frame(const Eigen::Vector3d& x_axis, const Eigen::Vector3d& z_axis,
           const Eigen::Vector3d& origin = Eigen::Vector3d::Zero());

// Collects triangles of a closed surface. Points that agree to 1 nm are one point. The surface is
// closed if adjacent faces use the same points along their common outline.
class ShellBuilder {
 public:
  // Adds a flat face, counter-clockwise as seen from outside; holes have either winding.
  void Face(const Loop& outer, const std::vector<Loop>& holes = {});
  // Adds the closed band between two loops of equal length. If the loops are counter-clockwise
  // about an axis and `upper` is further along the axis, the outside points away from the axis.
  void Band(const Loop& lower, const Loop& upper);
  // Adds an open net of quads, rows[r][c]. The outside is the direction of
  // (next column) x (next row).
  void Net(const std::vector<Loop>& rows);
  // Adds a quad, counter-clockwise as seen from outside. It is cut along its shorter diagonal.
  void Quad(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c,
            const Eigen::Vector3d& d);
  // Adds a straight prism along z between z0 < z1, with its caps.
  void Prism(const Outline& outer, const std::vector<Outline>& holes, double z0, double z1);
  // Adds the solid of revolution about z of a profile (radius, z) with `count` facets. The profile
  // starts and ends on the axis and goes upwards on its outside.
  void Revolve(const Outline& profile, int count);
  // Same for a profile that is a closed loop off the axis, counter-clockwise in (radius, z).
  void RevolveRing(const Outline& profile, int count);

  void Transform(const Pose& X_AB);

  // Returns the mesh. Vertex normals are smooth over edges with an angle below `crease_deg`.
  TriangleMesh Build(double crease_deg) const;

 private:
  void Triangle(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c);

  std::vector<std::array<Eigen::Vector3d, 3>> triangles_;
};

// Convex pieces, in millimetres.
ConvexPiece BoxPiece(const Eigen::Vector3d& min, const Eigen::Vector3d& max);
// Returns the prism of a convex outline between z0 and z1.
ConvexPiece PrismPiece(const Outline& convex, double z0, double z1);
// Returns the points that are corners of the convex hull.
ConvexPiece HullPiece(const Loop& points);
// Returns the hull of two loops, such as a frustum.
ConvexPiece LoftPiece(const Loop& lower, const Loop& upper);
// Returns the corner radius of a regular polygon that approximates a circle. Its corners are as far
// outside the circle as its sides are inside.
double BalancedRadius(double radius, int corners);
// Returns the hull of two circles about z with `count` corners, see BalancedRadius().
ConvexPiece DiscPiece(double lower_radius, double upper_radius, double z0, double z1, int count);

// A wall between two radii about z, cut into sectors. The inner side of each sector is a chord. Its
// ends are as far outside the inner radius as its center is inside.
struct RingSpec {
  double inner_radius;
  double outer_radius;
  double z0;
  double z1;
  int sectors;
  double begin_rad = 0;
  double sweep_rad = 2 * M_PI;
  int outer_segments = 3;  // per sector
};
// Returns one convex piece for each sector.
std::vector<ConvexPiece> RingPieces(const RingSpec& spec);

// Moves pieces from frame B to frame A.
void MovePieces(const Pose& X_AB, std::vector<ConvexPiece>& pieces);
// Appends the pieces `more` to `pieces`.
void AppendPieces(const std::vector<ConvexPiece>& more, std::vector<ConvexPiece>& pieces);

// Returns the rotation about `axis` through the origin.
Pose Turn(const Eigen::Vector3d& axis, double angle_deg);
// Returns the rotations by multiples of 360/order degrees about z, without the identity.
std::vector<Pose> CyclicZ(int order);
// Returns CyclicZ() and `order` half turns about axes in the xy plane, the first along x.
std::vector<Pose> DihedralZ(int order);

struct FamilyMaterial {
  double density_kgpm3;
  double friction;
  Rgb8 color;
};

// Moves the origin to the center of the bounding box and converts millimetres to metres.
// `symmetries_mm` are relative to the drawing's origin.
FamilyObject FinishObject(const TriangleMesh& mesh_mm, const std::vector<ConvexPiece>& pieces_mm,
                          const SymmetrySet& symmetries_mm, const FamilyMaterial& material);

}  // namespace pickbed::scenes
