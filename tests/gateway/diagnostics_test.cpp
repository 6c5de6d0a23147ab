// What a loop says of itself, against numbers that were put into it.
#include <palpate/gateway/diagnostics.h>

#include <cstdlib>
#include <limits>
#include <map>
#include <string>

#include <gtest/gtest.h>

namespace palpate {
namespace {

std::map<std::string, std::string> values_of(const LiveDiagnostics& diagnostics) {
  std::map<std::string, std::string> values;
  for (const auto& [key, value] : diagnostics.values)
    EXPECT_TRUE(values.emplace(key, value).second) << key << " is there twice";
  return values;
}

double number(const std::map<std::string, std::string>& values, const char* key) {
  return std::strtod(values.at(key).c_str(), nullptr);
}

TEST(RateWatch, IsOfTheLastSecond) {
  LoopStatistics statistics;
  RateWatch watch(statistics);
  EXPECT_EQ(watch.rate(), 0.0);
  statistics.ticks = 500;
  for (int k = 0; k < 500; ++k) statistics.whole.add(1e-4);
  watch.update(0.5);
  EXPECT_EQ(watch.rate(), 1000.0) << "the first look need not wait for a second";
  EXPECT_EQ(watch.times().count(), 500U);
  statistics.ticks = 1300;
  for (int k = 0; k < 800; ++k) statistics.whole.add(2e-4);
  watch.update(1.4);
  EXPECT_EQ(watch.rate(), 1000.0) << "it has not passed";
  EXPECT_EQ(watch.times().count(), 500U);
  statistics.ticks = 1600;
  watch.update(2.5);
  EXPECT_EQ(watch.rate(), 550.0) << "1100 ticks in 2 s";
  EXPECT_EQ(watch.times().count(), 800U);
  EXPECT_NEAR(watch.times().quantile(0.5), 2e-4, 0.05 * 2e-4);
  statistics.ticks = 3600;
  watch.update(3.5);
  EXPECT_EQ(watch.rate(), 2000.0);
}

TEST(Diagnostics, AreInTheUnitsThatTheyAreCalledBy) {
  LoopStatistics statistics;
  statistics.ticks = 100;
  for (int k = 0; k < 55; ++k) statistics.whole.add(1e-4);
  for (int k = 0; k < 43; ++k) statistics.whole.add(2e-4);
  for (int k = 0; k < 2; ++k) statistics.whole.add(1e-3);
  RateWatch watch(statistics);
  watch.update(0.1);
  TickRecord tick;
  tick.state = GovernorState::kActive;
  tick.contacts = 7;
  tick.candidates = 40;
  tick.k_max = 0.25;
  tick.sent = {{3.0, 0.0, -4.0}, {0.0, 0.12, 0.05}};
  tick.margin = 1.5;
  tick.energy = 0.002;
  tick.felt.stored_energy = 0.003;
  tick.port_energy = 0.004;
  tick.added_damping = 0.6;
  TickTimes times;
  times.whole = 2e-4;
  times.age = 3e-4;
  times.overruns = 5;
  const LiveDiagnostics fine = diagnose(tick, times, watch, {true, 3});
  EXPECT_EQ(fine.level, 0);
  EXPECT_EQ(fine.message, to_string(GovernorState::kActive));
  const auto values = values_of(fine);
  EXPECT_EQ(values.at("state"), to_string(GovernorState::kActive));
  EXPECT_EQ(values.at("fault"), "");
  EXPECT_EQ(values.at("advice"), "");
  EXPECT_EQ(values.at("held_by"), "client");
  for (const auto& [key, expected] : std::map<std::string, double>{{"rate_hz", 1000.0},
                                                                   {"tick_us", 200.0},
                                                                   {"age_us", 300.0},
                                                                   {"overruns", 5.0},
                                                                   {"contacts", 7.0},
                                                                   {"candidates", 40.0},
                                                                   {"k_max", 0.25},
                                                                   {"force_n", 5.0},
                                                                   {"torque_nm", 0.13},
                                                                   {"margin", 1.5},
                                                                   {"energy_mj", 2.0},
                                                                   {"stored_mj", 3.0},
                                                                   {"port_energy_mj", 4.0},
                                                                   {"damping", 0.6},
                                                                   {"clients", 3.0}})
    EXPECT_DOUBLE_EQ(number(values, key.c_str()), expected) << key;
  EXPECT_NEAR(number(values, "tick_mean_us"), 161.0, 0.05 * 161.0);
  EXPECT_NEAR(number(values, "tick_p50_us"), 100.0, 0.05 * 100.0);
  EXPECT_NEAR(number(values, "tick_p99_us"), 1000.0, 0.05 * 1000.0);
}

TEST(Diagnostics, SayWhatIsWrongAndWhetherItPasses) {
  const LoopStatistics statistics;
  const RateWatch watch(statistics);
  bool passes = false, stays = false;
  for (const Fault fault : {Fault::kStalePose, Fault::kPaused, Fault::kBadForce, Fault::kEmergencyStop}) {
    TickRecord tick;
    tick.state = GovernorState::kStopped;
    tick.fault = fault;
    tick.felt.stored_energy = std::numeric_limits<double>::quiet_NaN();
    const LiveDiagnostics held_back = diagnose(tick, {}, watch, {});
    EXPECT_EQ(held_back.level, traits(fault).latched ? 2 : 1);
    EXPECT_EQ(held_back.message, traits(fault).name);
    const auto values = values_of(held_back);
    EXPECT_EQ(values.at("fault"), traits(fault).name);
    EXPECT_EQ(values.at("advice"), traits(fault).advice);
    EXPECT_EQ(values.at("held_by"), "");
    EXPECT_EQ(values.at("stored_mj"), "0") << "of a model without a potential";
    (traits(fault).latched ? stays : passes) = true;
  }
  EXPECT_TRUE(passes && stays);
}

}  // namespace
}  // namespace palpate
