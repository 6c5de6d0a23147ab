#include <palpate/study/analytic_shape.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <functional>
#include <numbers>

namespace palpate {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using std::numbers::pi;

/// Largest offset of a sample from the middle of its cell, as a fraction of each side: large enough to break
/// the lattice, small enough that a corner of the cell is within 1.06 cell sides.
constexpr double kJitter = 0.25;

double jitter(Random& random) { return random.uniform(-kJitter, kJitter); }

std::size_t cells_along(double length, double spacing) {
  return static_cast<std::size_t>(std::max(1.0, std::round(length / spacing)));
}

/// Rectangle about `center`, spanned by the unit vectors u and v with sides a and b.
struct Face {
  Vector3d center, u, v;
  double a, b;
};

void sample_face(const Face& face, double spacing, Random& random, std::vector<SurfaceSample>& out) {
  const double h = std::min({spacing, face.a, face.b});
  const std::size_t columns = cells_along(face.a, h);
  const std::size_t rows = cells_along(face.b, h);
  const Vector3d normal = face.u.cross(face.v);
  for (std::size_t row = 0; row < rows; ++row) {
    for (std::size_t column = 0; column < columns; ++column) {
      const double x = (static_cast<double>(column) + 0.5 + jitter(random)) / static_cast<double>(columns);
      const double y = (static_cast<double>(row) + 0.5 + jitter(random)) / static_cast<double>(rows);
      const Vector3d point = face.center + (x - 0.5) * face.a * face.u + (y - 0.5) * face.b * face.v;
      out.push_back({point, normal, face.u, h});
    }
  }
}

/// A point of the profile of a surface of revolution about z, and the outward normal there.
struct ProfilePoint {
  double r, z, normal_r, normal_z;
};

/// A profile as a function of its arc length in [0, length].
struct Profile {
  double length;
  std::function<ProfilePoint(double)> at;
};

Profile line_profile(const Vector2d& from, const Vector2d& to, const Vector2d& normal) {
  const double length = (to - from).norm();
  const Vector2d direction = (to - from) / length;
  return {length, [=](double l) {
            const Vector2d p = from + l * direction;
            return ProfilePoint{p[0], p[1], normal[0], normal[1]};
          }};
}

/// Arc around (center_r, 0) from the angle `begin` to `end`, with normals away from its centre.
Profile arc_profile(double center_r, double radius, double begin, double end) {
  return {radius * (end - begin), [=](double l) {
            const double angle = begin + l / radius;
            const double c = std::cos(angle);
            const double s = std::sin(angle);
            return ProfilePoint{center_r + radius * c, radius * s, c, s};
          }};
}

/// Position in [0, 1] across the ring between the radii r0 and r1 below which `share` of its area is, for a
/// radius linear in between.
double area_quantile(double r0, double r1, double share) {
  const double root = std::sqrt(r0 * r0 + share * (r1 * r1 - r0 * r0));
  return share * (r0 + r1) / (r0 + root);
}

/// Samples rings of equal width in proportion to their areas; the rounding error of the count is carried to
/// the next ring.
void sample_revolution(const Profile& profile, double spacing, Random& random,
                       std::vector<SurfaceSample>& out) {
  const double h = std::min(spacing, profile.length);
  const std::size_t rings = cells_along(profile.length, h);
  const double width = profile.length / static_cast<double>(rings);
  double carry = 0.0;
  for (std::size_t ring = 0; ring < rings; ++ring) {
    const double begin = static_cast<double>(ring) * width;
    const double r0 = std::max(0.0, profile.at(begin).r);
    const double r1 = std::max(0.0, profile.at(begin + width).r);
    const double mean_r = (r0 + 4.0 * profile.at(begin + 0.5 * width).r + r1) / 6.0;  // Simpson's rule
    const double wanted = 2.0 * pi * mean_r * width / (h * h) + carry;
    const auto count = static_cast<std::size_t>(std::max(1.0, std::round(wanted)));
    carry = wanted - static_cast<double>(count);
    const double phase = random.uniform();
    for (std::size_t k = 0; k < count; ++k) {
      const double angle =
          2.0 * pi * (static_cast<double>(k) + phase + jitter(random)) / static_cast<double>(count);
      const ProfilePoint p = profile.at(begin + width * area_quantile(r0, r1, 0.5 + jitter(random)));
      const double c = std::cos(angle);
      const double s = std::sin(angle);
      out.push_back({{p.r * c, p.r * s, p.z}, {p.normal_r * c, p.normal_r * s, p.normal_z}, {-s, c, 0.0}, h});
    }
  }
}

template <int N>
struct NearestInBox {
  Eigen::Vector<double, N> point, normal;
  double distance;
};

/// Finds the nearest boundary point of the box |x_k| <= half_k.
template <int N>
NearestInBox<N> nearest_of_box(const Eigen::Vector<double, N>& p, const Eigen::Vector<double, N>& half) {
  using Vector = Eigen::Vector<double, N>;
  int axis = 0;
  const double excess = (p.cwiseAbs() - half).maxCoeff(&axis);
  if (excess > 0.0) {
    const Vector point = p.cwiseMax(-half).cwiseMin(half);
    const double distance = (p - point).stableNorm();
    return {point, (p - point) / distance, distance};
  }
  Vector point = p;
  point[axis] = std::copysign(half[axis], p[axis]);
  Vector normal = Vector::Zero();
  normal[axis] = std::copysign(1.0, p[axis]);
  return {point, normal, excess};
}

/// The unit vector from the z axis towards p; x on the axis itself. `rho` is the distance.
Vector3d radial_direction(const Vector3d& p, double rho) {
  return rho > 0.0 ? Vector3d(p[0] / rho, p[1] / rho, 0.0) : Vector3d::UnitX();
}

class Sphere final : public AnalyticShape {
 public:
  explicit Sphere(double radius) : radius_(radius) {}
  bool closed() const override { return true; }
  double area() const override { return 4.0 * pi * radius_ * radius_; }

