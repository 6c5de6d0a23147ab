#include <palpate/report/stability_table.h>

#include <algorithm>
#include <iterator>

#include <fmt/format.h>

namespace palpate {
namespace {

bool same_row(const StabilityRow& a, const StabilityRow& b) {
  return a.profile == b.profile && a.model == b.model && a.source == b.source && a.delay == b.delay;
}

double delay_if(const StabilityRow& row, ContactSource source) {
  return row.source == source ? kMilli * row.delay : 0.0;
}

OrderedJson or_null(const std::optional<double>& value) {
  return value ? OrderedJson(*value) : OrderedJson(nullptr);
}

}  // namespace

std::string hand_text(const HandProperties& hand) {
  return fmt::format("{:g} kg, {:g} N s/m, {:g} N/m", hand.mass, hand.damping, hand.stiffness);
}

std::vector<StabilitySummary> summarize(const std::vector<StabilityRow>& rows) {
  std::vector<StabilitySummary> all;
  for (const StabilityRow& row : rows) {
    auto s = std::find_if(all.begin(), all.end(),
                          [&](const StabilitySummary& x) { return same_row(*x.any, row); });
    if (s == all.end()) s = all.insert(all.end(), StabilitySummary{&row, 0.0, 0.0, 0.0, 0, {}, {}});
    s->limit_cycle = std::max(s->limit_cycle, row.limit_cycle);
    s->port_energy = std::max(s->port_energy, row.port_energy);
    s->force_off = std::max(s->force_off, row.force_off);
    s->contact_changes = std::max(s->contact_changes, row.contact_changes);
    if (!row.z_width) continue;
    s->z_low = std::min(s->z_low.value_or(*row.z_width), *row.z_width);
    s->z_high = std::max(s->z_high.value_or(*row.z_width), *row.z_width);
  }
  return all;
}

OrderedJson stability_json(const StabilityTables& tables) {
  OrderedJson json = OrderedJson::array();
  for (const StabilityRow& row : tables.rows) {
    json.push_back({{"profile", row.profile},
                    {"hand", {row.hand.mass, row.hand.damping, row.hand.stiffness}},
                    {"model", row.model},
                    {"hold_ms", delay_if(row, ContactSource::kHold)},
                    {"worker_ms", delay_if(row, ContactSource::kWorker)},
                    {"limit_cycle_mm", kMilli * row.limit_cycle},
                    {"port_energy_mj", kMilli * row.port_energy},
                    {"contact_changes", row.contact_changes},
                    {"rest_force", row.rest_force},
                    {"slide_force_off", row.force_off},
                    {"fault", traits(row.fault).name},
                    {"z_width", or_null(row.z_width)}});
  }
  for (const WallRow& wall : tables.walls) {
    json.push_back({{"profile", wall.profile},
                    {"hand", nullptr},
                    {"model", "wall"},
                    {"passivity", wall.passivity},
                    {"z_width", wall.z_width},
                    {"z_width_bound", wall.bound}});
  }
  return json;
}

std::string stability_csv(const StabilityTables& tables) {
  std::string csv =
      "profile,hand_mass,hand_damping,hand_stiffness,model,contacts,delay_ms,limit_cycle_mm,port_energy_mj,"
      "contact_changes,rest_force_n,slide_force_off,fault,z_width_n_m\n";
  for (const StabilityRow& r : tables.rows) {
    fmt::format_to(std::back_inserter(csv), "{},{},{},{},{},{},{},{},{},{},{},{},{},{}\n", r.profile,
                   r.hand.mass, r.hand.damping, r.hand.stiffness, r.model, to_string(r.source),
                   kMilli * r.delay, kMilli * r.limit_cycle, kMilli * r.port_energy, r.contact_changes,
                   r.rest_force, r.force_off, traits(r.fault).name,
                   r.z_width ? fmt::format("{}", *r.z_width) : "");
  }
  return csv;
}

std::string stability_text(const StabilityTables& tables) {
  std::string text = fmt::format("{:<9} {:<8} {:<13} {:>12} {:>11} {:>8} {:>10} {:>15}\n", "profile", "model",
                                 "contacts", "cycle mm", "energy mJ", "changes", "deviation", "Z-width N/m");
  for (const StabilitySummary& s : summarize(tables.rows)) {
    const StabilityRow& row = *s.any;
    const std::string source = row.source == ContactSource::kLoop
                                   ? "loop"
                                   : fmt::format("{} {:g} ms", to_string(row.source), kMilli * row.delay);
    const std::string width = s.z_low ? fmt::format("{:.0f} - {:.0f}", *s.z_low, *s.z_high) : "-";
    fmt::format_to(std::back_inserter(text),
                   "{:<9} {:<8} {:<13} {:>12.4f} {:>11.4f} {:>8} {:>9.1f}% {:>15}\n", row.profile, row.model,
                   source, kMilli * s.limit_cycle, kMilli * s.port_energy, s.contact_changes,
                   100.0 * s.force_off, width);
  }
  if (tables.walls.empty()) return text;
  text += fmt::format("\n{:<9} {:<10} {:>14} {:>11} {:>7}\n", "wall on", "passivity", "Z-width N/m",
                      "in theory", "ratio");
  for (const WallRow& wall : tables.walls) {
    fmt::format_to(std::back_inserter(text), "{:<9} {:<10} {:>14.0f} {:>11.0f} {:>7.3f}\n", wall.profile,
                   wall.passivity ? "controlled" : "observed", wall.z_width, wall.bound,
                   wall.z_width / wall.bound);
  }
  return text;
}

}  // namespace palpate
