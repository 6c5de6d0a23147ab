#include <palpate/live/live_gateway.h>

#include <atomic>
#include <filesystem>
#include <functional>
#include <limits>
#include <mutex>
#include <new>
#include <optional>
#include <utility>

#include <fmt/format.h>

#include <palpate/base/clock.h>
#include <palpate/base/error.h>
#include <palpate/base/latest_value.h>
#include <palpate/gateway/felt_list.h>
#include <palpate/gateway/live_topics.h>
#include <palpate/haptics/tool_file.h>
#include <palpate/live/config_json.h>
#include <palpate/live/config_toml.h>
#include <palpate/live/recording_switch.h>
#include <palpate/live/scene_file.h>
#include <palpate/live/scene_library.h>
#include <palpate/live/setup_json.h>
#include <palpate/rosbridge/access.h>
#include <palpate/rosbridge/web_server.h>
#include <palpate/scene/load_scene.h>
#include <palpate/scene/ply_writer.h>
#include <palpate/scene/scene_reader.h>

namespace palpate {
namespace {

/// Of the viewer: its own files, workers that it makes itself, and connections to where it came from.
constexpr const char* kViewerPolicy =
    "default-src 'none'; script-src 'self' 'wasm-unsafe-eval'; style-src 'self'; img-src 'self'; worker-src "
    "blob:; connect-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'";
/// Of a report, which has its own policy in the page, and needs what that allows.
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

bool flag_of(const Json& arguments) {
  const Json& data = field(arguments, "data");
  if (!data.is_boolean()) throw Refusal("'data' must be true or false");
  return data.get<bool>();
}

/// What of the registration nobody has said.
Json assumed(const SceneConfig& scene) {
  Json names = Json::array();
  if (!scene.scale_known) names.emplace_back("scale");
  if (!scene.frame_known) names.emplace_back("frame");
  return names;
}

/// \param wanted parameters that somebody has set
void know_registration(SceneConfig& scene, const Json& wanted) {
  const auto at = wanted.find("registration");
  if (at == wanted.end()) return;
  scene.scale_known = scene.scale_known || at->contains("scale");
  scene.frame_known = scene.frame_known || at->contains("frame");
}

/// std_srvs/Trigger, SetBool: what was refused is an answer, too.
Json answer_of(const std::function<std::string()>& work) {
  try {
    return {{"success", true}, {"message", work()}};
  } catch (const Refusal& refusal) {
    return {{"success", false}, {"message", refusal.what()}};
  } catch (const Error& error) {
    return {{"success", false}, {"message", error.what()}};
  } catch (const std::bad_alloc&) {
    return {{"success", false}, {"message", "not enough memory for that"}};
  }
}

}  // namespace

/// The scene that is drawn: its file, or the bytes of the built-in one. Immutable.
struct ServedScene {
  std::string path;                       ///< SceneConfig::path
  std::unique_ptr<const SceneFile> file;  ///< null: the built-in scene
  std::string bytes;                      ///< that

  /// \throws Error if the file cannot be read.
  explicit ServedScene(const SceneConfig& scene) : path(scene.path) {
    if (path.empty()) {
      bytes = ply_bytes(built_in_scene().scene, "palpate: " + scene.name());
    } else {
      file = std::make_unique<SceneFile>(path);
    }
  }
  std::uint64_t size() const { return file ? file->bytes()->size() : bytes.size(); }
  std::string tag() const { return file ? file->tag() : "built-in"; }
};

/// What says nothing else is done on the server's thread, which has poses to hand over and waits for nothing.
class LiveGateway::Implementation {
 public:
  Implementation(LiveSystem& system, GatewayPages pages);
  ~Implementation() { stop(); }
  Implementation(const Implementation&) = delete;
  Implementation& operator=(const Implementation&) = delete;

  std::vector<TickObserver*> observers() { return {&feed_, &recording_}; }
  void start();
  void stop();

  std::string url() const { return server_->url(); }
  /// Any thread.
  std::vector<std::string> take_notices();
  void say(const std::string& line);

 private:
  /// What parameters() depends on.
  struct Shown {
    std::uint64_t system = 0, recorded = 0, felt = 0, notices = 0;  ///< numbers of their versions
    bool records = false, paused = false, moves_itself = false;
    bool operator==(const Shown&) const = default;
  };

