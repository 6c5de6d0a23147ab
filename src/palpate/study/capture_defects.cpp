#include <palpate/study/capture_defects.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <vector>

#include <fmt/format.h>
#include <Eigen/Geometry>

#include <palpate/base/error.h>
#include <palpate/study/random.h>

namespace palpate {
namespace {

using Eigen::Vector3d;
using std::numbers::pi;

constexpr std::array<std::string_view, 7> kDefectNames{"tails", "floaters", "double", "haze",
                                                       "holes", "density",  "faint"};

constexpr double kTailSd = 0.7, kLargeShare = 0.01, kLarge = 5.0, kNeedleShare = 0.02, kNeedle = 10.0;
constexpr double kAir = 0.1;  // thickness of the air with floaters and haze. [m]
constexpr double kFloaterShare = 0.02, kFloaterLeast = 0.3, kFloaterMost = 3.0;  // share of all; in spacings
constexpr double kFloaterFaint = 0.05, kFloaterOpaque = 0.4;
constexpr double kLayerNear = 0.002, kLayerFar = 0.004, kLayerOpacity = 0.5;  // [m]
constexpr double kHazeSmall = 0.005, kHazeLarge = 0.03;                       // [m]
constexpr double kHazeFaint = 0.02, kHazeOpaque = 0.12;
constexpr double kHazeTakes = 0.2, kHazeOver = 0.05;    // fraction of the light; [m]
constexpr double kFaintShare = 1.5, kFaintOff = 0.02;   // relative to all others; [m]
constexpr double kFaintSmall = 0.5, kFaintLarge = 2.0;  // in spacings
constexpr double kFaintest = 0.005, kLeastFaint = 0.1;
constexpr double kHoleShare = 0.1, kHoleLeast = 1.0, kHoleMost = 2.0;
constexpr double kSparsest = 10.0;  // in spacings
constexpr int kDensities = 8;       // bands from the densest to the sparsest
constexpr double kWave = 0.15;      // wavelength of smooth variations. [m]
constexpr std::array<std::uint8_t, 3> kAddedColor{176, 176, 184};

/// A random field with values in [0, 1], about uniformly distributed, as smooth as waves of kWave.
class SmoothField {
 public:
  explicit SmoothField(Random& random) {
    for (Wave& wave : waves_) {
      const double z = random.normal(), y = random.normal(), x = random.normal();
      wave.k = {x, y, z};
      wave.k *= 2.0 * pi / kWave / std::max(1e-3, wave.k.norm());
      wave.phase = random.uniform(0.0, 2.0 * pi);
    }
  }

  double at(const Vector3d& p) const {
    double sum = 0.0;
    for (const Wave& wave : waves_) sum += std::sin(wave.k.dot(p) + wave.phase);
    // The sum of waves is about normal; its distribution function makes it uniform.
    return 0.5 * std::erfc(-sum / std::sqrt(static_cast<double>(waves_.size())));
  }

