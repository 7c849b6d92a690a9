#include <algorithm>
#include <array>
#include <cmath>

#include "scenes/part_families/family_makers.h"
#include "scenes/part_families/shapes.h"

namespace pickbed::scenes {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

// One end of a connecting rod: a ring about z. Its outer side has a window where the web joins.
struct Eye {
  Vector2d center;
  double outer_radius, bore_radius, half_height;
  int facets;
  int window_facets;  // even
  double window_rad;  // direction of the window's center

  Outline Outer() const {
    const double phase = window_rad - M_PI * window_facets / facets;
    return CircleOutline(center, outer_radius, facets, phase);  // the window's facets come first
  }
};

void AddEye(const Eye& eye, double web_half_height, ShellBuilder& shell) {
  const Outline outer = eye.Outer();
  const Outline bore = CircleOutline(eye.center, eye.bore_radius, 30);
  const std::array<double, 4> z = {-eye.half_height, -web_half_height, web_half_height,
                                   eye.half_height};
  for (int band = 0; band < 3; ++band) {
    const Loop low = AtHeight(outer, z[band]), high = AtHeight(outer, z[band + 1]);
    for (int i = band == 1 ? eye.window_facets : 0; i < eye.facets; ++i) {
      const int next = (i + 1) % eye.facets;
      shell.Quad(low[i], low[next], high[next], high[i]);
    }
  }
  shell.Face(AtHeight(outer, z[3]), {AtHeight(bore, z[3])});
  shell.Face(Reversed(AtHeight(outer, z[0])), {AtHeight(bore, z[0])});
  shell.Band(AtHeight(bore, z[3]), AtHeight(bore, z[0]));
}

Outline WindowArc(const Eye& eye) {
  const Outline outer = eye.Outer();
  return Outline(outer.begin(), outer.begin() + eye.window_facets + 1);
}

std::vector<ConvexPiece> EyePieces(const Eye& eye, int sectors) {
  std::vector<ConvexPiece> pieces = RingPieces({.inner_radius = eye.bore_radius,
                                                .outer_radius = eye.outer_radius,
                                                .z0 = -eye.half_height,
                                                .z1 = eye.half_height,
                                                .sectors = sectors});
  MovePieces(Translation({eye.center.x(), eye.center.y(), 0}), pieces);
  return pieces;
}

}  // namespace

FamilyObject MakeRod() {
  const Eye big{{0, 0}, 16, 10, 8, 36, 6, 0};
  const Eye small{{64, 0}, 11, 6, 6, 30, 6, M_PI};
  const double web_half = 3.5;
  const Outline big_arc = WindowArc(big), small_arc = WindowArc(small);
  Outline web(big_arc.rbegin(), big_arc.rend());  // from +y to -y, then along the rod
  web.insert(web.end(), small_arc.rbegin(), small_arc.rend());
  const Vector2d low0 = big_arc.front(), low1 = small_arc.back();
  const Vector2d high0 = big_arc.back(), high1 = small_arc.front();
  const auto at = [](const Vector2d& p, double z) { return Vector3d(p.x(), p.y(), z); };

  ShellBuilder shell;
  AddEye(big, web_half, shell);
  AddEye(small, web_half, shell);
  shell.Face(AtHeight(web, web_half));
  shell.Face(Reversed(AtHeight(web, -web_half)));
  shell.Quad(at(low0, -web_half), at(low1, -web_half), at(low1, web_half), at(low0, web_half));
  shell.Quad(at(high1, -web_half), at(high0, -web_half), at(high0, web_half), at(high1, web_half));

  std::vector<ConvexPiece> pieces = {PrismPiece({low0, low1, high1, high0}, -web_half, web_half)};
  AppendPieces(EyePieces(big, 8), pieces);
  AppendPieces(EyePieces(small, 6), pieces);
  return FinishObject(shell.Build(kCrease_deg), pieces, {{Turn(Vector3d::UnitX(), 180)}, {}},
                      {7800, 0.45, {140, 128, 120}});
}

