#include <palpate/scene/gaussian_scene.h>

#include <cmath>

namespace palpate {

Gaussian GaussianScene::gaussian(std::size_t i) const {
  Gaussian g;
  g.position = origin + position[i].cast<double>();

  const Eigen::Vector4d q = rotation[i].cast<double>();
  const Eigen::Vector4d unit = q / q.norm();
  g.rotation = Eigen::Quaterniond(unit[0], unit[1], unit[2], unit[3]);

  g.sigma = scale_encoding == ScaleEncoding::kLog
                ? scale[i].cast<double>().unaryExpr([](double s) { return std::exp(s); }).eval()
                : scale[i].cast<double>().cwiseAbs().eval();

  const double o = opacity[i];
  g.opacity = opacity_encoding == OpacityEncoding::kLogit ? 1.0 / (1.0 + std::exp(-o)) : o / 255.0;

  if (!filter_3d.empty()) {
    const double f = filter_3d[i];
    for (double& s : g.sigma) {
      const double filtered = std::hypot(s, f);
      if (filtered > 0.0) g.opacity *= s / filtered;
      s = filtered;
    }
  }
  return g;
}

void GaussianScene::append(const Gaussian& activated, const std::array<std::uint8_t, 3>& rgb) {
  const Eigen::Quaterniond& q = activated.rotation;
  const double alpha = activated.opacity;
  id.push_back(static_cast<std::uint32_t>(size()));
  position.push_back(activated.position.cast<float>());
  scale.push_back(activated.sigma.array().log().matrix().cast<float>());
  rotation.push_back(Eigen::Vector4d(q.w(), q.x(), q.y(), q.z()).cast<float>());
  opacity.push_back(static_cast<float>(std::log(alpha / (1.0 - alpha))));
  color.push_back(rgb);
}

void GaussianScene::reserve(std::size_t n) {
  id.reserve(n);
  position.reserve(n);
  scale.reserve(n);
  rotation.reserve(n);
  opacity.reserve(n);
  filter_3d.reserve(n);
  color.reserve(n);
}

const char* to_string(Defect defect) {
  switch (defect) {
    case Defect::kNone: return "none";
    case Defect::kNan: return "nan";
    case Defect::kInfinite: return "infinite";
    case Defect::kZeroQuaternion: return "zero_quaternion";
    case Defect::kZeroScale: return "zero_scale";
  }
  return "?";
}

Defect defect(const GaussianScene& scene, std::size_t i) { return defect(scene, i, scene.gaussian(i)); }

Defect defect(const GaussianScene& scene, std::size_t i, const Gaussian& activated) {
  const bool nan = scene.position[i].hasNaN() || scene.scale[i].hasNaN() || scene.rotation[i].hasNaN() ||
                   std::isnan(scene.opacity[i]) ||
                   (!scene.filter_3d.empty() && std::isnan(scene.filter_3d[i]));
  if (nan) return Defect::kNan;
  const auto real = [](double v) { return std::abs(v) <= kMaxExtent; };
  const bool finite = real(activated.position[0]) && real(activated.position[1]) &&
                      real(activated.position[2]) && real(activated.sigma[0]) && real(activated.sigma[1]) &&
                      real(activated.sigma[2]) && scene.rotation[i].allFinite();
  if (!finite) return Defect::kInfinite;
  if (scene.rotation[i].isZero(0.0F)) return Defect::kZeroQuaternion;
  if (activated.sigma.isZero(0.0)) return Defect::kZeroScale;
  return Defect::kNone;
}

}  // namespace palpate
