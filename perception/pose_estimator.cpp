#include <opencv2/surface_matching.hpp>
int h() { return 0; }
