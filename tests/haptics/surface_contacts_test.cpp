// The sums of the surface fit: against plain double arithmetic, on every instruction set.

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include <palpate/collision/simd_target.h>
#include <palpate/haptics/surface_contacts.h>
#include <support/random_pairs.h>

namespace palpate {
namespace {

using Eigen::Vector3d;
using test::Random;

double smooth_step(double x) {
  const double t = std::clamp(x, 0.0, 1.0);
  return t * t * (3.0 - 2.0 * t);
}
double kernel(double squared) { return std::pow(std::max(0.0, 1.0 - squared / 10.0), 3); }

/// What surface_moments() is said to be.
std::array<double, 17> moments_by_definition(const std::vector<Contact>& contacts, const Ellipsoid& larger,
                                             const SurfaceKernel& kernel_of, const Vector3d& origin,
                                             const Vector3d& u, const Vector3d& v, const Vector3d& n) {
  std::array<double, 17> sums{};
  for (const Contact& c : contacts) {
    const double same = smooth_step((c.normal.dot(n) - 0.2) / 0.4);
    const double h = c.depth - larger.support(c.normal) - c.normal.dot(c.center - larger.center);
    const double thick = h / kernel_of.detail;
    const Vector3d point =
        c.point + (h - c.normal.dot(c.point - c.center)) * thick * thick / (1.0 + thick * thick) * c.normal;
    const Vector3d p = (point - larger.center) / kernel_of.detail - origin;
    const double x = p.dot(u), y = p.dot(v), z = p.dot(n), r = x * x + y * y;
    const double trust = 1.0 / (1.0 + std::pow(h / kernel_of.thickness, 4));
    const double w = c.opacity * smooth_step(c.k_min / 0.3) * trust * same * kernel(r);
    const double b[] = {1.0, x, y, r};
    std::size_t k = 0;
    for (int i = 0; i < 4; ++i)
      for (int j = i; j < 4; ++j) sums[k++] += w * b[i] * b[j];
    for (const double bi : b) sums[k++] += w * bi * z;
    sums[14] = std::max(sums[14], w);
    const double s2 = 0.5 * (c.extent * c.extent - h * h) / (kernel_of.detail * kernel_of.detail);
    const Vector3d q = (c.center - larger.center) / kernel_of.detail - origin;
    const double away = q.dot(u) * q.dot(u) + q.dot(v) * q.dot(v);
    const double covers = trust * s2 / (1.0 + s2) * same * kernel(away / (1.0 + s2));
    sums[15] += covers;
    sums[16] += covers * c.opacity;
  }
  return sums;
}

TEST(SurfaceContacts, SumsAreThoseOfTheDefinitionOnEveryInstructionSet) {
  Random random(941);
  const SurfaceKernel kernel_of = SurfaceKernel::for_tool(0.02, 0.012, 0.004);
  const Ellipsoid larger =
      Ellipsoid::from_semi_axes({{1.0, -2.0, 3.0}, random.rotation()}, {0.03, 0.035, 0.05});
  SurfaceContacts surface(16);  // grows
  for (const std::size_t size : {0U, 1U, 15U, 16U, 17U, 100U, 333U}) {
    std::vector<Contact> contacts;
    for (std::size_t i = 0; i < size; ++i) {
      Contact c;
      c.normal = (Vector3d::UnitZ() + 0.7 * random.direction()).normalized();
      c.center = larger.center + Vector3d(random.in_box(0.03));
      c.point = c.center + Vector3d(random.in_box(0.005));
      c.k_min = random.uniform(0.0, 1.0);
      c.opacity = random.uniform(0.1, 1.0);
      const double h = random.uniform(0.0, 0.02);
      c.depth = h + larger.support(c.normal) + c.normal.dot(c.center - larger.center);
      c.extent = h + random.uniform(0.001, 0.02);
      contacts.push_back(c);
    }
    const Vector3d origin = random.in_box(0.5),
                   n = (Vector3d::UnitZ() + 0.2 * random.direction()).normalized();
    const Vector3d u = n.unitOrthogonal(), v = n.cross(u);
    const auto expected = moments_by_definition(contacts, larger, kernel_of, origin, u, v, n);
    for (const std::string& target : simd_targets()) {
      use_simd_target(target);
      surface.assign(contacts, larger, kernel_of);
      const SurfaceMoments m =
          surface_moments(surface, {origin.cast<float>(), u.cast<float>(), v.cast<float>(), n.cast<float>()});
      std::vector<float> found(m.normal_matrix.begin(), m.normal_matrix.end());
      found.insert(found.end(), m.right.begin(), m.right.end());
      found.insert(found.end(), {m.heaviest, m.layers, m.opacity});
      const double size_of_all = 1.0 + static_cast<double>(size);
      for (std::size_t k = 0; k < expected.size(); ++k)
        EXPECT_NEAR(static_cast<double>(found[k]), expected[k], 2e-4 * size_of_all)
            << target << ", sum " << k;
      for (std::size_t i = 0; i < size; ++i) {
        EXPECT_NEAR(static_cast<double>(surface.lane(SurfaceContacts::kExplained)[i]),
                    smooth_step((contacts[i].normal.dot(n) - 0.2) / 0.4), 1e-5);
      }
    }
    use_simd_target("");
  }
}

}  // namespace
}  // namespace palpate
