#include <palpate/study/procedural.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include <fmt/format.h>

#include <palpate/base/error.h>

namespace palpate {
namespace {

using Eigen::Vector3d;
using std::numbers::pi;
using Color = std::array<std::uint8_t, 3>;

/// Spacing of a single shape: 7,900 Gaussians on the sphere, as dense as captures of small objects.
constexpr double kDefaultSpacing = 0.006;  // Unit: [m].
/// Spacing of the table: about 80,000 Gaussians.
constexpr double kTableSpacing = 0.0045;  // Unit: [m].
/// Spacing of the truck: about 250,000 Gaussians.
constexpr double kTruckSpacing = 0.0136;  // Unit: [m].

/// Distance to another part within which a point is covered by it: parts that touch do so exactly, up to the
/// rounding of their poses. Unit: [m].
constexpr double kTouching = 1e-9;

/// Standard deviations in the plane of a splat, in spacings: at one sigma a disc of 0.65 h covers
/// 1.3 times the h^2 it stands for, so a sheet has no hole that a fingertip could enter.
constexpr double kTangentSigma = 0.65;
/// Largest relative variation of these, as trained splats are not round.
constexpr double kTangentVariation = 0.2;
/// Standard deviation across the splat, in spacings: far below its width, as training flattens
/// splats on surfaces, yet thick enough to have a well-conditioned normal in single precision.
constexpr double kNormalSigma = 0.05;
/// All pass the usual opacity thresholds (0.1 to 0.3); none is so opaque that its logit is extreme.
constexpr double kOpacityMin = 0.6;
constexpr double kOpacityMax = 0.99;

constexpr Color kGrey{176, 176, 184};
constexpr Color kWood{150, 111, 72};
constexpr Color kDarkWood{99, 69, 44};

Pose placed(const Vector3d& position, const Vector3d& axis = Vector3d::UnitZ(), double angle = 0.0) {
  return {position, Eigen::Quaterniond(Eigen::AngleAxisd(angle, axis))};
}

Vector3d to_world(const Pose& pose, const Vector3d& p) { return pose.orientation * p + pose.position; }
Vector3d to_local(const Pose& pose, const Vector3d& p) {
  return pose.orientation.conjugate() * (p - pose.position);
}

double part_distance(const SurfacePart& part, const Vector3d& p) {
  return part.shape->nearest(to_local(part.pose, p)).distance;
}

using Parts = std::vector<SurfacePart>;

Parts single(std::string_view name, std::unique_ptr<AnalyticShape> shape) {
  return {{std::string(name), kGrey, {}, std::move(shape)}};
}

Parts step_parts() {
  constexpr double kSize = 0.4;
  constexpr double kRise = 0.003;
  const std::shared_ptr<const AnalyticShape> half = make_rectangle(0.5 * kSize, kSize);
  return {{"low", kGrey, placed({-0.25 * kSize, 0.0, 0.0}), half},
          {"high", kGrey, placed({0.25 * kSize, 0.0, kRise}), half},
          // Rotated about y, so that its outward side faces -x, where the surface is lower.
          {"riser", kGrey, placed({0.0, 0.0, 0.5 * kRise}, Vector3d::UnitY(), -pi / 2.0),
           make_rectangle(kRise, kSize)}};
}

Parts table_furniture() {
  const Vector3d top(0.8, 0.6, 0.03);
  const Vector3d leg(0.04, 0.04, 0.4);
  constexpr double kInset = 0.02;
  Parts parts{{"top", kWood, placed({0.0, 0.0, -0.5 * top[2]}), make_box(top)}};
  const std::shared_ptr<const AnalyticShape> leg_box = make_box(leg);
  const Vector3d corner = 0.5 * (top - leg) - Vector3d::Constant(kInset);
  for (const double x : {-corner[0], corner[0]}) {
    for (const double y : {-corner[1], corner[1]})
      parts.push_back({"leg", kDarkWood, placed({x, y, -top[2] - 0.5 * leg[2]}), leg_box});
  }
  return parts;
}

/// Objects that stand on z = 0, far enough apart for the default tool to pass between most of them.
Parts table_parts() {
  const Vector3d up = Vector3d::UnitZ();
  Parts parts = table_furniture();
  parts.push_back({"ball", {200, 48, 44}, placed({-0.25, 0.14, 0.06}), make_sphere(0.06)});
  parts.push_back({"crate", {52, 98, 178}, placed({0.22, 0.14, 0.05}, up, 0.45), make_box({0.14, 0.1, 0.1})});
  parts.push_back({"can", {58, 145, 76}, placed({0.0, 0.17, 0.06}), make_cylinder(0.04, 0.12)});
  parts.push_back({"ring", {230, 180, 40}, placed({-0.03, -0.06, 0.02}), make_torus(0.055, 0.02)});
  parts.push_back(
      {"bowl", {70, 170, 180}, placed({-0.26, -0.12, 0.08}, Vector3d::UnitX(), pi), make_dome(0.08)});
  parts.push_back(
      {"book", {128, 62, 140}, placed({0.22, -0.14, 0.015}, up, 0.2), make_box({0.2, 0.14, 0.03})});
  parts.push_back({"small book",
                   {222, 122, 48},
                   placed({0.215, -0.135, 0.0425}, up, -0.15),
                   make_box({0.15, 0.11, 0.025})});
  return parts;
}

/// A pick-up truck of 5.3 m on its wheels, front towards +x, with objects in its bed. Round ones are 1 mm
/// above it: where they touched it, rounding would decide which of them a point belongs to.
Parts truck_parts() {
  const Color paint{148, 32, 36}, glass{70, 84, 96}, metal{196, 198, 202}, amber{236, 150, 36},
      rubber{38, 38, 40};
  const std::shared_ptr<const AnalyticShape> wheel = make_cylinder(0.4, 0.25);
  const std::shared_ptr<const AnalyticShape> side = make_box({2.1, 0.08, 0.45});
  const std::shared_ptr<const AnalyticShape> lamp = make_box({0.14, 0.1, 0.1});
  Parts parts{{"body", paint, placed({0.0, 0.0, 0.7}), make_box({5.2, 1.9, 0.5})},
              {"bonnet", paint, placed({1.8, 0.0, 1.075}), make_box({1.4, 1.8, 0.25})},
              {"cab", glass, placed({0.3, 0.0, 1.375}), make_box({1.6, 1.8, 0.85})},
              {"tailgate", paint, placed({-2.56, 0.0, 1.175}), make_box({0.08, 1.74, 0.45})},
              {"bumper", metal, placed({2.675, 0.0, 0.6}), make_box({0.15, 1.9, 0.2})},
              {"spare wheel", rubber, placed({-1.9, 0.3, 1.041}), make_torus(0.28, 0.09)},
              {"barrel", metal, placed({-1.0, -0.4, 1.25}), make_cylinder(0.25, 0.6)},
              {"ball", {52, 98, 178}, placed({-1.05, 0.5, 1.171}), make_sphere(0.22)}};
  for (const double y : {-1.0, 1.0}) {
    parts.push_back({"side", paint, placed({-1.55, 0.91 * y, 1.175}), side});
    parts.push_back({"turn signal", amber, placed({2.35, 0.8 * y, 1.25}), lamp});
    for (const double x : {-1.6, 1.6})
      parts.push_back({"wheel", rubber, placed({x, 1.075 * y, 0.4}, Vector3d::UnitX(), pi / 2.0), wheel});
  }
  return parts;
}

constexpr std::array<std::string_view, 9> kShapes{"sphere", "plane", "box",   "cylinder", "torus",
                                                  "step",   "shell", "table", "truck"};

Parts parts_of(std::string_view name) {
  if (name == "sphere") return single(name, make_sphere(0.15));
  if (name == "plane") return single(name, make_rectangle(0.4, 0.4));
  if (name == "box") return single(name, make_box({0.3, 0.2, 0.16}));
  if (name == "cylinder") return single(name, make_cylinder(0.1, 0.3));
  if (name == "torus") return single(name, make_torus(0.12, 0.05));
  if (name == "step") return step_parts();
  if (name == "shell") return single(name, make_dome(0.15));
  if (name == "table") return table_parts();
  if (name == "truck") return truck_parts();
  throw Error("there is no shape '{}'; use one of: {}", name, fmt::join(kShapes, ", "));
}

/// `options.spacing` or the default, checked with everything else.
double checked_spacing(const AnalyticSurface& surface, const ProceduralOptions& options) {
  const double spacing = options.spacing.value_or(surface.default_spacing());
  if (!(spacing > 0.0 && std::isfinite(spacing)))
    throw Error("spacing {} m: must be positive and finite", spacing);
  if (!(options.noise >= 0.0 && std::isfinite(options.noise)))
    throw Error("noise {} m: must be finite and not negative", options.noise);
  if (!(options.tilt >= 0.0 && std::isfinite(options.tilt)))
    throw Error("tilt {} rad: must be finite and not negative", options.tilt);
  const double count = surface.area() / spacing / spacing;
  if (!(count <= static_cast<double>(kMaxProceduralGaussians))) {
    throw Error(
        "spacing {} m: shape '{}' would need about {:.3g} Gaussians, more than {}; use {:.2g} m or more",
        spacing, surface.name(), count, kMaxProceduralGaussians,
        1.01 * std::sqrt(surface.area() / static_cast<double>(kMaxProceduralGaussians)));
  }
  return spacing;
}

/// The rotation of a splat on `sample`: turned at random in its plane, then tilted.
Eigen::Quaterniond splat_rotation(const SurfaceSample& sample, double tilt, Random& random) {
  Eigen::Matrix3d R;
  R << sample.tangent, sample.normal.cross(sample.tangent), sample.normal;
  const double turn = random.uniform(0.0, 2.0 * pi);
  const double tilt_about = random.uniform(0.0, 2.0 * pi);
  const Vector3d tilt_axis(std::cos(tilt_about), std::sin(tilt_about), 0.0);
  const double tilt_angle = tilt * random.normal();
  return Eigen::Quaterniond(R) * Eigen::AngleAxisd(tilt_angle, tilt_axis) *
         Eigen::AngleAxisd(turn, Vector3d::UnitZ());
}

void append_splat(const SurfaceSample& sample, const Color& color, const ProceduralOptions& options,
                  Random& random, GaussianScene& scene) {
  const Vector3d position = sample.point + options.noise * random.normal() * sample.normal;
  const Eigen::Quaterniond q = splat_rotation(sample, options.tilt, random).normalized();
  const auto tangent_sigma = [&] {
    return kTangentSigma * sample.spacing * random.uniform(1.0 - kTangentVariation, 1.0 + kTangentVariation);
  };
  const double sigma_x = tangent_sigma();
  const double sigma_y = tangent_sigma();
  const Vector3d sigma(sigma_x, sigma_y, kNormalSigma * sample.spacing);
  const double alpha = random.uniform(kOpacityMin, kOpacityMax);
  scene.append({position, q, sigma, alpha}, color);
}

}  // namespace

AnalyticSurface::AnalyticSurface(std::string name, double default_spacing, std::vector<SurfacePart> parts)
    : name_(std::move(name)), default_spacing_(default_spacing), parts_(std::move(parts)) {}

bool AnalyticSurface::closed() const {
  return std::ranges::all_of(parts_, [](const SurfacePart& part) { return part.shape->closed(); });
}

double AnalyticSurface::area() const {
  double sum = 0.0;
  for (const SurfacePart& part : parts_) sum += part.shape->area();
  return sum;
}

NearestPoint AnalyticSurface::project(const Vector3d& p) const {
  NearestPoint best{p, Vector3d::UnitZ(), std::numeric_limits<double>::infinity()};
  for (const SurfacePart& part : parts_) {
    const NearestPoint local = part.shape->nearest(to_local(part.pose, p));
    if (local.distance < best.distance)
      best = {to_world(part.pose, local.point), part.pose.orientation * local.normal, local.distance};
  }
  return best;
}

std::vector<PartSample> AnalyticSurface::samples(double spacing, Random& random) const {
  std::vector<PartSample> kept;
  std::vector<SurfaceSample> of_part;
  for (std::size_t i = 0; i < parts_.size(); ++i) {
    const Pose& pose = parts_[i].pose;
    of_part.clear();
    parts_[i].shape->sample(spacing, random, of_part);
    for (const SurfaceSample& local : of_part) {
      const SurfaceSample s{to_world(pose, local.point), pose.orientation * local.normal,
                            pose.orientation * local.tangent, local.spacing};
      const auto covers = [&](const SurfacePart& other) {
        return &other != &parts_[i] && part_distance(other, s.point) <= kTouching;
      };
      if (std::ranges::none_of(parts_, covers)) kept.push_back({s, i});
    }
  }
  return kept;
}

std::span<const std::string_view> procedural_shapes() { return kShapes; }

std::unique_ptr<AnalyticSurface> make_surface(std::string_view name) {
  Parts parts = parts_of(name);
  const double spacing = name == "table" ? kTableSpacing : name == "truck" ? kTruckSpacing : kDefaultSpacing;
  return std::make_unique<AnalyticSurface>(std::string(name), spacing, std::move(parts));
}

GaussianScene make_scene(const AnalyticSurface& surface, const ProceduralOptions& options) {
  const double spacing = checked_spacing(surface, options);
  Random random(options.seed);
  const std::vector<PartSample> samples = surface.samples(spacing, random);
  GaussianScene scene;
  scene.source = fmt::format("shape {}, spacing {} m, noise {} m, tilt {} rad, seed {}", surface.name(),
                             spacing, options.noise, options.tilt, options.seed);
  scene.format = "procedural";
  scene.reserve(samples.size());
  for (const PartSample& s : samples)
    append_splat(s.sample, surface.parts()[s.part].color, options, random, scene);
  return scene;
}

}  // namespace palpate