namespace {

struct TeeSize {
  double run_radius = 14, run_bore = 10, half_length = 40;
  double branch_radius = 12, branch_bore = 8, branch_top = 36;  // height above the run's axis
  double saddle_half_rad = M_PI / 3;  // the branch cuts pieces of the run within this angle from +z
};

// The wall of a tube along x with a port for a tube of `port_radius` along +z.
struct PortedTube {
  double radius, port_radius, half_length, top;
  int half_facets;  // facets over half of the circumference
  int columns;      // along x
  bool bore;        // true: an inner wall, whose faces point to the axis
};

Vector3d OnTube(const PortedTube& tube, double x, double angle_rad) {
  return {x, tube.radius * std::sin(angle_rad), tube.radius * std::cos(angle_rad)};
}

// Returns the border of the unrolled upper half as (x, angle from +z), counter-clockwise as seen
// from above.
Outline UpperBorder(const PortedTube& tube) {
  const double l = tube.half_length, quarter = M_PI / 2;
  const auto side = [](const Vector2d& from, const Vector2d& to, int steps, Outline& border) {
    for (int i = 0; i < steps; ++i) border.push_back(from + (to - from) * i / steps);
  };
  Outline border;
  side({l, -quarter}, {l, quarter}, tube.half_facets, border);
  side({l, quarter}, {-l, quarter}, tube.columns, border);
  side({-l, quarter}, {-l, -quarter}, tube.half_facets, border);
  side({-l, -quarter}, {l, -quarter}, tube.columns, border);
  return border;
}

void AddNet(std::vector<Loop> rows, bool inside, ShellBuilder& shell) {
  if (inside) {
    for (Loop& row : rows) std::reverse(row.begin(), row.end());
  }
  shell.Net(rows);
}

// Adds the tube and its branch up to `top`; returns the branch's upper loop.
Loop AddPortedTube(const PortedTube& tube, ShellBuilder& shell) {
  constexpr int kRings = 3;  // rings of quads between port and border, and along the branch
  const Outline border = UpperBorder(tube);
  const int n = static_cast<int>(border.size());
  std::vector<Loop> collar(kRings + 1), branch(kRings + 1), lower(tube.half_facets + 1);
  for (int i = 0; i <= n; ++i) {  // the first point is repeated to close the net
    const double around = 2 * M_PI * (i - 0.5 * tube.half_facets) / n;
    const Vector2d plan = tube.port_radius * Vector2d(std::cos(around), std::sin(around));
    const Vector2d port(plan.x(), std::asin(plan.y() / tube.radius));
    const Vector3d foot = OnTube(tube, port.x(), port.y());
    const Vector3d head(plan.x(), plan.y(), tube.top);
    for (int r = 0; r <= kRings; ++r) {
      const double t = static_cast<double>(r) / kRings;
      const Vector2d unrolled = border[i % n] + (port - border[i % n]) * t;
      collar[r].push_back(r == kRings ? foot : OnTube(tube, unrolled.x(), unrolled.y()));
      branch[r].push_back(foot + (head - foot) * t);
    }
  }
  for (int r = 0; r <= tube.half_facets; ++r) {
    const double angle = M_PI / 2 + M_PI * r / tube.half_facets;
    for (int c = 0; c <= tube.columns; ++c) {
      const double x = tube.half_length * (2.0 * c / tube.columns - 1);
      lower[r].push_back(OnTube(tube, x, angle));
    }
  }
  Loop top(branch[kRings].begin(), branch[kRings].end() - 1);
  AddNet(collar, tube.bore, shell);
  AddNet(branch, tube.bore, shell);
  AddNet(lower, tube.bore, shell);
  return top;
}

// Returns the pieces of the branch's wall: sectors about z that end at the run's bore. Their
// straight lower ends would cut into the bore, so they end kShort before it. Below `lowest` the
// run's own pieces form the wall.
std::vector<ConvexPiece> BranchPieces(const TeeSize& s, int sectors) {
  constexpr double kShort = 0.5;  // mm, half of the depth of that cut
  const double foot = s.run_bore + kShort;
  const double lowest = s.run_bore * std::cos(s.saddle_half_rad);
  const double step = 2 * M_PI / sectors;
  std::vector<ConvexPiece> pieces = RingPieces({.inner_radius = s.branch_bore,
                                                .outer_radius = s.branch_radius,
                                                .z0 = 0,
                                                .z1 = s.branch_top,
                                                .sectors = sectors,
                                                .begin_rad = -step / 2});
  for (ConvexPiece& piece : pieces) {
    for (Vector3d& p : piece.vertices_O) {
      if (p.z() > 0) continue;
      p.z() = std::max(lowest, std::sqrt(std::max(0.0, foot * foot - p.y() * p.y())));
    }
  }
  return pieces;
}

// Returns the pieces of the run's wall under the branch, on one side of it. They are sectors about
// z = the run's axis and reach to the center of the branch's wall.
std::vector<ConvexPiece> SaddlePieces(const TeeSize& s, double side) {
  std::vector<ConvexPiece> pieces = RingPieces({.inner_radius = s.run_bore,
                                                .outer_radius = s.run_radius,
                                                .z0 = 0,
                                                .z1 = s.half_length,
                                                .sectors = 3,
                                                .begin_rad = -s.saddle_half_rad,
                                                .sweep_rad = 2 * s.saddle_half_rad});
  const double reach = 0.5 * (s.branch_radius + s.branch_bore);
  for (ConvexPiece& piece : pieces) {
    for (Vector3d& p : piece.vertices_O) {
      if (p.z() == 0) p.z() = std::sqrt(std::max(0.0, reach * reach - p.y() * p.y()));
      p.z() *= side;
    }
  }
  return pieces;
}

}  // namespace

