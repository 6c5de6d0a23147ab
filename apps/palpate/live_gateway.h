/// \file
/// The gateway of a live system: what clients see of it, and what they may change.
#pragma once

#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include <fmt/format.h>

#include <palpate/base/latest_value.h>
#include <palpate/gateway/felt_list.h>
#include <palpate/gateway/live_topics.h>
#include <palpate/rosbridge/web_server.h>

#include "live_parameters.h"
#include "live_recording.h"
#include "live_system.h"
#include "scene_file.h"

namespace palpate::cli {

/// Where the gateway listens.
struct GatewayOptions {
  bool off = false;
  int port = -1;  ///< -1: kPort, or another if that is taken
  std::string address = "127.0.0.1";
  std::string token;

  static constexpr int kPort = 9090;

  void declare(CLI::App& app);
};

/// Serves a LiveSystem: topics, parameters, services, the viewer, the scene's file and recordings. What says
/// nothing else is done on the server's thread, which has poses to hand over and waits for nothing.
class LiveGateway {
 public:
  /// Listens. `system` must outlive it. \throws Error if the address cannot be had, or the scene's file not
  /// be read.
  LiveGateway(LiveSystem& system, const DeviceOptions& device, const GatewayOptions& options);
  ~LiveGateway();

  /// To be given to LiveSystem::start().
  std::vector<TickObserver*> observers() { return {&feed_, &recording_}; }
  /// Once the system has started.
  void start();
  /// Before the system ends.
  void stop();

  std::string url() const { return server_->url(); }
  /// What a person at the terminal should know, since the last call. Any thread.
  std::vector<std::string> take_notices();

 private:
  /// What parameters() depends on.
  struct Shown {
    std::uint64_t system = 0, recorded = 0, felt = 0, notices = 0;  ///< numbers of their versions
    bool records = false, paused = false;
    bool operator==(const Shown&) const = default;
  };

  Elsewhere elsewhere();
  void add_services();
  void add_switches();
  void add_recording();
  void add_parameters();
  void beat();
  void look_at_recording();
  void look_at_scene();
  void end_recording(RecordingSwitch::Done done);
  void tell(std::string& notice, const std::string& text);
  std::string message() const;
  Value parameters() const;
  bool is_paused() const { return feed_.newest().record.fault == Fault::kPaused; }
  std::string felt_tag(const FeltListMaker::List& list) const {
    return fmt::format("{}-{}", run_tag_, list.number);
  }

  /// \name On the thread of pages
  /// @{
  WebPage page(const std::string& path);
  WebPage scene_page() const;
  WebPage health();
  WebPage metrics();
  /// @}

  LiveSystem& system_;
  std::string device_kind_;
  WorkspaceMap map_;
  Hub hub_;
  TickFeed feed_;
  LatestValue<TickFeed::Tick> tick_for_pages_;
  RecordingSwitch recording_;
  FeltListMaker felt_list_;
  Topic& parameters_topic_;
  std::unique_ptr<LiveTopics> topics_;
  std::unique_ptr<WebServer> server_;
  std::unique_ptr<SceneFile> scene_file_;  ///< null: the built-in scene
  std::string scene_bytes_;                ///< that
  std::string run_tag_;                    ///< of what this run makes, unlike that of all other runs
  std::optional<Shown> told_;              ///< to clients
  std::weak_ptr<const FeltScene> felt_;    ///< what the topics are of; not kept alive here
  double looked_at_scene_ = 0.0;           ///< Unit: [s].
  std::string recording_notice_, scene_notice_;
  std::uint64_t notices_ = 0;  ///< how often they have changed
  std::mutex mutex_;           ///< of what follows
  std::vector<std::string> untold_;
};

}  // namespace palpate::cli
