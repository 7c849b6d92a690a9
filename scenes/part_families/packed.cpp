#include <algorithm>
#include <array>
#include <cmath>

#include "scenes/part_families/family_makers.h"
#include "scenes/part_families/shapes.h"

namespace pickbed::scenes {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

// ---- Carton: a box whose six sides share one printed sheet, 1 px per millimetre ----

constexpr int kWidth = 60, kDepth = 90, kHeight = 140;  // x, y, z
constexpr int kCell = 15;                               // mesh cells are at least this large

struct Side {
  Vector3d corner, right, down;  // upper left corner and sides as seen from outside, mm
  Eigen::Vector2i sheet;         // upper left pixel on the sheet
};

// Front, right, back and left are next to each other on the sheet; top and bottom are below them.
std::array<Side, 6> CartonSides() {
  const Vector3d x = kWidth * Vector3d::UnitX(), y = kDepth * Vector3d::UnitY();
  const Vector3d z = kHeight * Vector3d::UnitZ(), low = -0.5 * (x + y + z);
  return {Side{low + y + z, -y, -z, {0, 0}},
          Side{low + z, x, -z, {kDepth, 0}},
          Side{low + x + z, y, -z, {kDepth + kWidth, 0}},
          Side{low + x + y + z, -x, -z, {2 * kDepth + kWidth, 0}},
          Side{low + z + y, x, -y, {0, kHeight}},
          Side{low, x, y, {kWidth, kHeight}}};
}

void FillBox(Image<Rgb8>& sheet, int x, int y, int width, int height, Rgb8 color) {
  for (int row = y; row < y + height; ++row) {
    std::fill_n(sheet.row(row) + x, width, color);
  }
}

void FillDisc(Image<Rgb8>& sheet, int cx, int cy, int radius, Rgb8 color) {
  for (int y = cy - radius; y <= cy + radius; ++y) {
    for (int x = cx - radius; x <= cx + radius; ++x) {
      if ((x - cx) * (x - cx) + (y - cy) * (y - cy) <= radius * radius) sheet(x, y) = color;
    }
  }
}

// Draws lines of bars of different lengths that look like text.
void PrintBars(Image<Rgb8>& sheet, int x, int y, int width, int lines, int pitch, Rgb8 ink) {
  for (int line = 0; line < lines; ++line) {
    for (int at = 0, word = line; at < width - 4; ++word) {
      const int length = std::min(4 + (word * 7 + line * 5) % 9, width - at);
      FillBox(sheet, x + at, y + line * pitch, length, std::max(1, pitch / 2), ink);
      at += length + 2;
    }
  }
}

Image<Rgb8> CartonSheet() {
  const Rgb8 paper{244, 236, 214}, blue{28, 84, 156}, red{206, 52, 44}, yellow{246, 190, 40};
  const Rgb8 ink{44, 44, 52}, white{255, 255, 255};
  Image<Rgb8> sheet(2 * (kWidth + kDepth), kHeight + kDepth, paper);
  // Front: band, logo, block letters and text.
  FillBox(sheet, 0, 0, kDepth, 34, blue);
  for (int i = 0; i < 5; ++i) FillBox(sheet, 10 + 15 * i, 9, 9 + 2 * (i % 2), 16, white);
  FillDisc(sheet, 45, 72, 27, yellow);
  FillDisc(sheet, 45, 72, 17, red);
  FillBox(sheet, 41, 58, 8, 28, white);
  PrintBars(sheet, 10, 108, 70, 3, 8, ink);
  // Right: a table with rules.
  const int right = kDepth;
  FillBox(sheet, right, 0, kWidth, 14, blue);
  FillBox(sheet, right + 6, 24, kWidth - 12, 92, white);
  for (int i = 0; i < 9; ++i) FillBox(sheet, right + 6, 24 + 11 * i, kWidth - 12, 1, ink);
  PrintBars(sheet, right + 9, 28, 24, 8, 11, ink);
  PrintBars(sheet, right + 40, 28, 10, 8, 11, ink);
  // Back: stripes, text, bar code.
  const int back = kDepth + kWidth;
  for (int i = 0; i < 6; ++i) FillBox(sheet, back, 6 * i, kDepth, 3, i % 2 ? yellow : red);
  PrintBars(sheet, back + 8, 46, 74, 8, 6, ink);
  FillBox(sheet, back + 44, 104, 38, 26, white);
  for (int i = 0; i < 15; ++i) {
    FillBox(sheet, back + 47 + 2 * i + i % 3 / 2, 107, 1 + i % 2, 20, ink);
  }
  // Left: one color with a ladder of blocks.
  const int left = 2 * kDepth + kWidth;
  FillBox(sheet, left, 0, kWidth, kHeight, red);
  for (int i = 0; i < 6; ++i) FillBox(sheet, left + 6 + 7 * i, 116 - 18 * i, 14, 14, yellow);
  // Top and bottom: tape and an arrow, flaps.
  FillBox(sheet, 22, kHeight, 16, kDepth, blue);
  FillBox(sheet, 6, kHeight + 10, 10, 20, red);
  FillBox(sheet, kWidth + 28, kHeight, 4, kDepth, ink);
  PrintBars(sheet, kWidth + 6, kHeight + 60, 18, 3, 6, ink);
  return sheet;
}

void AddSide(const Side& side, const Image<Rgb8>& sheet, TriangleMesh& mesh) {
  const double width = side.right.norm(), height = side.down.norm();
  const int columns = static_cast<int>(width) / kCell, rows = static_cast<int>(height) / kCell;
  const int first = static_cast<int>(mesh.vertices.size());
  const Vector3d normal = side.down.cross(side.right).normalized();
  for (int r = 0; r <= rows; ++r) {
    for (int c = 0; c <= columns; ++c) {
      const double u = static_cast<double>(c) / columns, v = static_cast<double>(r) / rows;
      mesh.vertices.push_back(side.corner + u * side.right + v * side.down);
      mesh.normals.push_back(normal);
      mesh.uvs.emplace_back((side.sheet.x() + u * width) / sheet.width(),
                            (side.sheet.y() + v * height) / sheet.height());
    }
  }
  for (int r = 0; r < rows; ++r) {
    for (int c = 0; c < columns; ++c) {
      const int a = first + r * (columns + 1) + c, b = a + columns + 1;  // b is below a
      mesh.triangles.emplace_back(a, b, b + 1);
      mesh.triangles.emplace_back(a, b + 1, a + 1);
    }
  }
}

}  // namespace

