// What AdmittanceLoop takes the loop of each axis to be.
#include <palpate/servo/admittance_loop.h>

#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <palpate/base/error.h>

namespace palpate {
namespace {

/// Stiffer about the axes than along them, and both late.
AdmittanceLoopOptions loop() {
  AdmittanceLoopOptions options;
  options.period = 2e-3;
  options.along.contact_stiffness = 2000.0;
  options.along.delay = 3e-3;
  options.about.contact_stiffness = 20.0;
  options.about.delay = 1e-3;
  return options;
}

/// The least damping of a mass in `model`, half a tick later.
double least(double mass, AdmittanceLoopModel model, const AdmittanceLoopOptions& options) {
  model.delay += 0.5 * options.period;
  return least_damping(mass, model, options.margin);
}

// On every axis by itself, the others with twice of what they need.
TEST(AdmittanceLoopCheck, WantsTheLeastDampingOfEachAxisHalfATickLater) {
  const AdmittanceLoopOptions options = loop();
  const double along = least(options.admittance.mass.x(), options.along, options);
  const double about = least(options.admittance.inertia.x(), options.about, options);
  for (Eigen::Index axis = 0; axis < 6; ++axis) {
    for (const double share : {0.98, 1.02}) {
      AdmittanceLoopOptions tried = options;
      tried.admittance.damping.setConstant(2.0 * along);
      tried.admittance.angular_damping.setConstant(2.0 * about);
      (axis < 3 ? tried.admittance.damping[axis] : tried.admittance.angular_damping[axis - 3]) =
          share * (axis < 3 ? along : about);
      const std::string name = std::string(axis < 3 ? "along " : "about ") + "xyz"[axis % 3];
      try {
        AdmittanceLoop::check(tried);
        EXPECT_GT(share, 1.0) << name;
      } catch (const Error& error) {
        EXPECT_LT(share, 1.0) << name;
        EXPECT_THAT(error.what(), testing::HasSubstr(name));
      }
    }
  }
}

TEST(AdmittanceLoopCheck, WithoutAMarginIsNone) {
  AdmittanceLoopOptions options = loop();
  options.admittance.damping.setZero();
  EXPECT_THROW(AdmittanceLoop::check(options), Error);
  options.margin = 0.0;
  EXPECT_NO_THROW(AdmittanceLoop::check(options));
}

}  // namespace
}  // namespace palpate