  Elsewhere elsewhere();
  void add_services();
  void add_switches();
  void add_recording();
  void add_parameters();
  void add_setup();
  void add_library();
  void serve(const FeltScene& felt);
  std::string open_from_library(const std::string& id);
  WebUploads uploads();
  std::shared_ptr<const ServedScene> served() const {
    const std::scoped_lock lock(mutex_);
    return served_;
  }
  void beat();
  void publish_lines();
  void look_at_recording();
  void look_at_scene();
  void end_recording(RecordingSwitch::Done done);
  void tell(std::string& notice, const std::string& text);
  std::string message() const;
  Json parameters() const;
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
  GatewayPages pages_;
  WorkspaceMap map_;
  Hub hub_;
  TickFeed feed_;
  LatestValue<TickFeed::Tick> tick_for_pages_;
  RecordingSwitch recording_;
  FeltListMaker felt_list_;
  Topic &parameters_topic_, &lines_topic_;
  std::unique_ptr<LiveTopics> topics_;
  std::unique_ptr<WebServer> server_;
  SceneLibrary library_;
  std::atomic<bool> records_ = false;    ///< recording_.is_on(), for other threads
  std::string run_tag_;                  ///< of what this run makes, unlike that of all other runs
  std::optional<Shown> told_;            ///< to clients
  std::weak_ptr<const FeltScene> felt_;  ///< what the topics are of; not kept alive here
  double looked_at_scene_ = 0.0;         ///< Unit: [s].
  std::string recording_notice_, scene_notice_;
  std::uint64_t notices_ = 0;  ///< how often they have changed
  mutable std::mutex mutex_;   ///< of what follows
  std::vector<std::string> untold_;
  std::vector<std::string> said_;              ///< on the terminal; the newest kMostLines
  bool said_more_ = false;                     ///< than clients know
  std::shared_ptr<const ServedScene> served_;  ///< never null
};

LiveGateway::Implementation::Implementation(LiveSystem& system, GatewayPages pages)
    : system_(system),
      pages_(std::move(pages)),
      map_(system.settings().device.map),
      feed_(system.client_hand()),
      recording_(elsewhere(), pages_.report, recorder_options(system.device())),
      felt_list_(elsewhere()),
      parameters_topic_(hub_.add_topic("/palpate/parameters", "std_msgs/String", true)),
      lines_topic_(hub_.add_topic("/palpate/messages", "std_msgs/String", true)),
      library_(pages_.scene_folders, system.settings().scene.path),
      run_tag_(random_text()) {
  const LiveConfig config = system.settings();
  const GatewayConfig& options = config.gateway;
  served_ = std::make_shared<const ServedScene>(config.scene);
  add_rosapi(hub_);
  add_switches();
  add_recording();
  add_services();
  add_parameters();
  add_setup();
  add_library();

  WebServerOptions server;
  server.uploads = uploads();
  server.address = options.address;
  server.real_time = ThreadPriority{.priority = ThreadPriority().priority - 10, .cpu = {}};  // below the loop
  if (options.tls_certificate.empty() != options.tls_key.empty())
    throw Error("--tls-cert and --tls-key belong together: give both, or neither");
  server.tls_certificate = options.tls_certificate;
  server.tls_key = options.tls_key;
  server.token = options.token.empty() && !is_loopback(options.address) ? random_text() : options.token;
  const auto site = [this](const std::string& path) { return page(path); };
  const auto listen = [&](int port) {
    server.port = static_cast<std::uint16_t>(port);
    server_ = std::make_unique<WebServer>(hub_, site, server);
  };
  try {
    listen(options.port >= 0 ? options.port : GatewayConfig::kPort);
  } catch (const Error&) {
    if (options.port >= 0) throw;
    listen(0);  // somebody else has the usual one, another palpate perhaps
  }
}

Elsewhere LiveGateway::Implementation::elsewhere() {
  return [this](auto work, auto then) { server_->elsewhere(std::move(work), std::move(then)); };
}

void LiveGateway::Implementation::start() {
  topics_ = std::make_unique<LiveTopics>(hub_, feed_, system_.client_hand(), system_.clock(),
                                         system_.loop().statistics(), map_,
                                         system_.device_kind() == to_string(DeviceKind::kClient));
  topics_->on_other_hand = [this] { system_.tick().governor().stop(Fault::kChanging); };
  topics_->stale_after = SafetyLimits::of(system_.device(), SafetyLimits().tick).stale_after;
  topics_->elsewhere = elsewhere();
  server_->every(LiveTopics::kRate, [this] { beat(); });
  server_->when(feed_.wake(), [this] { topics_->answer(); });
  server_->start();
}

void LiveGateway::Implementation::stop() { server_->stop(); }

void LiveGateway::Implementation::beat() {
  const std::shared_ptr<const FeltScene> felt = system_.felt();
  if (felt != felt_.lock()) {
    topics_->feel(felt->index(), felt->tool());
    felt_list_.follow(felt->index());
    felt_ = felt;
    serve(*felt);
  }
  topics_->publish();
  tick_for_pages_.back() = feed_.newest();
  tick_for_pages_.publish();
  look_at_recording();
  look_at_scene();
  records_ = recording_.is_on();
  const auto list = felt_list_.newest();
  const Shown shown{
      system_.version(), recording_.recorded().version, list ? list->number : 0, notices_, recording_.is_on(),
      is_paused(),       system_.moves_itself()};
  if (shown != told_) parameters_topic_.publish({{"data", encode_json(parameters())}});
  told_ = shown;
  publish_lines();
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

/// A disk that is full ends a recording. All else goes on.
void LiveGateway::Implementation::look_at_recording() {
  if (recording_.failure()) end_recording([](const std::string&) {});
}

void LiveGateway::Implementation::end_recording(RecordingSwitch::Done done) {
  recording_.end([this, done = std::move(done)](const std::string& failure) {
    if (!failure.empty())
      tell(recording_notice_,
           fmt::format("the recording has ended: {}; what it has until then is there", failure));
    done(failure);
  });
}

void LiveGateway::Implementation::look_at_scene() {
  constexpr double kEvery = 1.0;  // s
  const double now = monotonic_now();
  const auto scene = served();
  if (!scene->file || now - looked_at_scene_ < kEvery) return;
  looked_at_scene_ = std::numeric_limits<double>::infinity();  // not before it is known
  const auto change = std::make_shared<SceneFile::Change>();
  server_->elsewhere([change, scene] { *change = scene->file->change(); },
                     [this, change, now, scene] {
                       looked_at_scene_ = now;
                       if (scene == served()) tell(scene_notice_, notice_of(*change));
                     });
}

void LiveGateway::Implementation::tell(std::string& notice, const std::string& text) {
  if (notice == text) return;
  notice = text;
  ++notices_;
  if (text.empty()) return;
  const std::scoped_lock lock(mutex_);
  untold_.push_back(text);
}

std::vector<std::string> LiveGateway::Implementation::take_notices() {
  const std::scoped_lock lock(mutex_);
  return std::exchange(untold_, {});
}

void LiveGateway::Implementation::say(const std::string& line) {
  constexpr std::size_t kMostLines = 50;
  const std::scoped_lock lock(mutex_);
  said_.push_back(line);
  if (said_.size() > kMostLines) said_.erase(said_.begin());
  said_more_ = true;
}

/// What was refused last, and what still holds.
std::string LiveGateway::Implementation::message() const {
  std::string all = system_.message();
  for (const std::string& notice : {recording_notice_, scene_notice_}) {
    if (!notice.empty()) all += (all.empty() ? "" : "; ") + notice;
  }
  return all;
}

Json LiveGateway::Implementation::parameters() const {
  const LiveConfig settings = system_.settings();
  const DeviceCapabilities& device = system_.device();
  Json json = settings_json(settings);
  const auto scene = served();
  SceneConfig named;
  named.path = scene->path;
  const std::filesystem::path name(named.name());
  json["scene"] = {{"name", name.filename().string()},
                   {"format", name.extension() == ".splat" ? "splat" : "ply"},
                   {"bytes", scene->size()},
                   {"tag", scene->tag()},
                   {"url", "/scene"}};
  json["registration"]["assumed"] = assumed(settings.scene);
  if (const auto list = felt_list_.newest()) {
    json["felt"] = {
        {"count", list->bytes.size() / sizeof(FeltGaussian)}, {"url", "/felt"}, {"tag", felt_tag(*list)}};
  }
  json["models"] = kForceModelNames;
  json["frames"] = kUpAxisNames;
  json["stiffness_max"] = device.stiffness_max;
  json["device"] = {{"name", device.name},
                    {"kind", system_.device_kind()},
                    {"force_max", device.force_max},
                    {"torque_max", device.torque_max},
                    {"workspace", device.workspace}};
  json["paused"] = is_paused();
  if (system_.has_hand()) json["demo"] = system_.moves_itself();
  json["recording"] = recording_.is_on();
  json["recorded"] = recording_.recorded().page != nullptr;
  json["busy"] = system_.busy();
  json["message"] = message();
  return json;
}

void LiveGateway::Implementation::add_switches() {
  const auto add = [this](const char* name, const char* type, std::function<void(const Json&)> work) {
    hub_.add_service(name, type, [work = std::move(work)](const Json& arguments) {
      return answer_of([&] {
        work(arguments);
        return std::string();
      });
    });
  };
  add("/palpate/emergency_stop", "std_srvs/Trigger", [this](const Json&) { system_.stop_force(); });
  add("/palpate/resume", "std_srvs/Trigger", [this](const Json&) { system_.resume(); });
  add("/palpate/pause", "std_srvs/SetBool", [this](const Json& arguments) {
    SafetyGovernor& governor = system_.tick().governor();
    flag_of(arguments) ? governor.stop(Fault::kPaused) : governor.unpause();
  });
  add("/palpate/demo", "std_srvs/SetBool", [this](const Json& arguments) {
    if (!system_.has_hand()) throw Refusal("only a simulated hand moves by itself");
    const bool on = flag_of(arguments);
    if (on) topics_->let_go();
    system_.set_moves_itself(on);
  });
  add("/palpate/clutch", "std_srvs/SetBool",
      [this](const Json& arguments) { system_.tick().press_clutch(flag_of(arguments)); });
}

/// Answered once the file is there, or whole.
void LiveGateway::Implementation::add_recording() {
  hub_.add_slow_service("/palpate/record", "std_srvs/SetBool",
                        [this](const Json& arguments, const Reply& reply) {
                          const RecordingSwitch::Done done = [reply](const std::string& failure) {
                            reply.give({{"success", failure.empty()}, {"message", failure}});
                          };
                          const Json begun = answer_of([&] {
                            if (flag_of(arguments)) {
                              recording_.begin([this] { return to_toml(system_.provenance("run")); }, done);
                              tell(recording_notice_, "");
                            } else {
                              end_recording(done);
                            }
                            return std::string();
                          });
                          if (!begun["success"].get<bool>()) reply.give(begun);
                        });
}

void LiveGateway::Implementation::add_services() {
  const auto add = [this](const char* name, const char* type, std::function<std::string(const Json&)> work) {
    hub_.add_service(name, type, [work = std::move(work)](const Json& arguments) {
      return answer_of([&] { return work(arguments); });
    });
  };
  const auto change = [this](const Json& wanted) {
    system_.change([&](LiveConfig& settings) {
      change_settings(settings, wanted);
      know_registration(settings.scene, wanted);
    });
    return std::string();
  };
  add("/palpate/get_parameters", "std_srvs/Trigger",
      [this](const Json&) { return encode_json(parameters()); });
  add("/palpate/config", "std_srvs/Trigger",
      [this](const Json&) { return to_toml(system_.settings(), TomlFields::kSaved); });
  add("/palpate/set_parameters", "palpate/SetParameters",
      [=](const Json& arguments) { return change(decode_json(text_field(arguments, "json"))); });
  add("/palpate/set_model", "palpate/SetString", [=](const Json& arguments) {
    return change({{"model", text_field(arguments, "data")}});
  });
  add("/palpate/load_tool", "palpate/SetString", [this](const Json& arguments) {
    const Tool tool = parse_tool("the tool", text_field(arguments, "data"));
    system_.change([&](LiveConfig& settings) { settings.tool = tool; });
    return std::string();
  });
}

/// Reads the whole scene again, which takes long.
void LiveGateway::Implementation::add_setup() {
  const auto work = [](const LiveConfig& settings) {
    const std::string& path = settings.scene.path;
    const double radius = settings.tool.thinnest();
    return encode_json(setup_json<Json>(path.empty() ? propose_setup(built_in_scene().scene, radius)
                                                     : propose_setup(load_scene(path), radius)));
  };
  hub_.add_slow_service(
      "/palpate/propose_setup", "std_srvs/Trigger", [=, this](const Json&, const Reply& reply) {
        const auto answer = std::make_shared<Json>();
        server_->elsewhere(
            [=, settings = system_.settings()] { *answer = answer_of([&] { return work(settings); }); },
            [=] { reply.give(*answer); });
      });
}

/// Draws what is felt, once it is another scene.
void LiveGateway::Implementation::serve(const FeltScene& felt) {
  if (felt.path() == served()->path) return;
  SceneConfig scene;
  scene.path = felt.path();
  const auto made = std::make_shared<std::shared_ptr<const ServedScene>>();
  const auto failure = std::make_shared<std::string>();
  server_->elsewhere(
      [=] {
        try {
          *made = std::make_shared<const ServedScene>(scene);
        } catch (const std::exception& error) {
          *failure = error.what();
        }
      },
      [=, this] {
        if (*made) {
          const std::scoped_lock lock(mutex_);
          served_ = *made;
        }
        tell(scene_notice_, *failure);
        ++notices_;  // what the parameters say of it is another
      });
}

std::string LiveGateway::Implementation::open_from_library(const std::string& id) {
  if (!pages_.one_scene.empty()) throw Refusal(pages_.one_scene);
  const std::string path = library_.path_of(id);
  if (!path.empty()) open_scene(path);  // throws for what is no scene, before the one that is felt goes
  system_.open_scene(path);
  return {};
}

/// Reading a folder may take long.
void LiveGateway::Implementation::add_library() {
  const auto add = [this](const char* name, const char* type, std::function<std::string(const Json&)> work) {
    hub_.add_slow_service(name, type,
                          [work = std::move(work), this](const Json& arguments, const Reply& reply) {
                            const auto answer = std::make_shared<Json>();
                            server_->elsewhere([=] { *answer = answer_of([&] { return work(arguments); }); },
                                               [=] { reply.give(*answer); });
                          });
  };
  add("/palpate/list_scenes", "std_srvs/Trigger", [this](const Json&) {
    Json list = Json::array();
    for (const SceneLibrary::Entry& entry : library_.list())
      list.push_back(
          {{"id", entry.id}, {"name", entry.name}, {"bytes", entry.bytes}, {"refusal", entry.refusal}});
    return encode_json(list);
  });
  add("/palpate/open_scene", "palpate/SetString", [this](const Json& arguments) {
    if (records_) throw Refusal("a recording is of one scene: end it first");
    return open_from_library(text_field(arguments, "data"));
  });
}

/// PUT /scenes/NAME: a scene that is handed over is felt once it is there.
WebUploads LiveGateway::Implementation::uploads() {
  WebUploads uploads;
  uploads.folder = "/scenes/";
  uploads.place = [this, from = uploads.folder.size()](const std::string& path, std::uint64_t bytes) {
    if (!pages_.one_scene.empty()) throw Error("{}", pages_.one_scene);
    if (records_) throw Error("a recording is of one scene: end it first");
    return library_.place_for(std::string_view(path).substr(from), bytes);
  };
  uploads.have = [this](const std::string& file) {
    open_scene(file);  // throws for what is no scene
    system_.open_scene(file);
    library_.have(file, served()->path);
    return text_page(200, "it is being opened");
  };
  uploads.drop = [this](const std::string& file) { library_.drop(file); };
  return uploads;
}

/// ROS parameters: /palpate/NAME, one for each name at the top of parameters().
void LiveGateway::Implementation::add_parameters() {
  constexpr std::string_view kPrefix = "/palpate/";
  const auto name_of = [=](const Json& arguments) {
    const std::string name = text_field(arguments, "name");
    return name.starts_with(kPrefix) ? name.substr(kPrefix.size()) : name;
  };
  hub_.add_service("/rosapi/get_param_names", "rosapi/GetParamNames", [=, this](const Json&) {
    Json names = Json::array();
    const Json all = parameters();
    for (const auto& [name, value] : all.items()) names.push_back(std::string(kPrefix) + name);
    return Json{{"names", std::move(names)}};
  });
  hub_.add_service("/rosapi/has_param", "rosapi/HasParam", [=, this](const Json& arguments) {
    return Json{{"exists", parameters().contains(name_of(arguments))}};
  });
  hub_.add_service("/rosapi/get_param", "rosapi/GetParam", [=, this](const Json& arguments) {
    const Json all = parameters();
    const auto at = all.find(name_of(arguments));
    const std::string missing = text_field(arguments, "default");
    return Json{{"value", at != all.end() ? encode_json(*at) : missing.empty() ? "null" : missing}};
  });
  hub_.add_service("/rosapi/set_param", "rosapi/SetParam", [=, this](const Json& arguments) {
    const Json wanted{{name_of(arguments), decode_json(text_field(arguments, "value"))}};
    system_.change([&](LiveConfig& settings) {
      change_settings(settings, wanted);
      know_registration(settings.scene, wanted);
    });
    return Json::object();
  });
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
    if (!list) return text_page(503, "what can be felt is still being looked for");
    return page_of("application/octet-stream", list->bytes, felt_tag(*list), list);
  }
  if (path == "/healthz") return health();
  if (path == "/metrics") return metrics();
  const RecordingSwitch::Recorded recorded = recording_.recorded();
  const std::string tag = fmt::format("{}-{}", run_tag_, recorded.version);
  if (path == "/recording") {
    if (!recorded.csv) return text_page(404, "nothing has been recorded yet");
    WebPage page = page_of("text/csv; charset=utf-8", {}, tag);
    page.file = recorded.csv;
    return page;
  }
  if (path == "/recording.html") {
    if (!recorded.page) return text_page(404, "nothing has been recorded yet, or its report is being made");
    WebPage page = page_of("text/html; charset=utf-8", *recorded.page, tag, recorded.page);
    page.policy = kReportPolicy;
    return page;
  }
  return text_page(404, "there is nothing here; the viewer is at /");
}

WebPage LiveGateway::Implementation::scene_page() const {
  constexpr const char* kType = "application/octet-stream";
  const auto scene = served();
  if (!scene->file) return page_of(kType, scene->bytes, scene->tag(), scene);
  const SceneFile::Change change = scene->file->change();
  if (change == SceneFile::Change::kOverwritten) return text_page(503, notice_of(change));
  WebPage page = page_of(kType, {}, scene->tag());
  page.file = scene->file->bytes();
  return page;
}

WebPage LiveGateway::Implementation::health() {
  constexpr double kPatience = 0.5;  // s
  tick_for_pages_.update();
  const double age = system_.clock().now() - tick_for_pages_.front().record.t;
  if (age <= kPatience) return text_page(200, "ok");
  return text_page(503, fmt::format("the loop has not ticked for {:.1f} s", age));
}

/// The text format of Prometheus.
WebPage LiveGateway::Implementation::metrics() {
  tick_for_pages_.update();
  const auto& [tick, times, answers] = tick_for_pages_.front();
  const LoopStatistics& statistics = system_.loop().statistics();
  std::string text;
  const auto add = [&](std::string_view name, std::string_view type, std::string_view help, double value) {
    text += fmt::format("# HELP palpate_{0} {2}\n# TYPE palpate_{0} {1}\npalpate_{0} {3}\n", name, type, help,
                        value);
  };
  add("ticks_total", "counter", "Ticks of the servo loop.", static_cast<double>(statistics.ticks.load()));
  add("overruns_total", "counter", "Ticks that were left out.",
      static_cast<double>(statistics.overruns.load()));
  text += "# HELP palpate_tick_seconds Time that a tick took.\n# TYPE palpate_tick_seconds summary\n";
  for (const double q : {0.5, 0.99, 0.999})
    text += fmt::format("palpate_tick_seconds{{quantile=\"{}\"}} {}\n", q, statistics.whole.quantile(q));
  text += fmt::format("palpate_tick_seconds_count {}\n", statistics.ticks.load());
  add("force_newtons", "gauge", "Force that the device is sent.", tick.sent.force.norm());
  add("torque_newton_metres", "gauge", "Torque that the device is sent.", tick.sent.torque.norm());
  add("contacts", "gauge", "Gaussians that the tool touches.", static_cast<double>(tick.contacts));
  add("stiffness_margin", "gauge", "How many times as stiff the spring might be; 0: unknown.", tick.margin);
  add("port_energy_joules", "gauge", "Net energy that the device has put into the hand.", tick.energy);
  add("force_age_seconds", "gauge", "Age of the pose that the force answers.", times.age);
  add("active", "gauge", "1 while the governor lets all of the force through.",
      tick.state == GovernorState::kActive ? 1.0 : 0.0);
  add("clients", "gauge", "WebSocket clients.", static_cast<double>(hub_.client_count()));
  text.pop_back();  // text_page() ends the last line
  WebPage page = text_page(200, text);
  page.type = "text/plain; version=0.0.4; charset=utf-8";
  return page;
}

LiveGateway::LiveGateway(LiveSystem& system, GatewayPages pages)
    : implementation_(std::make_unique<Implementation>(system, std::move(pages))) {}
LiveGateway::~LiveGateway() = default;
std::vector<TickObserver*> LiveGateway::observers() { return implementation_->observers(); }
void LiveGateway::start() { implementation_->start(); }
void LiveGateway::stop() { implementation_->stop(); }
std::string LiveGateway::url() const { return implementation_->url(); }
std::vector<std::string> LiveGateway::take_notices() { return implementation_->take_notices(); }
void LiveGateway::say(const std::string& line) { implementation_->say(line); }

}  // namespace palpate
