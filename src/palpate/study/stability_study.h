/// \file
/// Stability trials over devices, hands and force models at several places of a scene.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <palpate/base/progress.h>
#include <palpate/study/stability.h>

namespace palpate {

/// Source of the contacts of a trial.
enum class ContactSource {
  kLoop,    ///< searched in the loop
  kWorker,  ///< searched by a delayed worker thread that looks ahead
  kHold,    ///< the force is computed by a delayed thread and held, as in the paper
};
std::string_view to_string(ContactSource source);

/// Worst result over all places for one device, hand and model.
struct StabilityRow {
  std::string profile, model;
  HandProperties hand;
  ContactSource source = ContactSource::kLoop;
  double delay = 0.0;                           ///< of `source`. Unit: [s].
  double limit_cycle = 0.0, port_energy = 0.0;  ///< StabilityOutcome
  int contact_changes = 0;
  double rest_force = 0.0;  ///< minimum over all places
  Fault fault = Fault::kNone;
  /// Difference of the force from that of the same trial with ContactSource::kLoop while sliding, 95th
  /// percentile, relative to the mean of the latter.
  double force_off = 0.0;
  std::optional<double>
      z_width;  ///< z_width(), at the first place; none for a model without a stiffness. Unit: [N/m].
};

/// Z-width of an ideal wall on a device.
struct WallRow {
  std::string profile;
  bool passivity;         ///< with the PassivityController
  double z_width, bound;  ///< wall_z_width(), wall_bound(). Unit: [N/m].
};

struct StabilityTables {
  std::vector<StabilityRow> rows;
  std::vector<WallRow> walls;
};

/// Parameters of the study: every profile is tried with every model, hand and source of contacts.
struct StabilityStudy {
  const SceneIndex* index = nullptr;  ///< must outlive it
  Tool tool;
  std::vector<PressPlace> places;
  std::vector<std::string> profiles, models;
  std::vector<HandProperties> hands;
  double delay = 0.0;      ///< of ContactSource::kWorker and kHold; 0: neither is tried. Unit: [s].
  double stiffness = 0.0;  ///< of the models. Unit: [N/m].
  /// Creates the force model of that name, which searches for contacts through `lookahead` unless that is
  /// null.
  std::function<std::unique_ptr<ForceModel>(const std::string& name, Lookahead* lookahead)> model;
};

/// Light, usual and heavy hands, each with a loose, usual and firm grip: the range of human hands.
std::vector<HandProperties> usual_hands();

/// The trial of a row. \pre `study` outlives it
StabilityTrial trial_of(const StabilityStudy& study, const StabilityRow& row);

StabilityTables measure_stability(const StabilityStudy& study, const Progress& progress);

}  // namespace palpate
