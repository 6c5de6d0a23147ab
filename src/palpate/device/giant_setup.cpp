#include <palpate/device/giant_setup.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace palpate {
namespace {

/// Damping ratio of the virtual mass on the scene's stiffness.
constexpr double kDampingRatio = 0.7;

}  // namespace

SerialChain driven_chain(SerialChain chain, const HandProperties& hand) {
  limit_by_effort(chain, hand.mass);
  return chain;
}

AdmittanceLoopModel loop_of(const GiantSetup& setup) {
  AdmittanceLoopModel loop = loop_model(setup.chain, GiantProperties());
  loop.contact_stiffness = setup.contact_stiffness;
  loop.hand_mass = setup.hand.mass;
  loop.hand_damping = setup.hand.damping;
  loop.hand_stiffness = setup.hand.stiffness;
  return loop;
}

Admittance admittance_of(const GiantSetup& setup) {
  AdmittanceLoopModel loop = loop_of(setup);
  loop.delay += 0.5 * setup.period;
  const double mass = setup.virtual_mass;
  const auto least = [&] {
    return std::max({GiantSetup::kVirtualDamping, least_damping(mass, loop), passive_damping(loop)});
  };
  Admittance admittance;
  admittance.mass.setConstant(mass);
  admittance.damping.setConstant(setup.virtual_damping ? *setup.virtual_damping : least());
  admittance.contact_damping = 2.0 * kDampingRatio * std::sqrt(setup.contact_stiffness * mass);
  return admittance;
}

std::unique_ptr<AdmittanceLoop> make_giant_loop(const GiantSetup& setup, std::unique_ptr<JointPlant> plant,
                                                std::uint64_t seed) {
  AdmittanceLoopOptions options;
  options.period = setup.period;
  options.along = loop_of(setup);
  options.about = loop_model(setup.chain, GiantProperties());
  options.admittance = admittance_of(setup);
  auto device = std::make_unique<GiantDevice>(setup.chain, std::move(plant), GiantProperties(),
                                              rest_of_handle(setup.chain), seed);
  return std::make_unique<AdmittanceLoop>(std::move(device), options);
}

Pose rest_of_handle(const SerialChain& chain) { return JointMotion(chain).tip(); }

Eigen::AlignedBox3d giant_reach() {
  return {Eigen::Vector3d(-2.2, -2.6, 0.85), Eigen::Vector3d(2.2, 2.6, 1.5)};
}

}  // namespace palpate
