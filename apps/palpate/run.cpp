// palpate run: live haptic rendering of a scene.
#include <array>
#include <csignal>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <unistd.h>

#include <palpate/base/error.h>
#include <palpate/base/nonblocking_stderr.h>
#include <palpate/base/real_time.h>
#include <palpate/live/live_gateway.h>
#include <palpate/live/live_hands.h>
#include <palpate/live/run_recordings.h>
#include <palpate/live/run_signals.h>
#include <palpate/report/live_table.h>
#include <palpate/rosbridge/own_address.h>
#include <palpate/servo/live_view.h>

#include "command.h"
#include "console.h"
#include "made.h"
#include "options.h"
#include "output.h"
#include "report.h"
#include "terminal.h"
#include "viewer_files.h"

namespace palpate::cli {
namespace {

constexpr const char* kCommand = "run";

struct RunOptions {
  CommonOptions common;
  LiveConfig live;
  std::string record;
  double seconds = 0.0;             ///< 0: until the user ends it
  std::vector<std::string> scenes;  ///< folders of scenes that the viewer may open
  std::vector<std::string> hands;   ///< additional hands, see read_hands()
  bool hands_touch = false;
};

extern "C" void end_before_run(int signal) {
  constexpr std::string_view kLine =
      "palpate: ended by a signal before the run began; a device that was being opened is not closed\n";
  static_cast<void>(!::write(STDERR_FILENO, kLine.data(), kLine.size()));
  std::signal(signal, SIG_DFL);
  std::raise(signal);
}

/// Lets signals end the program with a line until RunSignals handles them: a driver may take long, or hang,
/// when its device is opened and enabled.
void end_at_signals() {
  for (const int signal : std::array{SIGINT, SIGTERM, SIGHUP, SIGQUIT}) std::signal(signal, end_before_run);
}

/// Messages shown on the terminal that pages have yet to show. Any thread.
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

/// Default tool of the built-in scene, as thick as a fingertip.
Tool fingertip() { return Tool(Eigen::Vector3d::Constant(0.008)); }

/// Reason why pages may neither open another scene nor place it otherwise; empty if they may.
std::string one_scene(const RunOptions& options) {
  return options.record.empty()
             ? ""
             : "with --record, the scene and its placement cannot change; restart with another";
}

/// Warns, before the loops start, if the stiffness exceeds what the device renders without buzzing.
void warn(const LiveHands::Hand& hand, const Notify& tell) {
  const DeviceCapabilities& device = hand.system->device();
  const double stiffness = hand.system->settings().force.proxy.stiffness;
  if (device.stiffness_max > 0.0 && stiffness > device.stiffness_max) {
    tell(fmt::format("warning: {}--stiffness {} N/m is more than the {} renders without buzzing ({} N/m)",
                     said_of(hand.name), stiffness, device.name, device.stiffness_max));
  }
}

/// A line on stderr that waits for nobody: the loops may run, and this thread stops them.
void say(std::string_view line) { write_to_stderr(notice(line)); }

/// Describes a hand after its start, with notes on its limits.
void introduce(const LiveHands::Hand& hand, const Notify& tell) {
  LiveSystem& system = *hand.system;
  const LiveConfig settings = system.settings();
  const std::string of = said_of(hand.name);
  for (const std::string& line : system.loop().refused()) tell(fmt::format("note: {}{}", of, line));
  tell(fmt::format("{}{} ({}), tool {}, model {}, contacts {}, scene {}", of, system.device().name,
                   system.device_kind(), tool_in_words(settings.tool), to_string(settings.force.model),
                   to_string(system.contacts()), settings.scene.name()));
  if (system.device().watchdog == 0.0)
    tell(fmt::format(
        "note: {}this device declares no watchdog; its motors must turn off within 50 ms without a force",
        of));
}

/// Prints the URL of the viewer. If it has the name of this machine, which a headset may not be able to
/// resolve, prints the one with an IP address as well.
void tell_viewer(const std::string& url, const std::string& listens_on) {
  say(fmt::format("viewer: {}", url));
  const std::string address = is_any_address(listens_on) ? own_address() : std::string();
  if (address.empty()) return;
  const std::size_t host = url.find("://") + 3;
  std::string by_address = url;
  by_address.replace(host, url.find(':', host) - host, address);
  say(fmt::format("where that name is unknown: {}", by_address));
}

/// Prints the files of the recordings.
void print(const RunRecordings& recordings) {
  for (const auto& recording : recordings.all()) {
    const Recorder& recorder = recording->recorder;
    fmt::print("wrote {}: {} ticks, {} lost; next: palpate report {} --out report.html\n",
               printable(recording->path), recorder.written(), recorder.lost(), printable(recording->path));
  }
}

std::vector<HandSetup> setups_of(const RunOptions& options) {
  std::vector<HandSetup> setups = read_hands(options.hands, options.live);
  setups.insert(setups.begin(), HandSetup{{}, options.live});
  return setups;
}

void tell_outcomes(const std::vector<LiveOutcome>& outcomes, const LiveHands& hands, bool as_json) {
  Json json;
  for (std::size_t k = 0; k < outcomes.size(); ++k) {
    const auto& [name, system] = hands.all()[k];
    if (!as_json) {
      if (!name.empty()) fmt::print("hand {}\n", name);
      fmt::print("{}", live_text(outcomes[k], system->loop().statistics()));
      continue;
    }
    Json& of_hand = name.empty() ? json : json["hands"][name];
    of_hand = live_json(outcomes[k], system->loop().statistics());
    of_hand["made"] = made_json(system->provenance(kCommand));
  }
  if (as_json) print_json(json);
}

void run(const RunOptions& options) {
  end_at_signals();
  const Progress progress = terminal_progress(options.common.quiet);
  Lines lines;
  const auto tell = [&lines](const std::string& line) {
    say(line);
    lines.add(line);
  };
  LiveHands hands(setups_of(options), tell, progress, options.hands_touch);
  RunRecordings recordings(options.record, hands, kCommand);
  const bool talks = !options.common.quiet;
  std::unique_ptr<LiveGateway> gateway;
  if (!options.live.gateway.off) {
    gateway = std::make_unique<LiveGateway>(
        hands, GatewayPages{viewer_file, recording_page, options.scenes, one_scene(options)});
  }
  LiveViews views;
  std::vector<std::vector<TickObserver*>> observers;
  std::vector<LiveSystem*> systems;
  for (const LiveHands::Hand& hand : hands.all()) {
    std::vector<TickObserver*> of_hand{views.emplace_back(std::make_unique<LiveView>()).get()};
    if (auto* const recording = recordings.observer(observers.size())) of_hand.push_back(recording);
    if (gateway)
      for (TickObserver* observer : gateway->observers(observers.size())) of_hand.push_back(observer);
    observers.push_back(std::move(of_hand));
    systems.push_back(hand.system.get());
    warn(hand, tell);
  }
  if (const auto refused = lock_memory(); refused && talks) tell("note: " + *refused);
  hands.enable();
  std::optional<RunSignals> signals(std::in_place, systems);
  hands.start(observers);
  const LoopEnd end(hands);
  if (gateway) gateway->start();
  if (talks) {
    for (const LiveHands::Hand& hand : hands.all()) introduce(hand, tell);
    if (gateway) tell_viewer(gateway->url(), options.live.gateway.address);
  }

  const double until = options.seconds > 0.0 ? options.seconds : hands.playback_length();
  std::optional<std::string> failure;
  {
    Console console(hands, views, gateway.get(), !talks);
    if (talks && ::isatty(STDIN_FILENO) != 0) {
      say(Console::kHelp);
      if (systems.size() > 1) say(Console::kHelpOfHands);
    }
    while (hands.first().clock().now() < until && !failure && console.update()) {
      failure = recordings.failure();
      if (!gateway) continue;
      for (const std::string& line : lines.take()) gateway->say(line);
      for (const std::string& message : gateway->take_notices()) console.tell(message);
    }
    if (failure) {
      hands.stop_force(Fault::kRecorder);
      console.wait_for_no_force();
    }
    for (const auto& view : views) view->update();
    console.tell_transitions();
  }
  std::vector<LiveOutcome> outcomes;
  for (std::size_t k = 0; k < systems.size(); ++k) {
    const LiveView& view = *views[k];
    outcomes.push_back({systems[k]->clock().now(), systems[k]->loop().statistics().ticks, view.totals(),
                        view.totals().state, faults_of(view)});
  }
  hands.stop_force(Fault::kEnded);  // falls while the gateway stops
  if (gateway) gateway->stop();
  hands.stop();
  signals.reset();  // no force is left: from here, a signal may end the program
  recordings.close();
  failure = recordings.failure();
  for (std::size_t k = 0; k < recordings.all().size(); ++k) {
    const HandRecording& recording = *recordings.all()[k];
    outcomes[k].lost = recording.recorder.lost();
    if (outcomes[k].lost > 0 && !failure)
      say(fmt::format("warning: {} lacks {} ticks: the disk is too slow", printable(recording.path),
                      outcomes[k].lost));
  }
  if (talks || options.common.json) tell_outcomes(outcomes, hands, options.common.json);
  if (talks && !options.common.json && !failure) print(recordings);
  if (failure) throw Error("{}", *failure);
  if (const std::string left = hands.left_devices(); !left.empty()) throw Error("{}", left);
}

}  // namespace

Command declare_run(CLI::App& parent) {
  CLI::App& app =
      add_command(parent, kCommand, "Live haptic rendering: a servo loop between a device and a scene");
  auto options = std::make_shared<RunOptions>();
  declare_common(app, options->common, "print the summary as JSON");
  LiveConfig& live = options->live;
  declare_scene(app, live, SceneArgument::kOptionalPositional);
  add_number(app, "--seconds", options->seconds, 0.0, 1e7, "s", "duration (default: until q or Ctrl-C)");
  add_text(
      app, "--record", options->record, "RUN.csv",
      "record every tick, for palpate report; a hand NAME is recorded in RUN-NAME.csv; must not exist yet");
  add_texts(
      app, "--hands", options->hands, "NAME[=FILE.toml],...",
      "additional hands in the same scene, each with a device of its own; a FILE.toml, as for --config, has "
      "the settings that differ from those of the first hand");
  add_flag(app, "--hands-touch", options->hands_touch,
           "render contact forces between the tools of the hands");
  declare_group(app, live, ConfigGroup::kDevice);
  declare_group(app, live, ConfigGroup::kLoop);
  declare_group(app, live, ConfigGroup::kGateway);
  add_texts(app, "--scenes", options->scenes, "DIR,...", "folders of scenes that the viewer may open")
      .in_group(std::string(title(ConfigGroup::kGateway)));
  declare_field(app, live, "tool");
  declare_field(app, live, "no-index-file");
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