 private:
  struct Wave {
    Vector3d k = Vector3d::Zero();
    double phase = 0.0;
  };
  std::array<Wave, 4> waves_;
};

Vector3d position_of(const GaussianScene& scene, std::size_t i) { return scene.position[i].cast<double>(); }

float logit(double alpha) { return static_cast<float>(std::log(alpha / (1.0 - alpha))); }

double log_uniform(double low, double high, Random& random) {
  return low * std::pow(high / low, random.uniform());
}

void append(const GaussianScene& from, std::size_t i, GaussianScene& to) {
  to.id.push_back(static_cast<std::uint32_t>(to.size()));
  to.position.push_back(from.position[i]);
  to.scale.push_back(from.scale[i]);
  to.rotation.push_back(from.rotation[i]);
  to.opacity.push_back(from.opacity[i]);
  to.color.push_back(from.color[i]);
}

/// Returns the Gaussians for which `keep(i)` is true.
template <class Keep>
GaussianScene kept(const GaussianScene& scene, const Keep& keep) {
  GaussianScene result;
  result.source = scene.source;
  result.format = scene.format;
  for (std::size_t i = 0; i < scene.size(); ++i) {
    if (keep(i)) append(scene, i, result);
  }
  return result;
}

/// Samples each band of the field evenly, at a spacing of its own.
GaussianScene make_uneven(const AnalyticSurface& surface, ProceduralOptions options, double spacing,
                          const SmoothField& field) {
  GaussianScene scene;
  for (int band = 0; band < kDensities; ++band) {
    options.spacing = spacing * std::pow(kSparsest, static_cast<double>(band) / (kDensities - 1));
    const GaussianScene even = make_scene(surface, options);
    const GaussianScene of_band = kept(even, [&](std::size_t i) {
      return std::min(kDensities - 1, static_cast<int>(kDensities * field.at(position_of(even, i)))) == band;
    });
    if (band == 0) {
      scene = of_band;
    } else {
      for (std::size_t i = 0; i < of_band.size(); ++i) append(of_band, i, scene);
    }
  }
  return scene;
}

GaussianScene make_sheet(const AnalyticSurface& surface, const ProceduralOptions& options, double spacing,
                         const SmoothField* density) {
  return density != nullptr ? make_uneven(surface, options, spacing, *density) : make_scene(surface, options);
}

void add_layer(const AnalyticSurface& surface, const GaussianScene& layer, Random& random,
               GaussianScene& scene) {
  const SmoothField side(random), far(random);
  for (std::size_t i = 0; i < layer.size(); ++i) {
    const Vector3d p = position_of(layer, i);
    const double off = kLayerNear + (kLayerFar - kLayerNear) * far.at(p);
    append(layer, i, scene);
    scene.position.back() = (p + (side.at(p) < 0.5 ? -off : off) * surface.project(p).normal).cast<float>();
    scene.opacity.back() = logit(kLayerOpacity * layer.gaussian(i).opacity);
  }
}

void stretch(Random& random, GaussianScene& scene) {
  for (Eigen::Vector3f& scale : scene.scale) {
    scale.x() += static_cast<float>(kTailSd * random.normal());
    scale.y() += static_cast<float>(kTailSd * random.normal());
    const double kind = random.uniform();
    if (kind < kLargeShare) scale.head<2>().array() += static_cast<float>(std::log(kLarge));
    if (kind > 1.0 - kNeedleShare) scale.y() = scale.x() - static_cast<float>(std::log(kNeedle));
  }
}

GaussianScene with_holes(const AnalyticSurface& surface, const GaussianScene& scene, double spacing,
                         Random& random) {
  struct Disc {
    Vector3d center;
    double radius;
  };
  // Discs at random positions cover a fraction 1 - exp(-sum of their areas / area).
  const std::vector<PartSample> places = surface.samples(spacing, random);
  const double area = static_cast<double>(places.size()) * spacing * spacing;
  std::vector<Disc> discs;
  for (double left = -std::log(1.0 - kHoleShare) * area; left > 0.0;) {
    const double radius = spacing * random.uniform(kHoleLeast, kHoleMost);
    discs.push_back({places[random.index(places.size())].sample.point, radius});
    left -= pi * radius * radius;
  }
  const auto by_x = [](const Disc& disc) { return disc.center.x(); };
  std::ranges::sort(discs, {}, by_x);
  return kept(scene, [&](std::size_t i) {
    const Vector3d p = position_of(scene, i);
    const double most = kHoleMost * spacing;
    for (auto disc = std::ranges::lower_bound(discs, p.x() - most, {}, by_x);
         disc != discs.end() && disc->center.x() <= p.x() + most; ++disc) {
      if ((disc->center - p).norm() < disc->radius) return false;
    }
    return true;
  });
}

void append_in_air(const Vector3d& position, const Vector3d& sigma, double alpha, Random& random,
                   GaussianScene& scene) {
  const double z = random.normal(), y = random.normal(), x = random.normal(), w = random.normal();
  Eigen::Vector4d q(w, x, y, z);
  if (!(q.norm() > 1e-6)) q = Eigen::Vector4d::UnitX();
  const Eigen::Vector4d unit = q.normalized();
  scene.append({position, Eigen::Quaterniond(unit[0], unit[1], unit[2], unit[3]), sigma, alpha}, kAddedColor);
}

Eigen::AlignedBox3d air_around(const GaussianScene& scene) {
  Eigen::AlignedBox3d box;
  for (std::size_t i = 0; i < scene.size(); ++i) box.extend(position_of(scene, i));
  return {box.min() - Vector3d::Constant(kAir), box.max() + Vector3d::Constant(kAir)};
}

Vector3d place_in(const Eigen::AlignedBox3d& box, Random& random) {
  const double z = random.uniform(), y = random.uniform(), x = random.uniform();
  const Vector3d share(x, y, z);
  return box.min() + share.cwiseProduct(box.sizes());
}

bool is_air(const AnalyticSurface& surface, const Vector3d& p) {
  const double distance = surface.distance(p);
  return distance > 0.0 && distance < kAir;
}

void add_floaters(const AnalyticSurface& surface, const Eigen::AlignedBox3d& box, double spacing,
                  Random& random, GaussianScene& scene) {
  const double wanted = std::round(kFloaterShare * static_cast<double>(scene.size()));
  for (double added = 0.0; added < wanted;) {
    const Vector3d p = place_in(box, random);
    if (!is_air(surface, p)) continue;
    const auto size = [&] { return log_uniform(kFloaterLeast * spacing, kFloaterMost * spacing, random); };
    const double a = size(), b = size(), c = size();
    append_in_air(p, {a, b, c}, random.uniform(kFloaterFaint, kFloaterOpaque), random, scene);
    added += 1.0;
  }
}

void add_haze(const AnalyticSurface& surface, const Eigen::AlignedBox3d& box, Random& random,
              GaussianScene& scene) {
  // With n Gaussians per volume, a ray loses n opacity 2 pi a b of -ln(light) per length, on average.
  const double size = (kHazeLarge - kHazeSmall) / std::log(kHazeLarge / kHazeSmall);
  const double each = 0.5 * (kHazeFaint + kHazeOpaque) * 2.0 * pi * size * size;
  const auto wanted =
      static_cast<std::size_t>(std::ceil(-std::log(1.0 - kHazeTakes) / kHazeOver / each * box.volume()));
  for (std::size_t tried = 0; tried < wanted; ++tried) {
    const Vector3d p = place_in(box, random);
    if (!is_air(surface, p)) continue;
    const auto sigma = [&] { return log_uniform(kHazeSmall, kHazeLarge, random); };
    const double a = sigma(), b = sigma(), c = sigma();
    append_in_air(p, {a, b, c}, random.uniform(kHazeFaint, kHazeOpaque), random, scene);
  }
}

void add_faint(const AnalyticSurface& surface, double spacing, Random& random, GaussianScene& scene) {
  const std::vector<PartSample> places = surface.samples(spacing, random);
  const auto wanted = static_cast<std::size_t>(kFaintShare * static_cast<double>(scene.size()));
  for (std::size_t i = 0; i < wanted; ++i) {
    const SurfaceSample& place = places[random.index(places.size())].sample;
    const auto sigma = [&] { return log_uniform(kFaintSmall * spacing, kFaintLarge * spacing, random); };
    const double a = sigma(), b = sigma(), c = sigma();
    const Vector3d off = random.uniform(-kFaintOff, kFaintOff) * place.normal;
    append_in_air(place.point + off, {a, b, c}, log_uniform(kFaintest, kLeastFaint, random), random, scene);
  }
}

}  // namespace

std::span<const std::string_view> capture_defects() { return kDefectNames; }

void set_defect(CaptureDefects& defects, std::string_view name) {
  constexpr std::array<bool CaptureDefects::*, kDefectNames.size()> kFlags{
      &CaptureDefects::tails, &CaptureDefects::floaters, &CaptureDefects::double_layers,
      &CaptureDefects::haze,  &CaptureDefects::holes,    &CaptureDefects::density,
      &CaptureDefects::faint};
  const auto found = std::ranges::find(kDefectNames, name);
  if (found == kDefectNames.end())
    throw Error("there is no defect '{}'; use one of: {}", name, fmt::join(kDefectNames, ", "));
  defects.*kFlags.at(static_cast<std::size_t>(found - kDefectNames.begin())) = true;
}

GaussianScene make_capture(const AnalyticSurface& surface, const ProceduralOptions& options,
                           const CaptureDefects& defects) {
  constexpr std::uint64_t kOtherStream = 0x9E3779B97F4A7C15U;
  const double spacing = options.spacing.value_or(surface.default_spacing());
  Random random(options.seed ^ kOtherStream);
  const SmoothField field(random);
  const SmoothField* density = defects.density ? &field : nullptr;
  GaussianScene scene = make_sheet(surface, options, spacing, density);
  const Eigen::AlignedBox3d air = air_around(scene);
  if (defects.double_layers) {
    ProceduralOptions other = options;
    other.seed ^= kOtherStream;
    add_layer(surface, make_sheet(surface, other, spacing, density), random, scene);
  }
  if (defects.tails) stretch(random, scene);
  if (defects.holes) scene = with_holes(surface, scene, spacing, random);
  if (defects.floaters) add_floaters(surface, air, spacing, random, scene);
  if (defects.haze) add_haze(surface, air, random, scene);
  if (defects.faint) add_faint(surface, spacing, random, scene);
  return scene;
}

}  // namespace palpate
