#include <palpate/servo/fault.h>

#include <array>

namespace palpate {
namespace {

/// A force that vanishes at once makes a hand that leans on it fall; 0.1 s is shorter than a reaction and
/// long enough to brake. Forces that can be trusted least end sooner.
constexpr double kGently = 0.1, kSoon = 0.03;

constexpr std::array<FaultTraits, kFaultCount> kTraits{{
    {"none", "", 0.0, false},
    {"bad-pose", "the device sends invalid poses; check its driver", kSoon, false},
    {"stale-pose", "the device has stopped responding; check its cable and driver", kSoon, false},
    {"frozen-pose", "the device's readings do not change; check its encoders", kGently, false},
    {"jump", "the tool jumped; check the device's calibration", kSoon, false},
    {"over-speed", "the tool was let go or thrown; hold it and wait", kGently, false},
    {"bad-force", "the force model failed; report it with the run's recording", kSoon, true},
    {"late-contacts", "the machine is too slow or too busy for this scene; close other programs", kGently,
     false},
    {"over-energy", "the contact produced net energy; lower the stiffness, or reduce the loop's delay", kSoon,
     true},
    {"slow-device", "the device responds at less than half its rate; check its connection", kGently, false},
    {"changing", "release the clutch if it is pressed, and lift the tool; the force then returns", kGently,
     false},
    {"paused", "resume when ready", kGently, true, true},
    {"recorder", "the recording failed: its disk is full, or its file was removed; start again", kGently,
     true},
    {"emergency-stop", "resume when it is safe", kSoon, true},
    {"late-tick", "a tick was late; permit real-time priority, or close other programs", kSoon, false},
    {"crowded", "the tool touches too many Gaussians for this model; use a smaller tool, or the proxy model",
     kGently, false},
    {"stalled", "the loop stalled and the device was stopped; close other programs, or report it", 0.0,
     false},
    {"force-sensor",
     "the force sensor's readings are implausible; check its cable, and release the handle to tare it", kSoon,
     false},
    {"not-following", "the device does not follow its setpoint; remove what blocks it, and check its drives",
     kSoon, true},
    {"ended", "start again when ready", kGently, true, true},
}};

}  // namespace

const FaultTraits& traits(Fault fault) { return kTraits[static_cast<std::size_t>(fault)]; }

}  // namespace palpate
