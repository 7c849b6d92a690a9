// A planted fault for the include test: OpenCV outside the sub-folders that may include it.
#include <opencv2/core.hpp>
