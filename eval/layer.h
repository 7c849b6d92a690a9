#pragma once

// pickbed::eval sees the names of the layers below it without qualification. A name that it
// declares itself hides an equal name of a lower layer.

namespace pickbed::scenes {}
namespace pickbed::sim {}
namespace pickbed::perception {}
namespace pickbed::grasp {}

namespace pickbed::eval {
using namespace scenes;
using namespace sim;
using namespace perception;
using namespace grasp;
}  // namespace pickbed::eval
