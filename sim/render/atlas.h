#pragma once

// Layout of many small images (tiles) on a few large ones (pages), in rows.

#include <span>
#include <vector>

#include "sim/layer.h"

namespace pickbed::sim {

struct AtlasTile {
  int page = 0;
  int x = 0;  // px, the tile's first column on the page
  int y = 0;
};

struct AtlasPage {
  int width = 0;
  int height = 0;
  int first_tile = 0;  // tiles of a page are consecutive
  int tile_count = 0;
};

struct AtlasLayout {
  std::vector<AtlasTile> tiles;  // one per size, in the same order
  std::vector<AtlasPage> pages;
};

struct TileSize {
  int width = 0;
  int height = 0;
};

// Assigns each tile a place. A page is as small as its tiles allow. Its sides are at most `side`
// unless a single tile is larger.
AtlasLayout LayOutAtlas(std::span<const TileSize> sizes, int side);

}  // namespace pickbed::sim
