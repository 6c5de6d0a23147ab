#include <palpate/servo/fault.h>

#include <array>

namespace palpate {
namespace {

/// A force that vanishes at once makes a hand that leans on it fall; 0.1 s is shorter than a reaction and
/// long enough to brake. Forces that can be trusted least end sooner.
constexpr double kGently = 0.1, kSoon = 0.03;

constexpr std::array<FaultTraits, kFaultCount> kTraits{{
    {"none", "", 0.0, false},
    {"bad-pose", "the device sends what is no pose; check its driver", kSoon, false},
    {"stale-pose", "the device has stopped answering; check its cable and driver", kSoon, false},
    {"frozen-pose", "the device's readings do not change; check its encoders", kGently, false},
    {"jump", "the tool jumped; check the device's calibration", kSoon, false},
    {"over-speed", "the tool was let go or thrown; hold it and wait", kGently, false},
    {"bad-force", "the force model failed; report it with the run's record", kSoon, true},
    {"late-contacts", "the machine is too slow or too busy for this scene; close other programs", kGently,
     false},
    {"over-energy",
     "more energy came out than went in; lower the stiffness, or make the loop quicker and less late", kSoon,
     true},
    {"slow-device", "the device answers at less than half its rate; check its connection", kGently, false},
    {"changing", "lift the tool; it will feel again", kGently, false},
    {"paused", "resume when you like", kGently, true},
    {"recorder", "the recording failed; free some room on its disk and begin anew", kGently, true},
    {"emergency-stop", "resume when it is safe", kSoon, true},
    {"late-tick", "the loop was held up; permit real-time priority, or close other programs", kSoon, false},
    {"crowded",
     "the tool touches too many Gaussians at once for this model; take a smaller tool, or model proxy",
     kGently, false},
    {"stalled", "the loop stood still and the device was stopped; close other programs, or report it", 0.0,
     false},
    {"force-sensor", "the force sensor cannot be right; check its cable, and let go of the handle to tare it",
     kSoon, false},
    {"not-following", "the device is not where it was sent; see what holds it, and check its drives", kSoon,
     true},
}};

}  // namespace

const FaultTraits& traits(Fault fault) { return kTraits[static_cast<std::size_t>(fault)]; }

}  // namespace palpate
