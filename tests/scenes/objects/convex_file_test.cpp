#include "scenes/objects/convex_file.h"

#include <gmock/gmock.h>

#include "tests/scenes/shapes.h"

namespace pickbed::tests {
namespace {

using testing::HasSubstr;

constexpr char kTwoPieces[] =
    "# comment\no first\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 3\n"
    "o second\nv 2 0 0\nv 3 0 0\r\nv 2 1 0\nv 2 0 1\nv 3 1 1e0\n";

TEST(LoadConvexPieces, ReadsEachGroupInItsUnit) {
  const TemporaryFolder folder;
  const auto path = folder.Write("convex.obj", kTwoPieces);
  const std::vector<ConvexPiece> pieces = LoadConvexPieces(path, "mm");
  ASSERT_EQ(pieces.size(), 2u);
  EXPECT_EQ(pieces[0].vertices_O.size(), 4u);
  ASSERT_EQ(pieces[1].vertices_O.size(), 5u);
  EXPECT_TRUE(pieces[1].vertices_O[4].isApprox(Eigen::Vector3d(0.003, 0.001, 0.001)));
}

// Other programs write the weight or the color of a vertex behind its place.
TEST(LoadConvexPieces, FurtherNumbersOfAVertexAreSkipped) {
  const TemporaryFolder folder;
  const auto path = folder.Write(
      "convex.obj", "o a\nv 0 0 0 1\nv 1 0 0 0.5 0.5 1  # blue\nv 0 1 0 1 0 0\nv 0 0 1\n");
  const std::vector<ConvexPiece> pieces = LoadConvexPieces(path);
  ASSERT_EQ(pieces.size(), 1u);
  ASSERT_EQ(pieces[0].vertices_O.size(), 4u);
  EXPECT_EQ(pieces[0].vertices_O[1], Eigen::Vector3d(1, 0, 0));
}

// Faces are not used, but damaged ones are a sign of a damaged file.
TEST(LoadConvexPieces, FacesOfOtherProgramsAreAccepted) {
  const TemporaryFolder folder;
  const auto path =
      folder.Write("convex.obj",
                   "mtllib a.mtl\no a\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nvt 0 0\nvn 0 0 "
                   "1\nusemtl None\ns off\n"
                   "f 1/1/1 2/1/1 3/1/1\nf 1//1 2//1 4//1\nf -4 -3 -2 -1 # four corners\n"
                   "f 1 2 \\\n3 4\ng None");
  EXPECT_EQ(LoadConvexPieces(path).size(), 1u);
}

TEST(LoadConvexPieces, ErrorsHoldTheFaultyLine) {
  const TemporaryFolder folder;
  struct {
    const char* text;
    const char* message;
  } cases[] = {
      {"o a\nv 0 0 0\nv 1 0 x\n", "c.obj:3: 'v' needs three numbers"},
      {"o a\nv 0 0 0\nv 1 0\n", "c.obj:3: 'v' needs three numbers"},
      {"o a\nv nan 0 0\n", "c.obj:2: 'v' needs three numbers"},
      {"v 0 0 0\n", "c.obj:1: a vertex precedes"},
      {"o a\nv 0 0 0\nv 1 0 0\nv 0 1 0\no b\n", "c.obj:5: a convex piece needs at least 4"},
      {"o a\n", "a convex piece needs at least 4"},
      {"o a\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\n", "c.obj:5: the vertices of a convex piece are"},
      {"o a\nv 0 0 0\nv 1 0 0\nv 2 0 0\nv 3 0 0\no b\n", "c.obj:6: the vertices of a convex"},
      {"o a\nv 1 0 0 x\n", "c.obj:2: 'x' follows the three numbers"},
      {"o a\nv 1e300 0 0\n", "c.obj:2: a coordinate is 1e+07 or more"},
      {"# nothing\n", "has no 'o' group"},
      {"o a\ncW1\n", "c.obj:2: this line begins with 'cW1', which is no word"},
      {"1844674407\n", "c.obj:1: this line begins with '1844674407'"},
      {"o a\nf 1 \xb6 3\n", "is no corner of a face; export the pieces again"},
      {"o a\nf 1 2 0\n", "c.obj:2: a face has corner 0"},
      {"o a\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 5\nf 1 2 3\n",
       "c.obj:6: a face has corner 5, but the file has 4 vertices"},
      {"o a\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 2", "its last line is incomplete"},
  };
  for (const auto& c : cases) {
    const auto path = folder.Write("c.obj", c.text);
    EXPECT_THAT(InputErrorOf([&] { LoadConvexPieces(path); }), HasSubstr(c.message)) << c.text;
  }
  EXPECT_THAT(InputErrorOf([&] { LoadConvexPieces(folder.path() / "none.obj"); }),
              HasSubstr("none.obj"));
}

}  // namespace
}  // namespace pickbed::tests
