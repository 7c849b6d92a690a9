#include "sim/render/atlas.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "scenes/base/random.h"
#include "tests/support/layer.h"

namespace pickbed::tests {
namespace {

TEST(Atlas, TilesAreInsideTheirPagesAndDisjoint) {
  Rng rng(1);
  std::vector<TileSize> sizes;
  for (int i = 0; i < 200; ++i) sizes.push_back({1 + rng.Index(90), 1 + rng.Index(70)});
  sizes[50] = {700, 20};  // larger than a page
  sizes[120] = {30, 500};
  constexpr int kSide = 256;
  const AtlasLayout layout = LayOutAtlas(sizes, kSide);
  ASSERT_EQ(layout.tiles.size(), sizes.size());
  EXPECT_GT(layout.pages.size(), 3u);
  int next = 0;
  for (size_t p = 0; p < layout.pages.size(); ++p) {
    const AtlasPage& page = layout.pages[p];
    EXPECT_EQ(page.first_tile, next);
    next += page.tile_count;
    std::vector<int> covered(static_cast<size_t>(page.width) * page.height, 0);
    int widest = 0, highest = 0;
    for (int i = page.first_tile; i < next; ++i) {
      widest = std::max(widest, sizes[i].width);
      highest = std::max(highest, sizes[i].height);
      const AtlasTile& tile = layout.tiles[i];
      ASSERT_EQ(tile.page, static_cast<int>(p));
      ASSERT_LE(tile.x + sizes[i].width, page.width);
      ASSERT_LE(tile.y + sizes[i].height, page.height);
      for (int y = tile.y; y < tile.y + sizes[i].height; ++y) {
        for (int x = tile.x; x < tile.x + sizes[i].width; ++x) {
          ASSERT_EQ(covered[static_cast<size_t>(y) * page.width + x]++, 0);
        }
      }
    }
    EXPECT_LE(page.width, std::max(kSide, widest));
    EXPECT_LE(page.height, std::max(kSide, highest));
  }
  EXPECT_EQ(next, static_cast<int>(sizes.size()));
}

TEST(Atlas, EqualTilesFillThePage) {
  const AtlasLayout layout = LayOutAtlas(std::vector<TileSize>(32, TileSize{64, 64}), 256);
  ASSERT_EQ(layout.pages.size(), 2u);
  EXPECT_EQ(layout.pages[0].tile_count, 16);
  EXPECT_EQ(layout.pages[0].width, 256);
  EXPECT_EQ(layout.pages[0].height, 256);
}

TEST(Atlas, NoTilesNeedNoPage) { EXPECT_TRUE(LayOutAtlas({}, 64).pages.empty()); }

}  // namespace
}  // namespace pickbed::tests
