#pragma once

namespace pickbed::scenes {

// A planted fault for the layout test: the second type of this name.
enum class Twin { kOne, kTwo };

}  // namespace pickbed::scenes