  NearestPoint nearest(const Vector3d& p) const override {
    const double r = p.norm();
    const Vector3d normal = r > 0.0 ? (p / r).eval() : Vector3d::UnitZ();
    return {radius_ * normal, normal, r - radius_};
  }

  void sample(double spacing, Random& random, std::vector<SurfaceSample>& out) const override {
    sample_revolution(arc_profile(0.0, radius_, -pi / 2.0, pi / 2.0), spacing, random, out);
  }

 private:
  double radius_;
};

class Box final : public AnalyticShape {
 public:
  explicit Box(const Vector3d& size) : size_(size) {}
  bool closed() const override { return true; }
  double area() const override {
    return 2.0 * (size_[0] * size_[1] + size_[1] * size_[2] + size_[2] * size_[0]);
  }

  NearestPoint nearest(const Vector3d& p) const override {
    const auto [point, normal, distance] = nearest_of_box<3>(p, 0.5 * size_);
    return {point, normal, distance};
  }

  void sample(double spacing, Random& random, std::vector<SurfaceSample>& out) const override {
    for (int k = 0; k < 3; ++k) {
      const int i = (k + 1) % 3;
      const int j = (k + 2) % 3;
      const Vector3d half = 0.5 * size_[k] * Vector3d::Unit(k);
      sample_face({half, Vector3d::Unit(i), Vector3d::Unit(j), size_[i], size_[j]}, spacing, random, out);
      sample_face({-half, Vector3d::Unit(j), Vector3d::Unit(i), size_[j], size_[i]}, spacing, random, out);
    }
  }

 private:
  Vector3d size_;
};

class Cylinder final : public AnalyticShape {
 public:
  Cylinder(double radius, double height) : radius_(radius), half_height_(0.5 * height) {}
  bool closed() const override { return true; }
  double area() const override { return 2.0 * pi * radius_ * (radius_ + 2.0 * half_height_); }

  NearestPoint nearest(const Vector3d& p) const override {
    const double rho = std::hypot(p[0], p[1]);
    const Vector3d e = radial_direction(p, rho);
    const auto [point, normal, distance] = nearest_of_box<2>({rho, p[2]}, {radius_, half_height_});
    return {point[0] * e + point[1] * Vector3d::UnitZ(), normal[0] * e + normal[1] * Vector3d::UnitZ(),
            distance};
  }

