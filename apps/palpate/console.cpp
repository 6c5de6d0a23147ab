#include "console.h"

#include <algorithm>
#include <utility>

#include <fmt/format.h>
#include <unistd.h>

#include <palpate/live/run_signals.h>
#include <palpate/scene/material_properties.h>

#include "output.h"

namespace palpate::cli {
namespace {

constexpr double kMicro = 1e6;
/// Interval between updates of the display. Unit: [s].
constexpr double kLook = 0.05;
/// Factor on the stiffness per press of + (- divides by it), and how far they go, relative to the initial
/// stiffness.
constexpr double kStiffer = 1.25, kLeastGain = 0.05, kMostGain = 20.0;
constexpr double kMostStiffness = kMaterialProperties[kMaterialStiffness].most;
/// Largest number of status lines, which fits on any terminal.
constexpr std::size_t kMostLines = 20;

}  // namespace

Console::Console(LiveHands& hands, const LiveViews& views, LiveGateway* gateway, bool quiet)
    : hands_(hands),
      views_(views),
      gateway_(gateway),
      quiet_(quiet),
      stiffness_(hands.first().settings().force.proxy.stiffness),
      draws_(!quiet && ::isatty(STDERR_FILENO) != 0),
      told_(views.size()) {}

bool Console::update() {
  show();
  const auto key = keyboard_.key(kLook);
  return !(key && !act(*key)) && !RunSignals::ended();
}

void Console::wait_for_no_force() {
  const auto has_fallen = [](const auto& view) { return view->newest().state == GovernorState::kStopped; };
  while (!RunSignals::ended() && !std::all_of(views_.begin(), views_.end(), has_fallen)) {
    show();
    keyboard_.key(kLook);  // none is obeyed: the force is not to return
  }
}

void Console::show() {
  for (const auto& view : views_) view->update();
  tell_transitions();
  if (draws_) draw();
}

void Console::tell_transitions() {
  for (std::size_t k = 0; k < views_.size(); ++k) {
    const auto transitions = views_[k]->transitions();
    for (; told_[k].transitions < transitions.size(); ++told_[k].transitions) {
      const GovernorTransition& change = transitions[told_[k].transitions];
      if (change.fault == Fault::kStalled && std::exchange(told_[k].stall, false)) continue;  // told below
      if (change.to == GovernorState::kFalling) tell_fault(k, change.t, change.fault);
    }
    const bool stalled = views_[k]->has_stalled();
    if (stalled && !told_[k].stall) tell_fault(k, views_[k]->newest().t, Fault::kStalled);
    told_[k].stall = stalled;
  }
}

void Console::tell_fault(std::size_t hand, double t, Fault fault) {
  if (fault == Fault::kNone) return;
  const auto& [name, system] = hands_.all()[hand];
  const std::string_view device = system->device_fault();
  tell(fmt::format("{:.3f} s: {}no force: {}: {}{}{}", t, said_of(name), traits(fault).name,
                   traits(fault).advice, device.empty() ? "" : "; the device reports: ", device));
}

void Console::tell(const std::string& message) {
  clear();
  if (gateway_ != nullptr) gateway_->say(message);
  if (!quiet_) stderr_.write(notice(message));
}

/// Control sequence that erases the drawn lines from the terminal.
std::string Console::erased() {
  const std::size_t above = std::max<std::size_t>(std::exchange(drawn_, 0), 1) - 1;
  return above > 0 ? fmt::format("\r\033[{}A\033[J", above) : "\r\033[K";
}

void Console::clear() {
  if (draws_) stderr_.write(erased());
}

void Console::draw() {
  const std::size_t count = views_.size(), shown = std::min(count, kMostLines);
  std::string text = line_of(0);
  for (std::size_t k = 1; k < shown; ++k) text += "\n\r" + line_of(k);
  if (shown < count) text += fmt::format("  (and {} more)", count - shown);
  // Clipped to the width of the terminal: erased() does not count wrapped lines.
  stderr_.write(erased() + "\033[?7l" + text + "\033[?7h");
  drawn_ = shown;
}

std::string Console::line_of(std::size_t hand) const {
  const auto& [name, system] = hands_.all()[hand];
  const TickRecord& now = views_[hand]->newest();
  const LiveConfig settings = system->settings();
  const LoopStatistics& statistics = system->loop().statistics();
  const std::string why = now.fault == Fault::kNone ? "" : fmt::format(" ({})", traits(now.fault).name);
  const std::string margin = now.margin <= 0.0 ? "-"
                             : now.margin < 1.0
                                 ? fmt::format("{:.1f}x: stiffness reduced for stability", now.margin)
                                 : fmt::format("{:.1f}x", now.margin);
  const std::string_view held_by = system->device_held_by();
  const std::string held = held_by.empty() ? "" : fmt::format("  held: {}", held_by);
  return fmt::format(
      "{:7.1f} s  {}{}{}  {} {:.0f} N/m  {:5.2f} N{}  {:3} contacts  margin {}  tick {:.0f}/{:.0f} us  "
      "{} overruns",
      now.t, said_of(name), to_string(now.state), why, to_string(settings.force.model),
      settings.force.proxy.stiffness, now.sent.force.norm(), held, now.contacts, margin,
      kMicro * statistics.whole.quantile(0.5), kMicro * statistics.whole.quantile(0.99),
      statistics.overruns.load());
}

bool Console::act(char key) {
  LiveSystem& first = hands_.first();
  switch (key) {
    case ' ': pause_or_go_on(); break;
    case 'r':
      for (const LiveHands::Hand& hand : hands_.all()) hand.system->resume();
      break;
    case 'e': hands_.stop_force(); break;
    case 'm':
      first.change([](LiveConfig& settings) {
        const auto next = static_cast<std::size_t>(settings.force.model) + 1;
        settings.force.model = static_cast<ForceModelKind>(next % kForceModelNames.size());
      });
      break;
    case '+': make_stiffer(kStiffer); break;
    case '-': make_stiffer(1.0 / kStiffer); break;
    case 'c': first.tick().press_clutch(!first.tick().is_clutch_pressed()); break;
    case 'q': return false;
    default: break;
  }
  return true;
}

/// Pauses or resumes all hands, depending on the state of the first.
void Console::pause_or_go_on() {
  const bool paused = views_.front()->newest().paused;
  for (const LiveHands::Hand& hand : hands_.all()) {
    SafetyGovernor& governor = hand.system->tick().governor();
    paused ? governor.unpause() : governor.stop(Fault::kPaused);
  }
}

/// A stiffness that was set beyond the limits elsewhere stays until a key leads back.
void Console::make_stiffer(double times) {
  hands_.first().change([&](LiveConfig& settings) {
    double& stiffness = settings.force.proxy.stiffness;
    stiffness = times > 1.0 ? std::max(stiffness,
                                       std::min({times * stiffness, kMostGain * stiffness_, kMostStiffness}))
                            : std::min(stiffness, std::max(times * stiffness, kLeastGain * stiffness_));
  });
}

}  // namespace palpate::cli
