#include <palpate/gateway/local_model.h>

#include <cmath>

namespace palpate {

LocalModel local_model_of(const TickRecord& tick) {
  LocalModel model{tick.felt.local, tick.reading.pose.position, tick.force_scale};
  for (std::size_t k = 0; k < model.surface.count; ++k) {
    auto& [point, normal] = model.surface.planes[k];
    point = tick.map.to_device(Pose{point}).position;
    normal = tick.map.rotation.conjugate() * normal;
  }
  return model;
}

std::vector<double> numbers_of(const LocalModel& model, double stamp) {
  const double seconds = std::floor(stamp);
  const LocalSurface& surface = model.surface;
  std::vector<double> all{seconds,
                          std::round(1e9 * (stamp - seconds)),
                          model.position.x(),
                          model.position.y(),
                          model.position.z(),
                          surface.stiffness,
                          surface.damping,
                          surface.friction,
                          model.share};
  for (std::size_t k = 0; k < surface.count; ++k) {
    const auto& [point, normal] = surface.planes[k];
    for (const Eigen::Vector3d& v : {point, normal}) all.insert(all.end(), v.data(), v.data() + 3);
  }
  return all;
}

}  // namespace palpate
