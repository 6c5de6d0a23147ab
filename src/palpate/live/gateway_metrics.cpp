#include <palpate/live/gateway_metrics.h>

#include <array>
#include <string_view>

#include <fmt/format.h>

namespace palpate {
namespace {

struct Metric {
  std::string_view name, type, help;
  double (*value)(const MetricsOfHand& hand);
};

constexpr std::array kCounters{
    Metric{"ticks_total", "counter", "Number of ticks of the servo loop.",
           [](const MetricsOfHand& h) { return static_cast<double>(h.statistics.ticks.load()); }},
    Metric{"overruns_total", "counter", "Number of ticks that were skipped.",
           [](const MetricsOfHand& h) { return static_cast<double>(h.statistics.overruns.load()); }},
};

constexpr std::array kGauges{
    Metric{"force_newtons", "gauge", "Magnitude of the force sent to the device.",
           [](const MetricsOfHand& h) { return h.tick.record.sent.force.norm(); }},
    Metric{"torque_newton_metres", "gauge", "Magnitude of the torque sent to the device.",
           [](const MetricsOfHand& h) { return h.tick.record.sent.torque.norm(); }},
    Metric{"contacts", "gauge", "Number of Gaussians in contact with the tool.",
           [](const MetricsOfHand& h) { return static_cast<double>(h.tick.record.contacts); }},
    Metric{"stiffness_margin", "gauge", "Largest passive stiffness over set stiffness; 0 if unknown.",
           [](const MetricsOfHand& h) { return h.tick.record.margin; }},
    Metric{"port_energy_joules", "gauge", "Net energy put into the hand.",
           [](const MetricsOfHand& h) { return h.tick.record.energy; }},
    Metric{"force_age_seconds", "gauge", "Age of the device reading when its force is sent.",
           [](const MetricsOfHand& h) { return h.tick.times.age; }},
    Metric{"active", "gauge", "1 while the safety governor passes the full force, else 0.",
           [](const MetricsOfHand& h) { return h.tick.record.state == GovernorState::kActive ? 1.0 : 0.0; }},
};

std::string head(std::string_view name, std::string_view type, std::string_view help) {
  return fmt::format("# HELP palpate_{0} {2}\n# TYPE palpate_{0} {1}\n", name, type, help);
}

/// Returns labels such as {hand="left",quantile="0.5"}; either may be missing.
std::string labels(const std::string& hand, const std::string& more = {}) {
  const std::string of_hand = hand.empty() ? "" : fmt::format("hand=\"{}\"", hand);
  const std::string all = of_hand + (!of_hand.empty() && !more.empty() ? "," : "") + more;
  return all.empty() ? all : "{" + all + "}";
}

std::string family(const Metric& metric, std::span<const MetricsOfHand> hands) {
  std::string text = head(metric.name, metric.type, metric.help);
  for (const MetricsOfHand& hand : hands)
    text += fmt::format("palpate_{}{} {}\n", metric.name, labels(hand.hand), metric.value(hand));
  return text;
}

std::string tick_summary(std::span<const MetricsOfHand> hands) {
  std::string text = head("tick_seconds", "summary", "Duration of a tick of the servo loop.");
  for (const auto& [hand, tick, statistics] : hands) {
    for (const double q : {0.5, 0.99, 0.999})
      text += fmt::format("palpate_tick_seconds{} {}\n", labels(hand, fmt::format("quantile=\"{}\"", q)),
                          statistics.whole.quantile(q));
    text += fmt::format("palpate_tick_seconds_count{} {}\n", labels(hand), statistics.ticks.load());
  }
  return text;
}

}  // namespace

std::string metrics_text(std::span<const MetricsOfHand> hands, std::size_t clients) {
  std::string text;
  for (const Metric& counter : kCounters) text += family(counter, hands);
  text += tick_summary(hands);
  for (const Metric& gauge : kGauges) text += family(gauge, hands);
  return text + head("clients", "gauge", "Number of connected WebSocket clients.") +
         fmt::format("palpate_clients {}", clients);
}

}  // namespace palpate
