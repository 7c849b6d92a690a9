#pragma once

// Places many small pictures on few large ones, in rows.

#include <span>
#include <vector>

namespace pickbed {

struct AtlasTile {
  int page = 0;
  int x = 0;  // px, of the tile's first column in the page
  int y = 0;
};

struct AtlasPage {
  int width = 0;
  int height = 0;
  int first_tile = 0;  // tiles of a page are consecutive
  int tile_count = 0;
};

struct AtlasLayout {
  std::vector<AtlasTile> tiles;  // as many as sizes, in their order
  std::vector<AtlasPage> pages;
};

struct TileSize {
  int width = 0;
  int height = 0;
};

// Pages are as small as their tiles allow, and at most `side` on a side where no tile is larger.
AtlasLayout LayOutAtlas(std::span<const TileSize> sizes, int side);

}  // namespace pickbed