FamilyObject MakePipeTee() {
  const TeeSize s;
  const PortedTube outside{s.run_radius, s.branch_radius, s.half_length, s.branch_top, 12, 8,
                           false};
  const PortedTube inside{s.run_bore, s.branch_bore, s.half_length, s.branch_top, 10, 6, true};
  ShellBuilder shell;
  const Loop branch_outer = AddPortedTube(outside, shell);
  const Loop branch_inner = AddPortedTube(inside, shell);
  shell.Face(branch_outer, {branch_inner});
  const Pose along_x = Frame(Vector3d::UnitZ(), Vector3d::UnitX());
  for (double x : {-s.half_length, s.half_length}) {
    const Loop outer = Moved(Circle(s.run_radius, 2 * outside.half_facets, x), along_x);
    const Loop bore = Moved(Circle(s.run_bore, 2 * inside.half_facets, x), along_x);
    shell.Face(x > 0 ? outer : Reversed(outer), {bore});
  }

  // Sectors away from the branch have the full length. Sectors under it end on both sides of its
  // bore.
  std::vector<ConvexPiece> pieces = RingPieces({.inner_radius = s.run_bore,
                                                .outer_radius = s.run_radius,
                                                .z0 = -s.half_length,
                                                .z1 = s.half_length,
                                                .sectors = 6,
                                                .begin_rad = s.saddle_half_rad,
                                                .sweep_rad = 2 * (M_PI - s.saddle_half_rad)});
  for (double side : {-1.0, 1.0}) AppendPieces(SaddlePieces(s, side), pieces);
  MovePieces(along_x, pieces);
  AppendPieces(BranchPieces(s, 8), pieces);
  return FinishObject(shell.Build(kCrease_deg), pieces, {CyclicZ(2), {}},
                      {1400, 0.5, {196, 92, 60}});
}

}  // namespace pickbed::scenes
