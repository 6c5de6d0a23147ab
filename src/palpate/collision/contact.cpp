#include <palpate/collision/contact.h>

#include <algorithm>
#include <atomic>
#include <limits>

namespace palpate {
namespace {

/// Axis of either solid along which the sum of both is thinnest, for coincident centres. An axis of length
/// zero is derived from the other two.
Eigen::Vector3d thinnest_direction(const Ellipsoid& tool, const Ellipsoid& gaussian) {
  Eigen::Vector3d best = Eigen::Vector3d::UnitZ();
  double least = std::numeric_limits<double>::infinity();
  for (const Ellipsoid* solid : {&gaussian, &tool}) {
    for (int k = 0; k < 3; ++k) {
      Eigen::Vector3d axis = solid->axes.col(k).stableNormalized();
      if (axis.isZero(0.0)) {
        axis = solid->axes.col((k + 1) % 3)
                   .stableNormalized()
                   .cross(solid->axes.col((k + 2) % 3).stableNormalized());
        if (axis.isZero(0.0)) continue;
      }
      const double thickness = tool.support(axis) + gaussian.support(axis);
      if (thickness < least) {
        least = thickness;
        best = axis;
      }
    }
  }
  return best;
}

std::uint64_t next_epoch() {
  static std::atomic<std::uint64_t> last = 0;
  return last.fetch_add(1, std::memory_order_relaxed) + 1;
}

}  // namespace

ContactQuery::ContactQuery() : epoch_(next_epoch()) {}

double ContactSet::k_max() const {
  double largest = 0.0;
  for (const Contact& c : contacts) largest = std::max(largest, c.k_min);
  return largest;
}

void ContactSet::clear() {
  candidates = 0;
  filtered = 0;
  complete = true;
  contacts.clear();
}

Contact make_contact(const WhitenedTool& tool, const Ellipsoid& gaussian, const KFunction& k,
                     const KMinimum& minimum) {
  const Eigen::Vector3d y = solve_whitened(k, minimum.log_t);
  // dK/dc_tool is along -W^T y, hence the outward direction is W^T y.
  const Eigen::Vector3d q = tool.W.transpose() * y;
  Contact contact;
  contact.k_min = minimum.k_min;
  contact.lambda = minimum.lambda;
  contact.center = gaussian.center;
  contact.normal = k.p0 == 0.0 ? thinnest_direction(tool.ellipsoid, gaussian) : q.stableNormalized().eval();
  // m(lambda) = c_tool - (1-lambda) B [ (1-lambda) B + lambda A ]^-1 d = c_tool - W^-1 y, and for a
  // tool with orthogonal axes V, W^-1 = V.
  contact.point = tool.ellipsoid.center - tool.ellipsoid.axes * y;
  contact.depth = tool.ellipsoid.support(contact.normal) + gaussian.support(contact.normal) -
                  contact.normal.dot(tool.ellipsoid.center - gaussian.center);
  contact.extent = gaussian.axes.norm();
  return contact;
}

}  // namespace palpate
