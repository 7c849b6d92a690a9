#include <algorithm>
#include <array>
#include <cmath>

#include "scenes/part_families/family_makers.h"
#include "scenes/part_families/shapes.h"

namespace pickbed::scenes {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

// A pipe that starts along +x, bends up about the point (0, 0, bend_radius) and ends along +z.
struct ElbowSize {
  double radius = 12, bore = 8, bend_radius = 26;
  double collar_radius = 16, collar_length = 18;
  double inlet_length = 26, outlet_length = 20;
};

Pose BendStation(const ElbowSize& s, double angle_rad) {
  const Vector3d along(std::cos(angle_rad), 0, std::sin(angle_rad));
  const Vector3d center = s.bend_radius * Vector3d(along.z(), 0, 1 - along.x());
  return Frame(Vector3d::UnitY(), along, center);
}

Pose InletStation(const ElbowSize& s, double from_end) {
  return Frame(Vector3d::UnitY(), Vector3d::UnitX(), {from_end - s.inlet_length, 0, 0});
}

// Returns rings of one radius from the inlet to the outlet.
std::vector<Loop> ElbowRings(const ElbowSize& s, double radius, int facets, double inlet_from) {
  constexpr int kBendSteps = 12;
  const Loop circle = Circle(radius, facets);
  std::vector<Loop> rings = {Moved(circle, InletStation(s, inlet_from))};
  for (int i = 0; i <= kBendSteps; ++i) {
    rings.push_back(Moved(circle, BendStation(s, M_PI / 2 * i / kBendSteps)));
  }
  rings.push_back(Moved(Circle(radius, facets, s.outlet_length), BendStation(s, M_PI / 2)));
  return rings;
}

std::vector<ConvexPiece> ElbowPieces(const ElbowSize& s) {
  std::vector<ConvexPiece> collar = RingPieces({.inner_radius = s.bore,
                                                .outer_radius = s.collar_radius,
                                                .z0 = 0,
                                                .z1 = s.collar_length,
                                                .sectors = 8});
  MovePieces(InletStation(s, 0), collar);
  std::vector<ConvexPiece> outlet = RingPieces({.inner_radius = s.bore,
                                                .outer_radius = s.radius,
                                                .z0 = 0,
                                                .z1 = s.outlet_length,
                                                .sectors = 8});
  MovePieces(BendStation(s, M_PI / 2), outlet);
  std::vector<ConvexPiece> neck = {
      DiscPiece(s.radius, s.radius, s.collar_length, s.inlet_length, 14)};
  MovePieces(InletStation(s, 0), neck);
  std::vector<ConvexPiece> pieces = collar;
  AppendPieces(outlet, pieces);
  AppendPieces(neck, pieces);
  // The bend is filled, because nothing reaches into it through the straight ends.
  constexpr int kBendPieces = 3, kCorners = 10;
  const double step = M_PI / 2 / kBendPieces;
  for (int i = 0; i < kBendPieces; ++i) {
    Loop points;
    for (double at : {i + 0.0, i + 0.5, i + 1.0}) {
      const Loop ring = Circle(BalancedRadius(s.radius, kCorners), kCorners);
      const Loop moved = Moved(ring, BendStation(s, at * step));
      points.insert(points.end(), moved.begin(), moved.end());
    }
    pieces.push_back(HullPiece(points));
  }
  return pieces;
}

}  // namespace

FamilyObject MakeElbow() {
  const ElbowSize s;
  const int facets = 28, bore_facets = 24;
  const std::vector<Loop> outer = ElbowRings(s, s.radius, facets, s.collar_length);
  const std::vector<Loop> bore = ElbowRings(s, s.bore, bore_facets, 0);
  const Loop collar = Circle(s.collar_radius, facets);
  const Loop collar_end = Moved(collar, InletStation(s, 0));
  const Loop collar_back = Moved(collar, InletStation(s, s.collar_length));
  ShellBuilder shell;
  for (size_t i = 0; i + 1 < outer.size(); ++i) shell.Band(outer[i], outer[i + 1]);
  for (size_t i = 0; i + 1 < bore.size(); ++i) shell.Band(bore[i + 1], bore[i]);
  shell.Band(collar_end, collar_back);
  shell.Face(Reversed(collar_end), {bore.front()});
  shell.Face(collar_back, {outer.front()});
  shell.Face(outer.back(), {bore.back()});
  return FinishObject(shell.Build(kCrease_deg), ElbowPieces(s), {}, {1400, 0.5, {64, 128, 112}});
}