  void sample(double spacing, Random& random, std::vector<SurfaceSample>& out) const override {
    const double z = half_height_;
    sample_revolution(line_profile({radius_, -z}, {radius_, z}, {1.0, 0.0}), spacing, random, out);
    sample_revolution(line_profile({0.0, z}, {radius_, z}, {0.0, 1.0}), spacing, random, out);
    sample_revolution(line_profile({0.0, -z}, {radius_, -z}, {0.0, -1.0}), spacing, random, out);
  }

 private:
  double radius_;
  double half_height_;
};

class Torus final : public AnalyticShape {
 public:
  Torus(double major, double minor) : major_(major), minor_(minor) {}
  bool closed() const override { return true; }
  double area() const override { return 4.0 * pi * pi * major_ * minor_; }

  NearestPoint nearest(const Vector3d& p) const override {
    const Vector3d e = radial_direction(p, std::hypot(p[0], p[1]));
    const Vector3d ring = major_ * e;
    const double r = (p - ring).norm();
    const Vector3d normal = r > 0.0 ? ((p - ring) / r).eval() : e;
    return {ring + minor_ * normal, normal, r - minor_};
  }

  void sample(double spacing, Random& random, std::vector<SurfaceSample>& out) const override {
    sample_revolution(arc_profile(major_, minor_, -pi, pi), spacing, random, out);
  }

 private:
  double major_;
  double minor_;
};

class Rectangle final : public AnalyticShape {
 public:
  Rectangle(double size_x, double size_y) : size_x_(size_x), size_y_(size_y) {}
  bool closed() const override { return false; }
  double area() const override { return size_x_ * size_y_; }

  NearestPoint nearest(const Vector3d& p) const override {
    const Vector3d half(0.5 * size_x_, 0.5 * size_y_, 0.0);
    const Vector3d point = p.cwiseMax(-half).cwiseMin(half);
    return {point, Vector3d::UnitZ(), (p - point).norm()};
  }

  void sample(double spacing, Random& random, std::vector<SurfaceSample>& out) const override {
    sample_face({Vector3d::Zero(), Vector3d::UnitX(), Vector3d::UnitY(), size_x_, size_y_}, spacing, random,
                out);
  }

 private:
  double size_x_;
  double size_y_;
};

class Dome final : public AnalyticShape {
 public:
  explicit Dome(double radius) : radius_(radius) {}
  bool closed() const override { return false; }
  double area() const override { return 2.0 * pi * radius_ * radius_; }

  NearestPoint nearest(const Vector3d& p) const override {
    const double r = p.norm();
    if (p[2] >= 0.0) {
      const Vector3d normal = r > 0.0 ? (p / r).eval() : Vector3d::UnitZ();
      return {radius_ * normal, normal, std::abs(r - radius_)};
    }
    const Vector3d rim = radial_direction(p, std::hypot(p[0], p[1]));  // also the normal at the rim
    return {radius_ * rim, rim, (p - radius_ * rim).norm()};
  }

  void sample(double spacing, Random& random, std::vector<SurfaceSample>& out) const override {
    sample_revolution(arc_profile(0.0, radius_, 0.0, pi / 2.0), spacing, random, out);
  }

 private:
  double radius_;
};

}  // namespace

std::unique_ptr<AnalyticShape> make_sphere(double radius) { return std::make_unique<Sphere>(radius); }
std::unique_ptr<AnalyticShape> make_box(const Vector3d& size) { return std::make_unique<Box>(size); }
std::unique_ptr<AnalyticShape> make_cylinder(double radius, double height) {
  return std::make_unique<Cylinder>(radius, height);
}
std::unique_ptr<AnalyticShape> make_torus(double major, double minor) {
  return std::make_unique<Torus>(major, minor);
}
std::unique_ptr<AnalyticShape> make_rectangle(double size_x, double size_y) {
  return std::make_unique<Rectangle>(size_x, size_y);
}
std::unique_ptr<AnalyticShape> make_dome(double radius) { return std::make_unique<Dome>(radius); }

}  // namespace palpate
