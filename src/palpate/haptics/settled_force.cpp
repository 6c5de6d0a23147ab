#include <palpate/haptics/settled_force.h>

namespace palpate {
namespace {

constexpr double kStep = 1e-3;           // s
constexpr double kSettledWithin = 1e-9;  // N and N m: numerical noise of a proxy at rest is 1e-14
// In a captured scene, what waited for its first force did not pause for longer than 14 steps after that.
constexpr int kQuietSteps = 50;
// Where fits to noisy splats alternate, the force fluctuates for ever, by some hundredths of a newton.
constexpr int kMostSteps = 300;

bool equal_within(const Wrench& a, const Wrench& b, double tolerance) {
  return (a.force - b.force).cwiseAbs().maxCoeff() <= tolerance &&
         (a.torque - b.torque).cwiseAbs().maxCoeff() <= tolerance;
}

}  // namespace

ForceOutput settled_force(ForceModel& model, const Pose& tool, const ContactSet& contacts) {
  model.reset();
  ForceOutput felt = model.evaluate({tool, {}, 0.0, &contacts});
  int quiet = 0;
  for (int step = 1; step < kMostSteps && quiet < kQuietSteps; ++step) {
    const Wrench before = felt.wrench;
    felt = model.evaluate({tool, {}, kStep, &contacts});
    quiet = felt.is_known && equal_within(felt.wrench, before, kSettledWithin) ? quiet + 1 : 0;
  }
  return felt;
}

}  // namespace palpate