namespace {

struct MugSize {
  double radius = 34, inner_radius = 30, height = 90, floor = 5;
  double handle_reach = 26, handle_radius = 5.3;
  double handle_low = 20, handle_high = 68;  // z of the handle's feet
  double foot_half_height = 5.4;
};

constexpr int kMugFacets = 60;
constexpr int kFootCells = 3;  // a foot covers 3 x 3 cells of the wall's net
constexpr int kHandleSteps = 12;

// Returns z of the rows of the wall's net. The rows of the two feet begin at indices 1 and 6.
std::vector<double> MugRows(const MugSize& s) {
  std::vector<double> rows = {0};
  for (double foot : {s.handle_low, s.handle_high}) {
    if (foot == s.handle_high) rows.push_back(0.5 * (s.handle_low + s.handle_high));
    for (int i = 0; i <= kFootCells; ++i) {
      rows.push_back(foot + s.foot_half_height * (2.0 * i / kFootCells - 1));
    }
  }
  rows.push_back(s.height);
  return rows;
}

// The first kFootCells facets are behind the handle, which is at +x.
Loop MugCircle(double radius, double z) {
  return Circle(radius, kMugFacets, z, -M_PI * kFootCells / kMugFacets);
}

void AddMugWall(const MugSize& s, const std::vector<double>& rows, ShellBuilder& shell) {
  for (int r = 0; r + 1 < static_cast<int>(rows.size()); ++r) {
    const Loop low = MugCircle(s.radius, rows[r]), high = MugCircle(s.radius, rows[r + 1]);
    const bool at_foot = (r >= 1 && r < 1 + kFootCells) || (r >= 6 && r < 6 + kFootCells);
    for (int i = at_foot ? kFootCells : 0; i < kMugFacets; ++i) {
      const int next = (i + 1) % kMugFacets;
      shell.Quad(low[i], low[next], high[next], high[i]);
    }
  }
}

// Returns the border of a square of kFootCells x kFootCells cells as (column, row),
// counter-clockwise.
std::vector<Eigen::Vector2i> FootBorder() {
  std::vector<Eigen::Vector2i> border;
  for (int i = 0; i < kFootCells; ++i) border.emplace_back(i, 0);
  for (int i = 0; i < kFootCells; ++i) border.emplace_back(kFootCells, i);
  for (int i = kFootCells; i > 0; --i) border.emplace_back(i, kFootCells);
  for (int i = kFootCells; i > 0; --i) border.emplace_back(0, i);
  return border;
}

// Returns the frame of the handle's cross section at `angle_rad` in [-pi/2, pi/2]: z along the
// handle, y towards the inside of its curve.
Pose HandleStation(const MugSize& s, double angle_rad) {
  const double reach = s.handle_reach, rise = 0.5 * (s.handle_high - s.handle_low);
  const double c = std::cos(angle_rad), n = std::sin(angle_rad);
  const double wall_x = s.radius * std::cos(M_PI * kFootCells / kMugFacets);
  const Vector3d along = Vector3d(-reach * n, 0, rise * c).normalized();
  return Frame(Vector3d::UnitY(), along,
               {wall_x + reach * c, 0, 0.5 * (s.handle_high + s.handle_low) + rise * n});
}

// Returns rings from the lower foot to the upper one. The first and last ring are points of the
// wall; the others are circles.
std::vector<Loop> HandleRings(const MugSize& s, const std::vector<double>& rows) {
  const std::vector<Eigen::Vector2i> border = FootBorder();
  std::vector<Loop> rings(kHandleSteps + 1);
  for (int step = 0; step <= kHandleSteps; ++step) {
    const Pose X = HandleStation(s, M_PI * (static_cast<double>(step) / kHandleSteps - 0.5));
    for (const Eigen::Vector2i& cell : border) {
      const Vector2d square = 2.0 / kFootCells * cell.cast<double>() - Vector2d::Ones();
      const Vector2d round = s.handle_radius * square.normalized();
      if (step == 0) {
        rings[step].push_back(MugCircle(s.radius, rows[1 + cell.y()])[cell.x()]);
      } else if (step == kHandleSteps) {
        rings[step].push_back(MugCircle(s.radius, rows[6 + kFootCells - cell.y()])[cell.x()]);
      } else {
        rings[step].push_back(X * Vector3d(round.x(), round.y(), 0));
      }
    }
  }
  return rings;
}

std::vector<ConvexPiece> MugPieces(const MugSize& s, const std::vector<Loop>& handle) {
  std::vector<ConvexPiece> pieces = RingPieces({.inner_radius = s.inner_radius,
                                                .outer_radius = s.radius,
                                                .z0 = 0,
                                                .z1 = s.height,
                                                .sectors = 14,
                                                .outer_segments = 4});
  pieces.push_back(DiscPiece(s.inner_radius, s.inner_radius, 0, s.floor, 16));
  // The first piece covers one step, because the foot changes from square to round there. Each of
  // the others covers two steps.
  constexpr int kCorners = 10;
  const Loop circle = Circle(BalancedRadius(s.handle_radius, kCorners), kCorners);
  for (int first = 0; first < kHandleSteps;) {
    const int last = first == 0 ? 1 : std::min(first + 2, kHandleSteps);
    Loop points;
    for (int step = first; step <= last; ++step) {
      const bool foot = step == 0 || step == kHandleSteps;
      const double angle = M_PI * (static_cast<double>(step) / kHandleSteps - 0.5);
      const Loop ring = foot ? handle[step] : Moved(circle, HandleStation(s, angle));
      points.insert(points.end(), ring.begin(), ring.end());
    }
    pieces.push_back(HullPiece(points));
    first = last;
  }
  return pieces;
}

}  // namespace

FamilyObject MakeMug() {
  const MugSize s;
  const std::vector<double> rows = MugRows(s);
  const std::vector<Loop> handle = HandleRings(s, rows);
  ShellBuilder shell;
  AddMugWall(s, rows, shell);
  for (int step = 0; step < kHandleSteps; ++step) shell.Band(handle[step], handle[step + 1]);
  shell.Face(Reversed(MugCircle(s.radius, 0)));
  shell.Face(MugCircle(s.radius, s.height), {MugCircle(s.inner_radius, s.height)});
  const std::array<double, 4> inner_z = {s.floor, 33, 61, s.height};
  for (int i = 0; i < 3; ++i) {
    shell.Band(MugCircle(s.inner_radius, inner_z[i + 1]), MugCircle(s.inner_radius, inner_z[i]));
  }
  shell.Face(MugCircle(s.inner_radius, s.floor));
  return FinishObject(shell.Build(50), MugPieces(s, handle), {}, {2300, 0.5, {208, 72, 64}});
}

}  // namespace pickbed::scenes
