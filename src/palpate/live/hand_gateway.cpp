#include <palpate/live/hand_gateway.h>

#include <new>
#include <utility>

#include <fmt/format.h>

#include <palpate/base/error.h>
#include <palpate/haptics/tool_file.h>
#include <palpate/live/config_json.h>
#include <palpate/live/config_toml.h>

namespace palpate {
namespace {

bool flag_of(const Json& arguments) {
  const Json& data = field(arguments, "data");
  if (!data.is_boolean()) throw Refusal("'data' must be true or false");
  return data.get<bool>();
}

constexpr const char* kChanging = "the scene is being changed; start recording when that is done";

/// Returns which registration parameters are assumed because nobody specified them.
Json assumed(const SceneConfig& scene) {
  Json names = Json::array();
  if (!scene.scale_known) names.emplace_back("scale");
  if (!scene.frame_known) names.emplace_back("frame");
  return names;
}

/// Marks the registration parameters in `wanted` as specified. \param wanted parameters set by a client
void know_registration(SceneConfig& scene, const Json& wanted) {
  const auto at = wanted.find("registration");
  if (at == wanted.end()) return;
  scene.scale_known = scene.scale_known || at->contains("scale");
  scene.frame_known = scene.frame_known || at->contains("frame");
}

}  // namespace

Json answer_of(const std::function<std::string()>& work) {
  try {
    return {{"success", true}, {"message", work()}};
  } catch (const Refusal& refusal) {
    return {{"success", false}, {"message", refusal.what()}};
  } catch (const Error& error) {
    return {{"success", false}, {"message", error.what()}};
  } catch (const std::bad_alloc&) {
    return {{"success", false}, {"message", "not enough memory"}};
  }
}

HandGateway::HandGateway(std::string name, LiveSystem& system, Surroundings around)
    : name_(std::move(name)),
      prefix_(name_.empty() ? "/palpate" : "/palpate/" + name_),
      system_(system),
      around_(std::move(around)),
      map_(system.settings().device.map),
      feed_(system.client_hand()),
      recording_(around_.elsewhere, around_.report, recorder_options(system.device())),
      parameters_topic_(around_.hub.add_topic(named("/parameters"), "std_msgs/String", true)) {
  add_switches();
  add_recording();
  add_settings();
}

void HandGateway::start() {
  topics_ = std::make_unique<LiveTopics>(around_.hub, feed_, system_.client_hand(), system_.clock(),
                                         system_.loop().statistics(), map_,
                                         system_.device_kind() == to_string(DeviceKind::kClient), prefix_);
  topics_->on_other_hand = [this] { system_.tick().governor().stop(Fault::kChanging); };
  topics_->stale_after = SafetyLimits::of(system_.device(), SafetyLimits().tick).stale_after;
  topics_->elsewhere = around_.elsewhere;
}

void HandGateway::beat(std::uint64_t shared) {
  const std::shared_ptr<const FeltScene> felt = system_.felt();
  if (felt != felt_.lock()) {
    topics_->feel(felt->index(), felt->tool());
    felt_ = felt;
  }
  topics_->publish();
  tick_for_pages_.back() = feed_.newest();
  tick_for_pages_.publish();
  look_at_recording();
  const Shown shown{system_.version(),
                    recording_.recorded().version,
                    shared,
                    around_.notices.version(),
                    recording_.is_on(),
                    is_paused(),
                    system_.tick().is_clutch_pressed(),
                    system_.moves_itself(),
                    may_place_scene()};
  if (shown != told_) parameters_topic_.publish({{"data", encode_json(parameters())}});
  told_ = shown;
}

/// Ends a recording that has failed, as on a full disk. Everything else continues.
void HandGateway::look_at_recording() {
  if (recording_.failure()) end_recording([](const std::string&) {});
}

void HandGateway::end_recording(RecordingSwitch::Done done) {
  recording_.end([this, done = std::move(done)](const std::string& failure) {
    const std::string of = name_.empty() ? "" : "of hand " + name_ + " ";
    if (!failure.empty())
      around_.notices.tell(
          recording_notice_,
          fmt::format("the recording {}was ended: {}; the rows until then are kept", of, failure));
    else if (const std::uint64_t lost = recording_.lost(); lost > 0)
      around_.notices.tell(recording_notice_,
                           fmt::format("the recording {}lacks {} ticks: the disk is too slow", of, lost));
    done(failure);
  });
}

/// Returns why the last change failed, and the notice about the recording.
std::string HandGateway::message() const {
  std::string all = system_.message();
  if (!recording_notice_.empty()) all += (all.empty() ? "" : "; ") + recording_notice_;
  return all;
}

/// Returns whether a page may scale and turn the scene without being asked to.
bool HandGateway::may_place_scene() const {
  return name_.empty() && around_.keeps_scene().empty() && !around_.uses_world();
}

Json HandGateway::parameters() const {
  const LiveConfig settings = system_.settings();
  const DeviceCapabilities& device = system_.device();
  Json json = settings_json(settings);
  json["registration"]["assumed"] = may_place_scene() ? assumed(settings.scene) : Json::array();
  json["models"] = kForceModelNames;
  json["frames"] = kUpAxisNames;
  json["hand"] = name_;
  json["stiffness_max"] = device.stiffness_max;
  json["device"] = {{"name", device.name},
                    {"kind", system_.device_kind()},
                    {"force_max", device.force_max},
                    {"torque_max", device.torque_max},
                    {"workspace", device.workspace}};
  json["paused"] = is_paused();
  json["clutch"] = system_.tick().is_clutch_pressed();
  if (system_.has_hand()) json["demo"] = system_.moves_itself();
  json["recording"] = recording_.is_on();
  json["recorded"] = recording_.recorded().page != nullptr;
  json["busy"] = system_.busy();
  json["message"] = message();
  around_.describe(json);
  return json;
}

/// Returns whether `wanted` moves, turns or scales the scene.
bool HandGateway::places_scene(const Json& wanted) const {
  LiveConfig settings = system_.settings();
  const Similarity placed = settings.scene.world_from_scene();
  change_settings(settings, wanted);
  return settings.scene.world_from_scene() != placed;
}

void HandGateway::change(const Json& wanted) {
  if (const std::string why = around_.keeps_scene(); !why.empty() && places_scene(wanted)) throw Refusal(why);
  system_.change([&](LiveConfig& settings) {
    change_settings(settings, wanted);
    know_registration(settings.scene, wanted);
  });
}

void HandGateway::add_switches() {
  const auto add = [this](const char* name, const char* type, std::function<void(const Json&)> work) {
    around_.hub.add_service(named(name), type, [work = std::move(work)](const Json& arguments) {
      return answer_of([&] {
        work(arguments);
        return std::string();
      });
    });
  };
  add("/emergency_stop", "std_srvs/Trigger", [this](const Json&) { around_.stop(); });
  add("/resume", "std_srvs/Trigger", [this](const Json&) { system_.resume(); });
  add("/pause", "std_srvs/SetBool", [this](const Json& arguments) {
    SafetyGovernor& governor = system_.tick().governor();
    flag_of(arguments) ? governor.stop(Fault::kPaused) : governor.unpause();
  });
  add("/demo", "std_srvs/SetBool", [this](const Json& arguments) {
    if (!system_.has_hand()) throw Refusal("the demo needs a simulated hand");
    const bool on = flag_of(arguments);
    if (on) topics_->let_go();
    system_.set_moves_itself(on);
  });
  add("/clutch", "std_srvs/SetBool",
      [this](const Json& arguments) { system_.tick().press_clutch(flag_of(arguments)); });
}

/// Adds the recording service. It responds once the file has been created or completed.
void HandGateway::add_recording() {
  around_.hub.add_slow_service(named("/record"), "std_srvs/SetBool",
                               [this](const Json& arguments, const Reply& reply) {
                                 const RecordingSwitch::Done done = [reply](const std::string& failure) {
                                   reply.give({{"success", failure.empty()}, {"message", failure}});
                                 };
                                 const Json begun = answer_of([&] {
                                   if (flag_of(arguments)) {
                                     if (around_.is_changing_scene()) throw Refusal(kChanging);
                                     recording_.begin([this] { return made_now(); }, done);
                                     around_.notices.tell(recording_notice_, "");
                                   } else {
                                     end_recording(done);
                                   }
                                   return std::string();
                                 });
                                 if (!begun["success"].get<bool>()) reply.give(begun);
                               });
}

/// Returns how a recording that begins now is made. Called on the Elsewhere thread, as scenes are opened.
std::string HandGateway::made_now() const {
  if (around_.is_changing_scene()) throw Error("{}", kChanging);
  return to_toml(system_.provenance("run"));
}

void HandGateway::add_settings() {
  const auto add = [this](const char* name, const char* type, std::function<std::string(const Json&)> work) {
    around_.hub.add_service(named(name), type, [work = std::move(work)](const Json& arguments) {
      return answer_of([&] { return work(arguments); });
    });
  };
  const auto change = [this](const Json& wanted) {
    this->change(wanted);
    return std::string();
  };
  add("/get_parameters", "std_srvs/Trigger", [this](const Json&) { return encode_json(parameters()); });
  add("/config", "std_srvs/Trigger", [this](const Json&) {
    return to_toml(system_.settings(), name_.empty() ? TomlFields::kSaved : TomlFields::kSavedOfHand);
  });
  add("/set_parameters", "palpate/SetParameters",
      [=](const Json& arguments) { return change(decode_json(text_field(arguments, "json"))); });
  add("/set_model", "palpate/SetString", [=](const Json& arguments) {
    return change({{"model", text_field(arguments, "data")}});
  });
  add("/load_tool", "palpate/SetString", [this](const Json& arguments) {
    const Tool tool = parse_tool("the tool", text_field(arguments, "data"));
    system_.change([&](LiveConfig& settings) { settings.tool = tool; });
    return std::string();
  });
}

MetricsOfHand HandGateway::metrics() {
  tick_for_pages_.update();
  return {name_, tick_for_pages_.front(), system_.loop().statistics()};
}

double HandGateway::silence() {
  tick_for_pages_.update();
  return system_.clock().now() - tick_for_pages_.front().record.t;
}

}  // namespace palpate
