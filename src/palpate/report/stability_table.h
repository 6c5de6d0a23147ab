/// \file
/// Tables of stability trials, as text, CSV and JSON.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include <palpate/report/ordered_json.h>
#include <palpate/study/stability.h>

namespace palpate {

/// From SI units to those of the tables: ms, mm, mJ.
inline constexpr double kMilli = 1e3;

/// Where the contacts of a trial come from.
enum class ContactSource {
  kLoop,    ///< looked for in the loop
  kWorker,  ///< by a thread that looks ahead, and is late
  kHold,    ///< the force itself is computed by a thread that is late, and held: the paper's
};
std::string_view to_string(ContactSource source);

/// A device, a hand, a model: the worst of all places.
struct StabilityRow {
  std::string profile, model;
  HandProperties hand;
  ContactSource source = ContactSource::kLoop;
  double delay = 0.0;                           ///< of `source`. Unit: [s].
  double limit_cycle = 0.0, port_energy = 0.0;  ///< StabilityOutcome
  int contact_changes = 0;
  double rest_force = 0.0;  ///< the least
  Fault fault = Fault::kNone;
  /// While sliding, how far the force is from that of the same trial with ContactSource::kLoop in 95 of 100
  /// ticks, as a share of the mean of that.
  double force_off = 0.0;
  std::optional<double>
      z_width;  ///< z_width(), at the first place; none for a model without a stiffness. Unit: [N/m].
};

/// An ideal wall on a device.
struct WallRow {
  std::string profile;
  bool passivity;         ///< with the PassivityController
  double z_width, bound;  ///< wall_z_width(), wall_bound(). Unit: [N/m].
};

struct StabilityTables {
  std::vector<StabilityRow> rows;
  std::vector<WallRow> walls;
};

/// "0.1 kg, 3 N s/m, 300 N/m"
std::string hand_text(const HandProperties& hand);

/// The worst of all hands, a row for each profile, model and source.
struct StabilitySummary {
  const StabilityRow* any;  ///< for its names
  double limit_cycle = 0.0, port_energy = 0.0, force_off = 0.0;
  int contact_changes = 0;
  std::optional<double> z_low, z_high;
};
std::vector<StabilitySummary> summarize(const std::vector<StabilityRow>& rows);

OrderedJson stability_json(const StabilityTables& tables);
std::string stability_csv(const StabilityTables& tables);
std::string stability_text(const StabilityTables& tables);

}  // namespace palpate
