#include <palpate/gateway/diagnostics.h>

#include <cmath>

#include <fmt/format.h>

namespace palpate {
namespace {

constexpr double kMilli = 1e3, kMicro = 1e6;

/// Level of diagnostic_msgs/DiagnosticStatus: a fault that clears by itself is a warning.
int level_of(const TickRecord& tick) {
  if (tick.fault == Fault::kNone) return 0;
  return traits(tick.fault).latched ? 2 : 1;
}

}  // namespace

void RateWatch::update(double now) {
  constexpr double kLeast = 1.0;  // s
  if (now - at_ < kLeast && rate_ > 0.0) return;
  times_.next();
  const std::uint64_t ticks = statistics_.ticks.load(std::memory_order_relaxed);
  rate_ = static_cast<double>(ticks - ticks_) / (now - at_);
  ticks_ = ticks;
  at_ = now;
}

LiveDiagnostics diagnose(const TickRecord& tick, const TickTimes& times, const RateWatch& watch,
                         const DiagnosticContext& context) {
  LiveDiagnostics result;
  result.level = level_of(tick);
  result.message = tick.fault == Fault::kNone ? to_string(tick.state) : traits(tick.fault).name;
  const auto text = [&](std::string_view key, std::string_view value) {
    result.values.emplace_back(key, value);
  };
  const auto number = [&](std::string_view key, double value) { text(key, fmt::format("{:.6g}", value)); };
  text("state", to_string(tick.state));
  text("fault", tick.fault == Fault::kNone ? "" : traits(tick.fault).name);
  text("advice", tick.fault == Fault::kNone ? "" : traits(tick.fault).advice);
  text("held_by", context.held ? "client" : "");
  number("rate_hz", watch.rate());
  number("tick_us", kMicro * times.whole);
  number("tick_mean_us", kMicro * watch.times().mean());
  number("tick_p50_us", kMicro * watch.times().quantile(0.5));
  number("tick_p99_us", kMicro * watch.times().quantile(0.99));
  number("age_us", kMicro * times.age);
  number("overruns", static_cast<double>(times.overruns));
  number("contacts", static_cast<double>(tick.contacts));
  number("candidates", static_cast<double>(tick.candidates));
  number("k_max", tick.k_max);
  number("force_n", tick.sent.force.norm());
  number("torque_nm", tick.sent.torque.norm());
  number("margin", tick.margin);
  number("energy_mj", kMilli * tick.energy);
  number("stored_mj", std::isnan(tick.felt.stored_energy) ? 0.0 : kMilli * tick.felt.stored_energy);
  number("port_energy_mj", kMilli * tick.port_energy);
  number("damping", tick.added_damping);
  number("clients", static_cast<double>(context.clients));
  return result;
}

}  // namespace palpate