FamilyObject MakeCarton() {
  TriangleMesh mesh;
  mesh.texture = CartonSheet();
  for (const Side& side : CartonSides()) AddSide(side, mesh.texture, mesh);
  const Vector3d half(0.5 * kWidth, 0.5 * kDepth, 0.5 * kHeight);
  return FinishObject(mesh, {BoxPiece(-half, half)}, {DihedralZ(2), {}},
                      {350, 0.5, {244, 236, 214}});
}

FamilyObject MakeBottle() {
  const int facets = 48;
  const double body_low = 5, body_high = 110;
  const std::vector<Vector2d> below = {{0, 0}, {25, 0}, {30, body_low}};
  const std::vector<Vector2d> above = {{30, body_high}, {29, 118}, {26, 127}, {21, 136}, {14, 146},
                                       {12, 150},       {12, 156}, {14, 156}, {14, 172}, {13, 174}};
  Outline profile(below.begin(), below.end());
  constexpr int kBodyRows = 7;
  for (int i = 1; i < kBodyRows; ++i) {
    profile.emplace_back(30, body_low + (body_high - body_low) * i / kBodyRows);
  }
  profile.insert(profile.end(), above.begin(), above.end());
  profile.emplace_back(0, 174);
  ShellBuilder shell;
  shell.Revolve(profile, facets);

  std::vector<ConvexPiece> pieces = {DiscPiece(25, 30, 0, body_low, 16),
                                     DiscPiece(30, 30, body_low, body_high, 16)};
  for (size_t i = 0; i + 1 < above.size(); ++i) {
    const Vector2d &low = above[i], &high = above[i + 1];
    if (low.y() < high.y()) {
      pieces.push_back(DiscPiece(low.x(), high.x(), low.y(), high.y(), 16));
    }
  }
  return FinishObject(shell.Build(kCrease_deg), pieces, {{}, {ContinuousSymmetry{}}},
                      {500, 0.5, {72, 132, 196}});
}

}  // namespace pickbed::scenes
