/// \file
/// The simplest of force models.
#pragma once

#include <algorithm>

#include <palpate/haptics/force_model.h>

namespace palpate::test {

/// A wall at x = 0 of the world, felt for x < 0.
struct Wall final : ForceModel {
  explicit Wall(double stiffness) : k(stiffness) {}
  bool wants_contacts() const override { return false; }
  void reset() override {}
  ForceOutput evaluate(const ForceInput& input) override {
    const double depth = std::max(0.0, -input.tool.position.x());
    ForceOutput out;
    out.wrench.force.x() = k * depth;
    out.proxy = input.tool;
    out.stored_energy = 0.5 * k * depth * depth;
    out.stiffness = depth > 0.0 ? k : 0.0;
    out.local.planes[0] = {Eigen::Vector3d::Zero(), Eigen::Vector3d::UnitX()};
    out.local.count = 1;
    out.local.stiffness = k;
    return out;
  }
  double k;  ///< Unit: [N/m].
};

}  // namespace palpate::test
