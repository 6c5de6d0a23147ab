#include <palpate/gateway/live_topics.h>

#include <fmt/format.h>

namespace palpate {
namespace {

constexpr double kMilli = 1e3, kMicro = 1e6;
constexpr const char* kWorld = "world";
constexpr Color kToolColor{0.04, 0.34, 0.77, 0.35};

/// diagnostic_msgs/DiagnosticStatus: what passes by itself is a warning.
int level_of(const TickRecord& tick) {
  if (tick.fault == Fault::kNone) return 0;
  return traits(tick.fault).latched ? 2 : 1;
}

}  // namespace

LiveTopics::LiveTopics(Hub& hub, TickFeed& feed, ClientHand& hand, const LoopClock& clock,
                       const LoopStatistics& statistics, const WorkspaceMap& map, bool client_is_device)
    : hub_(hub),
      feed_(feed),
      hand_(hand),
      clock_(clock),
      statistics_(statistics),
      map_(map),
      client_is_device_(client_is_device),
      pose_(hub.add_topic("/palpate/measured_cp", "geometry_msgs/PoseStamped")),
      velocity_(hub.add_topic("/palpate/measured_cv", "geometry_msgs/TwistStamped")),
      spatial_(hub.add_topic("/palpate/spatial/servo_cf", "geometry_msgs/WrenchStamped")),
      body_(hub.add_topic("/palpate/body/servo_cf", "geometry_msgs/WrenchStamped")),
      proxy_(hub.add_topic("/palpate/proxy_cp", "geometry_msgs/PoseStamped")),
      contacts_(hub.add_topic("/palpate/contacts", "visualization_msgs/MarkerArray")),
      tool_topic_(hub.add_topic("/palpate/tool", "visualization_msgs/MarkerArray")),
      diagnostics_(hub.add_topic("/palpate/diagnostics", "diagnostic_msgs/DiagnosticArray")),
      client_(hub.add_topic("/palpate/client/servo_cf", "geometry_msgs/WrenchStamped")) {
  contacts_.set_reset(ContactMarkers::reset(header({}, kWorld, 0)), ContactMarkers::kReach);
  hub.add_input("/palpate/client/measured_cp", "geometry_msgs/PoseStamped",
                [this](const Json& message, Client& from) { take(message, from); });
  hub.on_leave = [this](const Client& gone) {
    if (&gone == holder_) release();
  };
}

void LiveTopics::feel(std::shared_ptr<const SceneIndex> index, const Tool& tool) {
  if (index != index_) ellipsoids_.reset();
  index_ = std::move(index);
  tool_ = tool;
}

void LiveTopics::take(const Json& message, Client& from) {
  const StampedPose said = pose_stamped(message);
  if (holder_ != nullptr && holder_ != &from)
    throw Refusal("another client holds the tool; it is free a second after that is silent");
  const bool world = said.frame.empty() ? !client_is_device_ : said.frame == kWorld;
  const Pose device = world ? map_.to_device(said.pose) : said.pose;
  holder_ = &from;
  held_at_ = clock_.now();
  stamps_[hand_.put(device, held_at_) % stamps_.size()] = said.stamp;
}

void LiveTopics::release() {
  holder_ = nullptr;
  hand_.let_go();
}

void LiveTopics::publish_wrenches(const Stamp& stamp, Client* only) {
  const TickRecord& tick = feed_.newest().record;
  const auto send = [&](Topic& topic, const Json& message) {
    only != nullptr ? topic.publish_to(*only, message) : topic.publish(message, holder_);
  };
  const auto message = [&](const Wrench& wrench, const char* frame, const Stamp& when) {
    return Json{{"header", header(when, frame, feed_.newest().answers)}, {"wrench", to_json(wrench)}};
  };
  if (client_.is_watched())
    send(client_,
         message(tick.sent, "device", only != nullptr ? stamps_[answered_ % stamps_.size()] : stamp));
  if (!spatial_.is_watched() && !body_.is_watched()) return;
  // Torques as forces: what the device shows, along the axes of the world.
  const Wrench world{tick.sent_force, map_.rotation * tick.sent.torque};
  if (spatial_.is_watched()) send(spatial_, message(world, kWorld, stamp));
  const Eigen::Quaterniond back = tick.tool.orientation.conjugate();
  if (body_.is_watched()) send(body_, message({back * world.force, back * world.torque}, "tool", stamp));
}

void LiveTopics::answer() {
  feed_.wake().clear();
  feed_.update();
  if (holder_ == nullptr || feed_.newest().answers == answered_) return;
  answered_ = feed_.newest().answers;
  publish_wrenches(Stamp::now(), holder_);
}

void LiveTopics::publish() {
  if (holder_ != nullptr && clock_.now() - held_at_ > kSilence) release();
  feed_.update();
  const TickRecord& tick = feed_.newest().record;
  const Stamp stamp = Stamp::now();
  const Json head = header(stamp, kWorld, count_);
  if (pose_.is_watched()) pose_.publish({{"header", head}, {"pose", to_json(tick.tool)}});
  if (velocity_.is_watched()) velocity_.publish({{"header", head}, {"twist", to_json(tick.velocity)}});
  if (proxy_.is_watched()) proxy_.publish({{"header", head}, {"pose", to_json(tick.felt.proxy)}});
  publish_wrenches(stamp, nullptr);
  if (tool_topic_.is_watched()) publish_tool(stamp);
  if (count_ % kContactsEvery == 0 && contacts_.is_watched()) publish_contacts(stamp);
  if (count_ % kDiagnosticsEvery == 0) {
    watch_rate();
    if (diagnostics_.is_watched()) publish_diagnostics(stamp);
  }
  ++count_;
}

void LiveTopics::publish_contacts(const Stamp& stamp) {
  if (!index_) return;
  if (!ellipsoids_) ellipsoids_ = std::make_unique<EllipsoidLookup>(*index_);
  query(*index_, tool_, feed_.newest().record.tool, found_);
  contacts_.publish(markers_.message(header(stamp, kWorld, count_), found_.contacts, *ellipsoids_));
}

void LiveTopics::publish_tool(const Stamp& stamp) {
  const Json head = header(stamp, kWorld, count_);
  Json markers = Json::array();
  std::uint32_t id = 0;
  for (const ToolPart& part : tool_.parts())
    markers.push_back(ellipsoid_marker(head, "tool", id++, part.at(feed_.newest().record.tool), kToolColor));
  tool_topic_.publish({{"markers", std::move(markers)}});
}

void LiveTopics::watch_rate() {
  constexpr double kLeast = 0.5;  // s
  const double now = clock_.now();
  if (now - ticks_at_ < kLeast) return;
  const std::uint64_t ticks = statistics_.ticks.load(std::memory_order_relaxed);
  rate_ = static_cast<double>(ticks - ticks_) / (now - ticks_at_);
  ticks_ = ticks;
  ticks_at_ = now;
}

void LiveTopics::publish_diagnostics(const Stamp& stamp) {
  const auto& [tick, times, answers] = feed_.newest();
  Json values = Json::array();
  const auto text = [&](const char* key, std::string_view value) {
    values.push_back({{"key", key}, {"value", value}});
  };
  const auto number = [&](const char* key, double value) { text(key, fmt::format("{:.6g}", value)); };
  text("state", to_string(tick.state));
  text("fault", tick.fault == Fault::kNone ? "" : traits(tick.fault).name);
  text("advice", tick.fault == Fault::kNone ? "" : traits(tick.fault).advice);
  text("held_by", is_held() ? "client" : "");
  number("rate_hz", rate_);
  number("tick_us", kMicro * times.whole);
  number("tick_p50_us", kMicro * statistics_.whole.quantile(0.5));
  number("tick_p99_us", kMicro * statistics_.whole.quantile(0.99));
  number("age_us", kMicro * times.age);
  number("overruns", static_cast<double>(times.overruns));
  number("contacts", static_cast<double>(tick.contacts));
  number("candidates", static_cast<double>(tick.candidates));
  number("k_max", tick.k_max);
  number("force_n", tick.sent.force.norm());
  number("torque_nm", tick.sent.torque.norm());
  number("margin", tick.margin);
  number("energy_mj", kMilli * tick.energy);
  number("stored_mj", std::isnan(tick.felt.stored) ? 0.0 : kMilli * tick.felt.stored);
  number("put_out_mj", kMilli * tick.put_out);
  number("damping", tick.added_damping);
  number("clients", static_cast<double>(hub_.client_count()));
  Json status{{"level", level_of(tick)},
              {"name", "palpate: servo"},
              {"message", tick.fault == Fault::kNone ? to_string(tick.state) : traits(tick.fault).name},
              {"hardware_id", ""},
              {"values", std::move(values)}};
  diagnostics_.publish({{"header", header(stamp, "", count_)}, {"status", Json::array({std::move(status)})}});
}

}  // namespace palpate
