#include <pcl/registration/icp.h>

#include <flann/flann.hpp>
int f() {
  pcl::IterativeClosestPoint<pcl::PointXYZ, pcl::PointXYZ> i;
  return 0;
}
