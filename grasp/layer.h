#pragma once

// Makes the names of the lower layers visible in pickbed::grasp without qualification. A name
// declared in pickbed::grasp hides an equal name of a lower layer.

namespace pickbed::scenes {}
namespace pickbed::sim {}

namespace pickbed::grasp {
using namespace scenes;
using namespace sim;
}  // namespace pickbed::grasp
