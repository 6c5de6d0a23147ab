// What docs/safety.md says of each fault.
#include <palpate/servo/fault.h>

#include <set>
#include <string_view>

#include <gtest/gtest.h>

namespace palpate {
namespace {

struct Said {
  Fault fault;
  std::string_view name;
  double zero_within;  ///< Unit: [s].
  bool until_resume;
  bool on_request = false;
};

constexpr Said kSaid[] = {
    {Fault::kBadPose, "bad-pose", 0.03, false},
    {Fault::kStalePose, "stale-pose", 0.03, false},
    {Fault::kFrozenPose, "frozen-pose", 0.1, false},
    {Fault::kJump, "jump", 0.03, false},
    {Fault::kOverSpeed, "over-speed", 0.1, false},
    {Fault::kBadForce, "bad-force", 0.03, true},
    {Fault::kLateContacts, "late-contacts", 0.1, false},
    {Fault::kOverEnergy, "over-energy", 0.03, true},
    {Fault::kSlowDevice, "slow-device", 0.1, false},
    {Fault::kChanging, "changing", 0.1, false},
    {Fault::kPaused, "paused", 0.1, true, true},
    {Fault::kRecorder, "recorder", 0.1, true},
    {Fault::kEmergencyStop, "emergency-stop", 0.03, true},
    {Fault::kLateTick, "late-tick", 0.03, false},
    {Fault::kCrowded, "crowded", 0.1, false},
    {Fault::kStalled, "stalled", 0.0, false},
    {Fault::kForceSensor, "force-sensor", 0.03, false},
    {Fault::kNotFollowing, "not-following", 0.03, true},
    {Fault::kEnded, "ended", 0.1, true, true},
};

TEST(Faults, AreAsTheSafetyPageSays) {
  std::set<Fault> told{Fault::kNone};
  for (const Said& said : kSaid) {
    const FaultTraits& found = traits(said.fault);
    EXPECT_EQ(found.name, said.name);
    EXPECT_EQ(found.fall_time, said.zero_within) << said.name;
    EXPECT_EQ(found.latched, said.until_resume) << said.name;
    EXPECT_EQ(found.requested, said.on_request) << said.name;
    EXPECT_FALSE(found.advice.empty()) << said.name;
    told.insert(said.fault);
  }
  EXPECT_EQ(told.size(), kFaultCount);
}

}  // namespace
}  // namespace palpate
