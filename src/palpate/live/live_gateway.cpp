#include <palpate/live/live_gateway.h>

#include <algorithm>
#include <filesystem>
#include <limits>
#include <mutex>
#include <optional>
#include <utility>

#include <fmt/format.h>

#include <palpate/base/clock.h>
#include <palpate/base/error.h>
#include <palpate/base/real_time.h>
#include <palpate/gateway/contact_markers.h>
#include <palpate/gateway/felt_list.h>
#include <palpate/live/drawn_scene.h>
#include <palpate/live/gateway_metrics.h>
#include <palpate/live/gateway_notices.h>
#include <palpate/live/hand_gateway.h>
#include <palpate/live/scene_library.h>
#include <palpate/live/scenes_json.h>
#include <palpate/live/setup_json.h>
#include <palpate/rosbridge/access.h>
#include <palpate/rosbridge/web_server.h>
#include <palpate/scene/load_scene.h>

namespace palpate {
namespace {

/// Content-Security-Policy of the viewer: its own files, workers that it creates itself, and connections to
/// its own origin.
constexpr const char* kViewerPolicy =
    "default-src 'none'; script-src 'self' 'wasm-unsafe-eval'; style-src 'self'; img-src 'self'; worker-src "
    "blob:; connect-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'";
/// Content-Security-Policy of a report, which permits what the policy in the page itself permits: both apply.
constexpr const char* kReportPolicy =
    "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; frame-ancestors 'none'";

bool is_loopback(const std::string& address) { return address.starts_with("127.") || address == "::1"; }

WebPage page_of(std::string_view type, std::string_view bytes, std::string tag,
                std::shared_ptr<const void> keeps = nullptr) {
  WebPage page;
  page.type = type;
  page.bytes = bytes;
  page.keeps = std::move(keeps);
  page.tag = std::move(tag);
  return page;
}

/// Returns `setup` for a scene that stays mirrored, turned and moved as `scene` is.
SceneSetup placed_as(SceneSetup setup, SceneConfig scene) {
  if (!setup.crop_box.value) return setup;
  const Similarity from_proposed = upright(setup.frame.value, {setup.scale.value}).inverse();
  scene.frame = setup.frame.value;
  scene.registration.scale = setup.scale.value;
  const Similarity to_world = scene.world_from_scene();
  Eigen::AlignedBox3d box;
  for (int k = 0; k < 8; ++k) {
    const auto corner = static_cast<Eigen::AlignedBox3d::CornerType>(k);
    box.extend(to_world * (from_proposed * setup.crop_box.value->corner(corner)));
  }
  setup.crop_box.value = box;
  return setup;
}

/// Prefix of the ROS names.
const std::string kFolder = "/palpate/";
/// Time without a tick after which a loop is reported to have stopped. Unit: [s].
constexpr double kPatience = 0.5;

}  // namespace

/// After start(), private functions run on the server's thread unless marked otherwise. That thread passes
/// on poses and must not block.
class LiveGateway::Implementation {
 public:
  Implementation(LiveHands& hands, GatewayPages pages);
  ~Implementation() { stop(); }
  Implementation(const Implementation&) = delete;
  Implementation& operator=(const Implementation&) = delete;

  std::vector<TickObserver*> observers(std::size_t hand) { return hands_[hand]->observers(); }
  void start();
  void stop();

  std::string url() const { return server_->url(); }
  /// Any thread.
  std::vector<std::string> take_notices() { return notices_.take(); }
  void say(const std::string& line);

 private:
  /// A ROS parameter: the hand, and its name in the hand's parameters.
  struct Parameter {
    HandGateway& hand;
    std::string name;
  };

  Elsewhere elsewhere();
  void add_hands();
  void add_parameters();
  void add_setup();
  void add_library();
  void serve(const FeltScene& felt);
  std::string open_from_library(const std::string& id);
  WebUploads uploads();
  std::shared_ptr<DrawnScene> served() const {
    const std::scoped_lock lock(mutex_);
    return served_;
  }
  HandGateway& first() const { return *hands_.front(); }
  bool is_recording() const;
  std::string keeps_scene() const;
  void listen(const GatewayConfig& options);
  void beat();
  void publish_lines();
  void publish_hands();
  void look_at_scene();
  void describe(Json& parameters) const;
  Parameter parameter_of(const Json& arguments) const;
  std::string felt_tag(const FeltListMaker::List& list) const {
    return fmt::format("{}-{}", run_tag_, list.number);
  }

