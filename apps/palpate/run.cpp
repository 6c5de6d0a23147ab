// palpate run: a hand, a device, and a scene between them, live.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <unistd.h>

#include <palpate/base/error.h>
#include <palpate/base/real_time.h>
#include <palpate/live/live_gateway.h>
#include <palpate/live/live_system.h>
#include <palpate/live/run_signals.h>
#include <palpate/record/recording_observer.h>
#include <palpate/servo/live_view.h>

#include "command.h"
#include "keyboard.h"
#include "made.h"
#include "options.h"
#include "output.h"
#include "report.h"
#include "terminal.h"
#include "viewer_files.h"

namespace palpate::cli {
namespace {

constexpr const char* kCommand = "run";
constexpr double kMicro = 1e6;
/// Between two looks at the loop. Unit: [s].
constexpr double kLook = 0.05;
/// A press of + or -.
constexpr double kStiffer = 1.25, kLeastGain = 0.05, kMostGain = 20.0;

struct Options {
  CommonOptions common;
  LiveConfig live;
  std::string record;
  double seconds = 0.0;             ///< 0: until someone ends it
  std::vector<std::string> scenes;  ///< folders
};

/// Ends the loop before what looks on is gone, whatever happens.
class LoopEnd {
 public:
  explicit LoopEnd(LiveSystem& system) : system_(system) {}
  ~LoopEnd() { system_.stop(); }
  LoopEnd(const LoopEnd&) = delete;
  LoopEnd& operator=(const LoopEnd&) = delete;

 private:
  LiveSystem& system_;
};

/// What the terminal has shown and pages are still to show. Any thread.
class Lines {
 public:
  void add(const std::string& line) {
    const std::scoped_lock lock(mutex_);
    lines_.push_back(line);
  }
  std::vector<std::string> take() {
    const std::scoped_lock lock(mutex_);
    return std::exchange(lines_, {});
  }

 private:
  std::mutex mutex_;
  std::vector<std::string> lines_;
};

/// What a person at the terminal sees and does.
class Console {
 public:
  /// \param gateway whose pages show what is told, too; may be null
  Console(LiveSystem& system, LiveView& view, LiveGateway* gateway, bool quiet)
      : system_(system),
        view_(view),
        gateway_(gateway),
        quiet_(quiet),
        stiffness_(system.settings().force.proxy.stiffness),
        draws_(!quiet && ::isatty(STDERR_FILENO) != 0) {}
  ~Console() { clear(); }
  Console(const Console&) = delete;
  Console& operator=(const Console&) = delete;

  /// Looks, and waits a little for a key. \returns false once someone wants to end.
  bool look() {
    view_.update();
    tell_transitions();
    if (draws_) draw();
    const auto key = keyboard_.key(kLook);
    return !(key && !act(*key)) && !RunSignals::ended();
  }

  void tell_transitions();
  void tell(const std::string& message) const {
    clear();
    if (gateway_ != nullptr) gateway_->say(message);
    if (!quiet_) stderr_.write(notice(message));
  }

  /// Until a fall that was asked for is over, so that its reason is told, and recorded where that is
  /// possible.
  void wait_for_no_force() {
    while (look() && view_.newest().state != GovernorState::kStopped) {
    }
  }

  static constexpr const char* kHelp =
      "keys: space pause and go on, e emergency stop, r resume after a fault, m model, + - stiffness, c "
      "clutch, q quit";

 private:
  void clear() const {
    if (draws_) stderr_.write("\r\033[K");
  }
  void draw() const;
  bool act(char key);
  void make_stiffer(double times);

