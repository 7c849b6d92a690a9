#include "sim/render/atlas.h"

#include <algorithm>

namespace pickbed::sim {

AtlasLayout LayOutAtlas(std::span<const TileSize> sizes, int side) {
  AtlasLayout layout;
  int x = 0, y = 0, row_height = 0;
  for (size_t i = 0; i < sizes.size(); ++i) {
    const auto [width, height] = sizes[i];
    if (x > 0 && x + width > side) {
      y += row_height;
      x = row_height = 0;
    }
    const bool page_is_full = x + width > side || y + height > side;
    if (layout.pages.empty() || (page_is_full && (x > 0 || y > 0))) {
      layout.pages.push_back({0, 0, static_cast<int>(i), 0});
      x = y = row_height = 0;
    }
    AtlasPage& page = layout.pages.back();
    layout.tiles.push_back({static_cast<int>(layout.pages.size()) - 1, x, y});
    x += width;
    row_height = std::max(row_height, height);
    page.width = std::max(page.width, x);
    page.height = std::max(page.height, y + height);
    ++page.tile_count;
  }
  return layout;
}

}  // namespace pickbed::sim