  /// \name On the page thread
  /// @{
  WebPage page(const std::string& path);
  std::optional<WebPage> recording_page(const std::string& path) const;
  WebPage scene_page();
  WebPage health();
  WebPage metrics();
  /// @}

  LiveHands& live_;
  GatewayPages pages_;
  Hub hub_;
  GatewayNotices notices_;
  std::string refused_origin_;                       ///< the last notice about one
  std::vector<std::unique_ptr<HandGateway>> hands_;  ///< in the order of LiveHands::all()
  FeltListMaker felt_list_;
  Topic &lines_topic_, &hands_topic_;
  std::unique_ptr<WebServer> server_;
  SceneLibrary library_;
  std::string run_tag_;                  ///< prefix of entity tags of this run's data; random
  std::weak_ptr<const FeltScene> felt_;  ///< scene that was passed to serve() last; not kept alive here
  double looked_at_scene_ = 0.0;         ///< Unit: [s].
  std::string scene_notice_;
  std::uint64_t beats_ = 0;
  mutable std::mutex mutex_;            ///< guards the members below
  std::vector<std::string> said_;       ///< lines on the terminal; the newest kMostLines
  bool said_more_ = false;              ///< said_ has unpublished lines
  std::shared_ptr<DrawnScene> served_;  ///< never null
};

LiveGateway::Implementation::Implementation(LiveHands& hands, GatewayPages pages)
    : live_(hands),
      pages_(std::move(pages)),
      felt_list_(elsewhere()),
      lines_topic_(hub_.add_topic("/palpate/messages", "std_msgs/String", true)),
      hands_topic_(hub_.add_topic("/palpate/hands", "visualization_msgs/MarkerArray")),
      library_(pages_.scene_folders, hands.first().settings().scene.path),
      run_tag_(random_text()) {
  const LiveConfig config = hands.first().settings();
  served_ = std::make_shared<DrawnScene>(config.scene);
  add_rosapi(hub_);
  add_hands();
  add_parameters();
  add_setup();
  add_library();
  listen(config.gateway);
}

void LiveGateway::Implementation::add_hands() {
  for (const LiveHands::Hand& hand : live_.all()) {
    LiveSystem& system = *hand.system;
    HandGateway::Surroundings around{hub_, notices_, elsewhere(), pages_.report, {}, {}, {}, {}, {}};
    around.describe = [this](Json& parameters) { describe(parameters); };
    around.stop = [&system] { system.stop_force(); };
    around.is_changing_scene = [this] { return live_.is_changing_scene(); };
    around.keeps_scene = [this] { return keeps_scene(); };
    around.uses_world = [this] { return live_.uses_world(); };
    if (hand.name.empty()) around.stop = [this] { live_.stop_force(); };  // stops all hands
    hands_.push_back(std::make_unique<HandGateway>(hand.name, system, std::move(around)));
  }
}

void LiveGateway::Implementation::listen(const GatewayConfig& options) {
  WebServerOptions server;
  server.uploads = uploads();
  server.address = options.address;
  server.real_time = kNetworkPriority;
  if (options.tls_certificate.empty() != options.tls_key.empty())
    throw Error("--tls-cert and --tls-key belong together: give both, or neither");
  server.tls_certificate = options.tls_certificate;
  server.tls_key = options.tls_key;
  server.token = options.token.empty() && !is_loopback(options.address) ? random_text() : options.token;
  server.tell = [this](const std::string& line) {
    server_->post([this, line] { notices_.tell(refused_origin_, line); });
  };
  const auto site = [this](const std::string& path) { return page(path); };
  const auto listen_at = [&](int port) {
    server.port = static_cast<std::uint16_t>(port);
    server_ = std::make_unique<WebServer>(hub_, site, server);
  };
  try {
    listen_at(options.port >= 0 ? options.port : GatewayConfig::kPort);
  } catch (const Error&) {
    if (options.port >= 0) throw;
    listen_at(0);  // the default port is in use, perhaps by another palpate
  }
}

Elsewhere LiveGateway::Implementation::elsewhere() {
  return [this](auto work, auto then) { server_->elsewhere(std::move(work), std::move(then)); };
}

void LiveGateway::Implementation::start() {
  for (const auto& hand : hands_) {
    hand->start();
    server_->when(hand->wake(), [hand = hand.get()] { hand->answer(); });
  }
  server_->every(LiveTopics::kRate, [this] { beat(); });
  server_->start();
}

void LiveGateway::Implementation::stop() { server_->stop(); }

void LiveGateway::Implementation::beat() {
  const std::shared_ptr<const FeltScene> felt = live_.first().felt();
  if (felt != felt_.lock()) {
    felt_list_.follow(felt->index());
    felt_ = felt;
    serve(*felt);
  }
  const auto list = felt_list_.newest();
  for (const auto& hand : hands_) hand->beat(list ? list->number : 0);
  if (beats_++ % LiveTopics::kContactsEvery == 0) publish_hands();
  look_at_scene();
  publish_lines();
}

/// Publishes the tools of all hands and the forces sent to them, for observers, if there are several hands.
void LiveGateway::Implementation::publish_hands() {
  if (hands_.size() < 2 || !hands_topic_.is_watched()) return;
  std::vector<Marker> markers;
  for (std::size_t k = 0; k < hands_.size(); ++k) {
    for (Marker& marker :
         hand_markers(hands_[k]->name(), k, hands_[k]->topics().tool(), hands_[k]->topics().newest()))
      markers.push_back(std::move(marker));
  }
  hands_topic_.publish(marker_array(header(Stamp::now(), "world", beats_), markers));
}

bool LiveGateway::Implementation::is_recording() const {
  return std::any_of(hands_.begin(), hands_.end(), [](const auto& hand) { return hand->is_recording(); });
}

void LiveGateway::Implementation::publish_lines() {
  Json lines;
  {
    const std::scoped_lock lock(mutex_);
    if (!std::exchange(said_more_, false)) return;
    lines = said_;
  }
  lines_topic_.publish({{"data", encode_json(lines)}});
}

void LiveGateway::Implementation::look_at_scene() {
  constexpr double kEvery = 1.0;  // s
  const double now = monotonic_now();
  const auto scene = served();
  if (!scene->file() || now - looked_at_scene_ < kEvery) return;
  looked_at_scene_ = std::numeric_limits<double>::infinity();  // no other check until this one has finished
  const auto change = std::make_shared<SceneFile::Change>();
  server_->elsewhere([change, scene] { *change = scene->file()->change(); },
                     [this, change, now, scene] {
                       looked_at_scene_ = now;
                       if (scene == served()) notices_.tell(scene_notice_, notice_of(*change));
                     });
}

void LiveGateway::Implementation::say(const std::string& line) {
  constexpr std::size_t kMostLines = 50;
  const std::scoped_lock lock(mutex_);
  said_.push_back(line);
  if (said_.size() > kMostLines) said_.erase(said_.begin());
  said_more_ = true;
}

/// Adds the scene, its touchable Gaussians, the other hands, and the notice about the scene.
void LiveGateway::Implementation::describe(Json& parameters) const {
  const auto scene = served();
  SceneConfig named;
  named.path = scene->path();
  const std::filesystem::path name(named.name());
  parameters["scene"] = {{"name", name.filename().string()},
                         {"format", name.extension() == ".splat" ? "splat" : "ply"},
                         {"bytes", scene->size()},
                         {"tag", scene->tag()},
                         {"url", "/scene"}};
  if (const auto list = felt_list_.newest()) {
    parameters["felt"] = {
        {"count", list->bytes.size() / sizeof(FeltGaussian)}, {"url", "/felt"}, {"tag", felt_tag(*list)}};
  }
  parameters["hands"] = Json::array();
  for (const auto& hand : hands_)
    if (!hand->name().empty()) parameters["hands"].push_back(hand->name());
  std::string message = parameters["message"].get<std::string>();
  if (!scene_notice_.empty()) message += (message.empty() ? "" : "; ") + scene_notice_;
  parameters["message"] = message;
}

/// Adds the service that proposes a setup. It reads the whole scene again, which is slow.
void LiveGateway::Implementation::add_setup() {
  const auto work = [](const LiveConfig& settings) {
    const std::string& path = settings.scene.path;
    const double radius = settings.tool.thinnest();
    return encode_json(setup_json<Json>(placed_as(path.empty() ? propose_setup(built_in_scene().scene, radius)
                                                               : propose_setup(load_scene(path), radius),
                                                  settings.scene)));
  };
  hub_.add_slow_service(
      "/palpate/propose_setup", "std_srvs/Trigger", [=, this](const Json&, const Reply& reply) {
        const auto answer = std::make_shared<Json>();
        server_->elsewhere(
            [=, settings = live_.first().settings()] { *answer = answer_of([&] { return work(settings); }); },
            [=] { reply.give(*answer); });
      });
}

/// Serves the scene of `felt` for drawing, if it is another one.
void LiveGateway::Implementation::serve(const FeltScene& felt) {
  if (felt.path() == served()->path()) return;
  SceneConfig scene;
  scene.path = felt.path();
  const auto made = std::make_shared<std::shared_ptr<DrawnScene>>();
  const auto failure = std::make_shared<std::string>();
  server_->elsewhere(
      [=] {
        try {
          *made = std::make_shared<DrawnScene>(scene);
        } catch (const std::exception& error) {
          *failure = error.what();
        }
      },
      [=, this] {
        if (*made) {
          const std::scoped_lock lock(mutex_);
          served_ = *made;
        }
        notices_.tell(scene_notice_, *failure);
        notices_.change();  // describe() returns something else now
      });
}

/// Returns why the scene and its placement must stay as they are, since a recording states them; empty if
/// they may change. Any thread.
std::string LiveGateway::Implementation::keeps_scene() const {
  if (!pages_.one_scene.empty()) return pages_.one_scene;
  return is_recording() ? "stop the recording before changing the scene or its placement" : "";
}

std::string LiveGateway::Implementation::open_from_library(const std::string& id) {
  live_.open_scene(library_.path_of(id));
  return {};
}

/// Adds the services of the scene library. Reading a folder may be slow.
void LiveGateway::Implementation::add_library() {
  const auto add = [this](const char* name, const char* type, std::function<std::string(const Json&)> work) {
    hub_.add_slow_service(name, type,
                          [work = std::move(work), this](const Json& arguments, const Reply& reply) {
                            const auto answer = std::make_shared<Json>();
                            server_->elsewhere([=] { *answer = answer_of([&] { return work(arguments); }); },
                                               [=] { reply.give(*answer); });
                          });
  };
  add("/palpate/list_scenes", "std_srvs/Trigger",
      [this](const Json&) { return encode_json(scenes_json(library_.list())); });
  add("/palpate/open_scene", "palpate/SetString", [this](const Json& arguments) {
    if (const std::string why = keeps_scene(); !why.empty()) throw Refusal(why);
    return open_from_library(text_field(arguments, "data"));
  });
}

/// PUT /scenes/NAME: a scene is opened once its upload is complete.
WebUploads LiveGateway::Implementation::uploads() {
  WebUploads uploads;
  uploads.folder = "/scenes/";
  uploads.place = [this, from = uploads.folder.size()](const std::string& path, std::uint64_t bytes) {
    if (const std::string why = keeps_scene(); !why.empty()) throw Error("{}", why);
    return library_.place_for(std::string_view(path).substr(from), bytes);
  };
  uploads.have = [this](const std::string& file) {
    // Uploads in use: the one being drawn, and the one that is felt or being opened.
    const std::vector<std::string> used{served()->path(), live_.first().settings().scene.path};
    if (is_recording()) {
      library_.have(file, used);
      return text_page(
          409, "upload complete; a recording has begun meanwhile: open the scene from the list after it");
    }
    live_.open_scene(file);
    library_.have(file, used);
    return text_page(200, "upload complete; opening the scene");
  };
  uploads.drop = [this](const std::string& file) { library_.drop(file); };
  return uploads;
}

/// Adds rosapi's parameter services. /palpate/NAME is a top-level name in the first hand's parameters,
/// /palpate/HAND/NAME one in those of a named hand.
void LiveGateway::Implementation::add_parameters() {
  hub_.add_service("/rosapi/get_param_names", "rosapi/GetParamNames", [this](const Json&) {
    Json names = Json::array();
    for (const auto& hand : hands_) {
      const std::string folder = hand->name().empty() ? "" : hand->name() + "/";
      const Json all = hand->parameters();
      for (const auto& [name, value] : all.items())
        names.push_back(fmt::format("{}{}{}", kFolder, folder, name));
    }
    return Json{{"names", std::move(names)}};
  });
  hub_.add_service("/rosapi/has_param", "rosapi/HasParam", [this](const Json& arguments) {
    const Parameter parameter = parameter_of(arguments);
    return Json{{"exists", parameter.hand.parameters().contains(parameter.name)}};
  });
  hub_.add_service("/rosapi/get_param", "rosapi/GetParam", [this](const Json& arguments) {
    const Parameter parameter = parameter_of(arguments);
    const Json all = parameter.hand.parameters();
    const auto at = all.find(parameter.name);
    const std::string missing = text_field(arguments, "default");
    return Json{{"value", at != all.end() ? encode_json(*at) : missing.empty() ? "null" : missing}};
  });
  hub_.add_service("/rosapi/set_param", "rosapi/SetParam", [this](const Json& arguments) {
    const Parameter parameter = parameter_of(arguments);
    try {
      parameter.hand.change({{parameter.name, decode_json(text_field(arguments, "value"))}});
    } catch (const Error& error) {
      throw Refusal(error.what());  // its answer has no field for the reason
    }
    return Json::object();
  });
}

LiveGateway::Implementation::Parameter LiveGateway::Implementation::parameter_of(
    const Json& arguments) const {
  std::string name = text_field(arguments, "name");
  if (name.starts_with(kFolder)) name.erase(0, kFolder.size());
  for (const auto& hand : hands_) {
    if (!hand->name().empty() && name.starts_with(hand->name() + "/"))
      return {*hand, name.substr(hand->name().size() + 1)};
  }
  return {first(), name};
}

WebPage LiveGateway::Implementation::page(const std::string& path) {
  if (const WebFile* file = pages_.viewer ? pages_.viewer(path) : nullptr) {
    WebPage page = page_of(file->type, file->bytes, file->tag);
    page.policy = kViewerPolicy;
    return page;
  }
  if (path == "/scene") return scene_page();
  if (path == "/felt") {
    const auto list = felt_list_.newest();
    if (!list) return text_page(503, "the list of Gaussians is not ready yet");
    return page_of("application/octet-stream", list->bytes, felt_tag(*list), list);
  }
  if (path == "/healthz") return health();
  if (path == "/metrics") return metrics();
  if (auto page = recording_page(path)) return *std::move(page);
  return text_page(404, "page not found; the viewer is at /");
}

/// Returns /recording or /recording.html; for a named hand, they are under /hands/NAME.
std::optional<WebPage> LiveGateway::Implementation::recording_page(const std::string& path) const {
  for (const auto& hand : hands_) {
    const std::string folder = hand->name().empty() ? "" : "/hands/" + hand->name();
    if (path != folder + "/recording" && path != folder + "/recording.html") continue;
    const RecordingSwitch::Recorded recorded = hand->recorded();
    const std::string tag = fmt::format("{}-{}", run_tag_, recorded.version);
    if (path.ends_with("g")) {
      if (!recorded.csv) return text_page(404, "nothing has been recorded yet");
      WebPage page = page_of("text/csv; charset=utf-8", {}, tag);
      page.file = recorded.csv;
      return page;
    }
    if (!recorded.page)
      return text_page(404, "nothing has been recorded yet, or the report is not ready yet");
    WebPage page = page_of("text/html; charset=utf-8", *recorded.page, tag, recorded.page);
    page.policy = kReportPolicy;
    return page;
  }
  return std::nullopt;
}

WebPage LiveGateway::Implementation::scene_page() {
  const auto scene = served();
  if (scene->wants_copy()) server_->elsewhere([scene] { scene->make_copy(); }, [] {});
  const DrawnScene::Served now = scene->served();
  if (!now.failure.empty()) return text_page(503, now.failure);
  if (now.is_coming) {
    WebPage page = text_page(503, "the scene is being prepared for display");
    page.retry_after = 1;
    return page;
  }
  WebPage page = page_of("application/octet-stream", now.bytes, now.tag, scene);
  page.file = now.file;
  return page;
}

WebPage LiveGateway::Implementation::health() {
  for (const auto& hand : hands_) {
    const double silence = hand->silence();
    if (silence > kPatience)
      return text_page(503,
                       fmt::format("{}the loop has not ticked for {:.1f} s", said_of(hand->name()), silence));
  }
  return text_page(200, "ok");
}

WebPage LiveGateway::Implementation::metrics() {
  std::vector<MetricsOfHand> all;
  for (const auto& hand : hands_) all.push_back(hand->metrics());
  WebPage page = text_page(200, metrics_text(all, hub_.client_count()));
  page.type = "text/plain; version=0.0.4; charset=utf-8";
  return page;
}

LiveGateway::LiveGateway(LiveHands& hands, GatewayPages pages)
    : implementation_(std::make_unique<Implementation>(hands, std::move(pages))) {}
LiveGateway::~LiveGateway() = default;
std::vector<TickObserver*> LiveGateway::observers(std::size_t hand) {
  return implementation_->observers(hand);
}
void LiveGateway::start() { implementation_->start(); }
void LiveGateway::stop() { implementation_->stop(); }
std::string LiveGateway::url() const { return implementation_->url(); }
std::vector<std::string> LiveGateway::take_notices() { return implementation_->take_notices(); }
void LiveGateway::say(const std::string& line) { implementation_->say(line); }

}  // namespace palpate
