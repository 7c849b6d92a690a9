#include "eval/completion/sensors.h"

#include "sim/sensor/depth_noise.h"
#include "sim/sensor/sensor_profile.h"

namespace pickbed::eval {

std::vector<DepthSensor> DepthSensorsNamed(const std::vector<std::string>& names) {
  std::vector<DepthSensor> sensors;
  for (const std::string& name : names) {
    SensorProfile profile = LoadSensorProfile(name);
    profile.min_range_m = 0;
    profile.max_range_m = SensorProfile().max_range_m;
    sensors.push_back(
        [profile](const Image<float>& ideal_m, const CameraIntrinsics& intrinsics, Rng& rng) {
          return ApplySensorNoise({ideal_m, intrinsics}, profile, rng);
        });
  }
  return sensors;
}

}  // namespace pickbed::eval