  LiveSystem& system_;
  LiveView& view_;
  LiveGateway* gateway_;
  bool quiet_;
  double stiffness_;  ///< at the beginning. Unit: [N/m].
  bool draws_;
  bool clutched_ = false;
  NonblockingStderr stderr_;
  Keyboard keyboard_;
  std::size_t told_ = 0;
};

void Console::tell_transitions() {
  const auto transitions = view_.transitions();
  for (; told_ < transitions.size(); ++told_) {
    const GovernorTransition& change = transitions[told_];
    if (change.fault == Fault::kNone || change.to != GovernorState::kFalling) continue;
    const std::string_view device = system_.device_fault();
    tell(fmt::format("{:.3f} s: no force: {}: {}{}{}", change.t, traits(change.fault).name,
                     traits(change.fault).advice, device.empty() ? "" : "; it says: ", device));
  }
}

void Console::draw() const {
  const TickRecord& now = view_.newest();
  const LiveConfig settings = system_.settings();
  const LoopStatistics& statistics = system_.loop().statistics();
  const std::string why = now.fault == Fault::kNone ? "" : fmt::format(" ({})", traits(now.fault).name);
  const std::string margin = now.margin <= 0.0  ? "-"
                             : now.margin < 1.0 ? fmt::format("{:.1f}x: softer, since it is late", now.margin)
                                                : fmt::format("{:.1f}x", now.margin);
  const std::string_view held_by = system_.device_held_by();
  const std::string held = held_by.empty() ? "" : fmt::format("  held: {}", held_by);
  stderr_.write(fmt::format(
      "\r\033[K{:7.1f} s  {}{}  {} {:.0f} N/m  {:5.2f} N  {:3} contacts  tick {:.0f}/{:.0f} us  {} overruns  "
      "margin {}{}",
      now.t, to_string(now.state), why, to_string(settings.force.model), settings.force.proxy.stiffness,
      now.sent.force.norm(), now.contacts, kMicro * statistics.whole.quantile(0.5),
      kMicro * statistics.whole.quantile(0.99), statistics.overruns.load(), margin, held));
}

bool Console::act(char key) {
  SafetyGovernor& governor = system_.tick().governor();
  switch (key) {
    case ' ':
      view_.newest().fault == Fault::kPaused ? governor.unpause() : governor.stop(Fault::kPaused);
      break;
    case 'r': system_.resume(); break;
    case 'e': system_.stop_force(); break;
    case 'm':
      system_.change([](LiveConfig& settings) {
        const auto next = static_cast<std::size_t>(settings.force.model) + 1;
        settings.force.model = static_cast<ForceModelKind>(next % kForceModelNames.size());
      });
      break;
    case '+': make_stiffer(kStiffer); break;
    case '-': make_stiffer(1.0 / kStiffer); break;
    case 'c':
      clutched_ = !clutched_;
      system_.tick().press_clutch(clutched_);
      break;
    case 'q': return false;
    default: break;
  }
  return true;
}

void Console::make_stiffer(double times) {
  system_.change([&](LiveConfig& settings) {
    double& stiffness = settings.force.proxy.stiffness;
    stiffness = std::clamp(times * stiffness, kLeastGain * stiffness_, kMostGain * stiffness_);
  });
}

Json times_json(const TimeHistogram& times) {
  return {{"p50", kMicro * times.quantile(0.5)},
          {"p99", kMicro * times.quantile(0.99)},
          {"p999", kMicro * times.quantile(0.999)},
          {"max", kMicro * times.max()}};
}

/// The faults there were, once each, in order.
std::vector<std::string> faults_of(const LiveView& view) {
  std::vector<std::string> names;
  for (const GovernorTransition& change : view.transitions()) {
    const std::string name(traits(change.fault).name);
    if (change.fault != Fault::kNone && std::find(names.begin(), names.end(), name) == names.end())
      names.push_back(name);
  }
  return names;
}

/// A run that is over.
struct Outcome {
  double seconds;
  std::uint64_t ticks;
  LiveTotals totals;
  GovernorState state;  ///< before it was ended
  std::vector<std::string> faults;
};

Json to_json(const Outcome& outcome, LiveSystem& system) {
  const LoopStatistics& statistics = system.loop().statistics();
  const LiveTotals& totals = outcome.totals;
  return {{"ticks", outcome.ticks},
          {"rate_hz", static_cast<double>(outcome.ticks) / outcome.seconds},
          {"overruns", statistics.overruns.load()},
          {"tick_us", times_json(statistics.whole)},
          {"cpu_us", times_json(statistics.spent)},
          {"age_us", times_json(statistics.age)},
          {"late_us", times_json(statistics.late)},
          {"contact_ticks", totals.contact_ticks},
          {"contacts_max", totals.contacts_max},
          {"force_max", totals.force_max},
          {"port_energy", totals.port_energy},
          {"margin_min", totals.margin_min},
          {"state", to_string(outcome.state)},
          {"faults", outcome.faults}};
}

void print_text(const Outcome& outcome, LiveSystem& system) {
  const LoopStatistics& statistics = system.loop().statistics();
  const LiveTotals& totals = outcome.totals;
  const auto times = [](const char* name, const TimeHistogram& h) {
    fmt::print("{:<16} p50 {:.1f} us, p99 {:.1f}, p99.9 {:.1f}, max {:.0f}\n", name, kMicro * h.quantile(0.5),
               kMicro * h.quantile(0.99), kMicro * h.quantile(0.999), kMicro * h.max());
  };
  fmt::print("{} ticks in {:.1f} s, {:.0f} Hz, {} overruns; {}\n", outcome.ticks, outcome.seconds,
             static_cast<double>(outcome.ticks) / outcome.seconds, statistics.overruns.load(),
             to_string(outcome.state));
  times("tick", statistics.whole);
  times("of it computing", statistics.spent);
  times("age of the force", statistics.age);
  times("late", statistics.late);
  fmt::print("in contact       {:.1f} % of the ticks, up to {} contacts, up to {:.2f} N\n",
             100.0 * static_cast<double>(totals.contact_ticks) /
                 static_cast<double>(std::max<std::uint64_t>(1, outcome.ticks)),
             totals.contacts_max, totals.force_max);
  fmt::print("port             put out at most {:.3f} mJ more than it took in; stiffness {}\n",
             1e3 * totals.port_energy,
             totals.margin_min >= 1.0 ? fmt::format("could be {:.1f} times as large", totals.margin_min)
             : totals.margin_min > 0.0
                 ? fmt::format("was lowered to {:.2f} of what was set: forces come too late for more",
                               totals.margin_min)
                 : "has no margin to tell");
  if (!outcome.faults.empty()) fmt::print("faults           {}\n", fmt::join(outcome.faults, ", "));
}

/// As thick as that of a finger: what the built-in scene is felt with unless a tool is given.
Tool fingertip() { return Tool(Eigen::Vector3d::Constant(0.008)); }

/// Why no page may open another scene.
std::string one_scene(const Options& options) {
  return options.record.empty() ? "" : "with --record all of a run is of one scene: start again for another";
}

/// What a user should know before a hand is near.
void warn(const LiveSystem& system, const Notify& tell) {
  const DeviceCapabilities& device = system.device();
  const double stiffness = system.settings().force.proxy.stiffness;
  if (device.stiffness_max > 0.0 && stiffness > device.stiffness_max) {
    tell(fmt::format("warning: --stiffness {} N/m is more than the {} shows without buzzing ({} N/m)",
                     stiffness, device.name, device.stiffness_max));
  }
}

void run(const Options& options) {
  const Progress progress = terminal_progress(options.common.quiet);
  Lines lines;
  const auto tell = [&lines](const std::string& line) {
    notify(line);
    lines.add(line);
  };
  LiveSystem system(options.live, nullptr, tell, progress);
  std::unique_ptr<Recorder> recorder;
  std::unique_ptr<RecordingObserver> recording;
  const auto view = std::make_unique<LiveView>();
  std::vector<TickObserver*> observers{view.get()};
  if (!options.record.empty()) {
    RecorderOptions recorded = recorder_options(system.device());
    recorded.made = to_toml(system.provenance(kCommand));
    recorder = std::make_unique<Recorder>(options.record, recorded);
    recording = std::make_unique<RecordingObserver>(*recorder);
    observers.push_back(recording.get());
  }
  const bool talks = !options.common.quiet;
  std::unique_ptr<LiveGateway> gateway;
  if (!options.live.gateway.off) {
    gateway = std::make_unique<LiveGateway>(
        system, GatewayPages{viewer_file, recording_page, options.scenes, one_scene(options)});
    for (TickObserver* observer : gateway->observers()) observers.push_back(observer);
  }
  warn(system, tell);
  if (const auto refused = lock_memory(); refused && talks) tell("note: " + *refused);
  system.start(observers);
  const LoopEnd end(system);
  if (gateway) gateway->start();
  std::optional<RunSignals> signals(std::in_place, system);
  if (talks) {
    for (const std::string& line : system.loop().refused()) tell("note: " + line);
    tell(fmt::format("{} ({}), tool {}, model {}, contacts {}, scene {}", system.device().name,
                     system.device_kind(), tool_text(options.live.tool),
                     to_string(system.settings().force.model), to_string(system.contacts()),
                     options.live.scene.name()));
    if (system.device().watchdog == 0.0)
      tell("note: no watchdog of this device is known; it must show no force once none has come for 50 ms");
    if (gateway) notify(fmt::format("see and take part: {}", gateway->url()));
  }

  double until = options.seconds > 0.0 ? options.seconds : system.playback_length();
  if (until == 0.0) until = std::numeric_limits<double>::infinity();
  std::optional<std::string> failure;
  {
    Console console(system, *view, gateway.get(), !talks);
    if (talks && ::isatty(STDIN_FILENO) != 0) notify(Console::kHelp);
    while (system.clock().now() < until && !failure && console.look()) {
      if (recorder) failure = recorder->failure();
      if (!gateway) continue;
      for (const std::string& line : lines.take()) gateway->say(line);
      for (const std::string& message : gateway->take_notices()) console.tell(message);
    }
    if (failure) {
      system.tick().governor().stop(Fault::kRecorder);
      console.wait_for_no_force();
    }
    view->update();
    console.tell_transitions();
  }
  const Outcome outcome{system.clock().now(), system.loop().statistics().ticks, view->totals(),
                        view->newest().state, faults_of(*view)};
  system.tick().governor().stop(Fault::kPaused);  // the force falls while the rest is ended
  if (gateway) gateway->stop();
  system.stop();
  signals.reset();  // there is no force: a signal may end whatever is left to write
  view->update();
  if (recorder) {
    recorder->close();
    failure = recorder->failure();
  }
  if (options.common.json) {
    Json json = to_json(outcome, system);
    json["made"] = made_json(system.provenance(kCommand));
    print_json(json);
  } else if (talks) {
    print_text(outcome, system);
    if (recorder && !failure) {
      fmt::print("wrote {}: {} ticks, {} lost; next: palpate report {} --out report.html\n",
                 printable(options.record), recorder->written(), recorder->lost(), printable(options.record));
    }
  }
  if (failure) throw Error("{}", *failure);
}

}  // namespace

Command declare_run(CLI::App& parent) {
  CLI::App& app =
      add_command(parent, kCommand, "Feel a scene live: a servo loop between a device and a scene");
  auto options = std::make_shared<Options>();
  declare_common(app, options->common, "print the summary as JSON");
  LiveConfig& live = options->live;
  declare_scene(app, live, SceneArgument::kOptionalPositional);
  add_number(app, "--seconds", options->seconds, 0.0, 1e7, "s", "how long (default: until q, or Ctrl-C)");
  add_text(app, "--record", options->record, "RUN.csv", "every tick, for palpate report; must not exist");
  declare_group(app, live, ConfigGroup::kDevice);
  declare_group(app, live, ConfigGroup::kLoop);
  declare_group(app, live, ConfigGroup::kGateway);
  add_texts(app, "--scenes", options->scenes, "DIR,...", "folders whose scenes the viewer may open")
      .in_group(std::string(title(ConfigGroup::kGateway)));
  declare_field(app, live, "tool");
  declare_field(app, live, "no-index-file").in_group("Options");
  declare_group(app, live, ConfigGroup::kForce);
  return {&app, [&app, options] {
            LiveConfig& settings = options->live;
            if (settings.scene.path.empty() && !is_given(app, "--tool")) settings.tool = fingertip();
            SceneConfig& scene = settings.scene;
            scene.scale_known = scene.path.empty() || is_given(app, "--scale");
            scene.frame_known = scene.path.empty() || is_given(app, "--frame") || is_given(app, "--rotate");
            run(*options);
          }};
}

}  // namespace palpate::cli
