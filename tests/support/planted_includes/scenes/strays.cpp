// A planted fault for the include test: OpenCV outside its room.
#include <opencv2/core.hpp>
