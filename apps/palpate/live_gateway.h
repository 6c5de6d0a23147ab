/// \file
/// The gateway of a live system: what clients see of it, and what they may change.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include <palpate/base/mapped_file.h>
#include <palpate/gateway/felt_list.h>
#include <palpate/gateway/live_topics.h>
#include <palpate/rosbridge/web_server.h>

#include "live_parameters.h"
#include "live_recording.h"
#include "live_system.h"

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

/// Serves a LiveSystem: topics, parameters, services, the viewer, the scene's file and recordings.
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

 private:
  /// What parameters() depends on.
  struct Shown {
    std::uint64_t system = 0, recording = 0;  ///< their version()
    std::string felt;                         ///< felt_tag_
    bool records = false, paused = false;
    bool operator==(const Shown&) const = default;
  };

  void add_services();
  void add_switches();
  void add_parameters();
  void beat();
  Value parameters() const;
  WebPage page(const std::string& path);
  bool is_paused() const { return feed_.newest().record.fault == Fault::kPaused; }
  WebPage health() const;
  WebPage metrics() const;

  LiveSystem& system_;
  std::string device_kind_;
  WorkspaceMap map_;
  Hub hub_;
  TickFeed feed_;
  RecordingSwitch recording_;
  Topic& parameters_topic_;
  std::unique_ptr<LiveTopics> topics_;
  std::unique_ptr<WebServer> server_;
  std::unique_ptr<MappedFile> scene_file_;  ///< null: the built-in scene
  std::string scene_bytes_, scene_tag_;
  std::optional<Shown> told_;            ///< to clients
  std::weak_ptr<const FeltScene> felt_;  ///< what the topics are of; not kept alive here
  FeltListMaker felt_list_;
  std::string felt_tag_;  ///< another for every list, of all that ever ran; empty before the first
};

}  // namespace palpate::cli
