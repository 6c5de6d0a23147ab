#include <palpate/gateway/live_topics.h>

#include <algorithm>
#include <new>
#include <utility>

#include <fmt/format.h>

#include <palpate/gateway/local_model.h>

namespace palpate {
namespace {

constexpr double kMilliseconds = 1e3;
constexpr double kMostEchoes = 1e15;  ///< upper bound of an echo's number: exact in a double
constexpr const char* kWorld = "world";

}  // namespace

LiveTopics::LiveTopics(Hub& hub, TickFeed& feed, ClientHand& hand, const LoopClock& clock,
                       const LoopStatistics& statistics, const WorkspaceMap& map, bool client_is_device,
                       const std::string& prefix)
    : hub_(hub),
      feed_(feed),
      hand_(hand),
      clock_(clock),
      watch_(statistics),
      map_(map),
      client_is_device_(client_is_device),
      status_(prefix.substr(1) + ": servo"),
      pose_(hub.add_topic(prefix + "/measured_cp", "geometry_msgs/PoseStamped")),
      velocity_(hub.add_topic(prefix + "/measured_cv", "geometry_msgs/TwistStamped")),
      spatial_(hub.add_topic(prefix + "/spatial/servo_cf", "geometry_msgs/WrenchStamped")),
      body_(hub.add_topic(prefix + "/body/servo_cf", "geometry_msgs/WrenchStamped")),
      proxy_(hub.add_topic(prefix + "/proxy_cp", "geometry_msgs/PoseStamped")),
      contacts_(hub.add_topic(prefix + "/contacts", "visualization_msgs/MarkerArray")),
      tool_topic_(hub.add_topic(prefix + "/tool", "visualization_msgs/MarkerArray")),
      diagnostics_(hub.add_topic(prefix + "/diagnostics", "diagnostic_msgs/DiagnosticArray")),
      client_(hub.add_topic(prefix + "/client/servo_cf", "geometry_msgs/WrenchStamped")),
      local_model_(hub.add_topic(prefix + "/client/local_model", "palpate/LocalModel")),
      echo_(hub.add_topic(prefix + "/client/echo", "std_msgs/Header")) {
  const Marker reset = ContactMarkers::reset();
  contacts_.set_reset(marker_array(header({}, kWorld, 0), {&reset, 1}), ContactMarkers::kReach);
  hub.add_input(prefix + "/client/measured_cp", "geometry_msgs/PoseStamped",
                [this](const Json& message, Client& from) { take(message, from); });
  hub.add_input(prefix + "/client/echoed", "std_msgs/Header",
                [this](const Json& message, Client& from) { take_echo(message, from); });
  hub.on_caught_up.emplace_back([this](const Client& client) {
    if (&client == holder_) hand_over();
  });
  hub.on_leave.emplace_back([this](const Client& gone) {
    if (&gone == holder_) release();
  });
}

void LiveTopics::feel(std::shared_ptr<const SceneIndex> index, const Tool& tool) {
  // Releasing the last reference to the previous index and lookup frees much memory, which is slow.
  if (index != index_)
    elsewhere([old = std::exchange(index_, std::move(index)), lookup = std::exchange(lookup_, nullptr)] {},
              [] {});
  tool_ = tool;
}

void LiveTopics::take(const Json& message, Client& from) {
  const StampedPose said = pose_stamped(message);
  if (holder_ != nullptr && holder_ != &from)
    throw Refusal("another client holds the tool; it is released once that client is silent for a second");
  if (holder_ == nullptr) hold(from);
  const bool world = said.frame.empty() ? !client_is_device_ : said.frame == kWorld;
  held_at_ = clock_.now();
  if (const auto measured = measured_at(said.stamp, held_at_))
    waiting_ = {world ? map_.to_device(said.pose) : DevicePose(said.pose), *measured, said.stamp};
}

std::optional<double> LiveTopics::measured_at(const Stamp& stamp, double now) {
  constexpr double kTellAgain = 1.0;  // s
  const std::optional<double> age =
      stamp.is_zero() ? std::nullopt : holder_clock_.age(stamp.in_seconds(), now);
  if (!age) return now;
  if (*age <= stale_after) return now - std::max(0.0, *age);
  if (now - told_late_ < kTellAgain) return std::nullopt;
  told_late_ = now;
  throw Refusal(
      fmt::format("poses arrive {:.0f} ms after measurement; those older than {:.0f} ms are dropped",
                  kMilliseconds * *age, kMilliseconds * stale_after));
}

void LiveTopics::hold(Client& client) {
  holder_ = &client;
  client.take_hand();
  holder_clock_ = {};
  told_of_no_wrench_ = false;
  hand_.change_hand();
  ask_echo();
  if (client_is_device_ && was_held_) {
    waits_since_ = clock_.now();
    if (on_other_hand) on_other_hand();
  }
  was_held_ = true;
}

void LiveTopics::release() {
  // First what cannot fail: telling the client may run out of memory, and it may be gone by then.
  Client& released = *std::exchange(holder_, nullptr);
  released.leave_hand();
  waiting_.reset();
  waits_since_.reset();
  hand_.let_go();
  publish_device_wrench(released, {});
  publish_local_model(released, 0.0);
}

void LiveTopics::ask_echo() {
  if (!echo_.is_watched()) return;
  echo_.publish_to(*holder_, header(Stamp::now(), "", holder_clock_.ask(clock_.now())));
}

void LiveTopics::take_echo(const Json& message, const Client& from) {
  if (&from != holder_) return;
  const double number = number_field(message, "seq", 0.0);
  const Stamp stamp = stamp_of(message);
  if (number < 0.0 || number > kMostEchoes || stamp.is_zero())
    throw Refusal("an echo needs the 'seq' of the message that it answers, and the client's time as 'stamp'");
  holder_clock_.answer(static_cast<std::uint64_t>(number), stamp.in_seconds(), clock_.now());
}

bool LiveTopics::force_has_fallen() const {
  const TickRecord& tick = feed_.newest().record;
  const bool off = tick.state == GovernorState::kStopped || tick.state == GovernorState::kWaiting;
  return tick.t > *waits_since_ && off && tick.sent.force.isZero() && tick.sent.torque.isZero();
}

void LiveTopics::hand_over() {
  if (waits_since_ && force_has_fallen()) waits_since_.reset();
  if (!waiting_ || waits_since_) return;
  stamps_[hand_.put(waiting_->device, waiting_->t) % stamps_.size()] = waiting_->stamp;
  waiting_.reset();
}

void LiveTopics::publish_device_wrench(Client& to, const Wrench& wrench) {
  if (!client_is_device_ || !client_.is_watched()) return;
  const Json head = header(stamps_[answered_ % stamps_.size()], "device", feed_.newest().answers);
  client_.publish_to(to, {{"header", head}, {"wrench", to_json(wrench)}});
}

void LiveTopics::publish_local_model(Client& to, double share) {
  if (!client_is_device_ || !local_model_.is_watched()) return;
  const LocalModel model = local_model_of(feed_.newest().record);
  const LocalSurface& local = model.surface;
  Json planes = Json::array();
  for (std::size_t k = 0; k < local.count; ++k)
    planes.push_back(
        {{"point", to_json(local.planes[k].point)}, {"normal", to_json(local.planes[k].normal)}});
  const Json head = header(stamps_[answered_ % stamps_.size()], "device", feed_.newest().answers);
  local_model_.publish_to(to, {{"header", head},
                               {"position", to_json(model.position)},
                               {"planes", std::move(planes)},
                               {"stiffness", local.stiffness},
                               {"damping", local.damping},
                               {"friction", local.friction},
                               {"share", share}});
}

/// Tells a client with motors why it gets no wrench: the forces are those on another device, which is not
/// where the client's hand is, although their stamps would be those of its poses.
void LiveTopics::tell_of_no_wrench() {
  if (client_is_device_ || told_of_no_wrench_) return;
  if (!client_.is_watched_by(*holder_) && !local_model_.is_watched_by(*holder_)) return;
  told_of_no_wrench_ = true;
  holder_->tell("warning", fmt::format("{} and {} are sent with --device client only: this client leads "
                                       "another device, and no force is meant for its motors",
                                       client_.name(), local_model_.name()));
}

void LiveTopics::publish_world_wrenches(const Stamp& stamp, Client* only) {
  if (!spatial_.is_watched() && !body_.is_watched()) return;
  const TickRecord& tick = feed_.newest().record;
  const auto send = [&](Topic& topic, const char* frame, const Wrench& wrench) {
    if (!topic.is_watched()) return;
    const Json message{{"header", header(stamp, frame, feed_.newest().answers)}, {"wrench", to_json(wrench)}};
    only != nullptr ? topic.publish_to(*only, message) : topic.publish(message, told_ ? holder_ : nullptr);
  };
  // Torques like forces: those of the device, along the axes of the world.
  send(spatial_, kWorld, tick.sent_world);
  const Eigen::Quaterniond back = tick.tool.orientation.conjugate();
  send(body_, "tool", {back * tick.sent_world.force, back * tick.sent_world.torque});
}

void LiveTopics::read_newest_tick() {
  if (feed_.update()) map_ = feed_.newest().record.map;
}

void LiveTopics::answer() {
  feed_.wake().clear();
  read_newest_tick();
  if (holder_ == nullptr) return;
  const bool another = feed_.newest().answers != answered_;
  answered_ = feed_.newest().answers;
  if (waits_since_) hand_over();
  // The force that still ramps down for the previous hand is not sent to this one.
  const TickRecord& tick = feed_.newest().record;
  publish_device_wrench(*holder_, waits_since_ ? Wrench{} : tick.sent);
  publish_local_model(*holder_, waits_since_ ? 0.0 : tick.force_scale);
  tell_of_no_wrench();
  if (!another) return;
  told_ = true;
  publish_world_wrenches(Stamp::now(), holder_);
}

void LiveTopics::publish() {
  if (holder_ != nullptr && clock_.now() - held_at_ > kSilence) release();
  read_newest_tick();
  if (holder_ != nullptr && waits_since_) hand_over();
  if (holder_ != nullptr && count_ % kEchoEvery == 0) ask_echo();
  const TickRecord& tick = feed_.newest().record;
  const Stamp stamp = Stamp::now();
  const Json head = header(stamp, kWorld, count_);
  if (pose_.is_watched()) pose_.publish({{"header", head}, {"pose", to_json(tick.tool)}});
  if (velocity_.is_watched()) velocity_.publish({{"header", head}, {"twist", to_json(tick.velocity)}});
  if (proxy_.is_watched()) proxy_.publish({{"header", head}, {"pose", to_json(tick.felt.proxy)}});
  publish_world_wrenches(stamp, nullptr);
  told_ = false;
  if (tool_topic_.is_watched()) publish_tool(stamp);
  if (count_ % kContactsEvery == 0 && contacts_.is_watched()) publish_contacts(stamp);
  if (count_ % kDiagnosticsEvery == 0) {
    watch_.update(clock_.now());
    if (diagnostics_.is_watched()) publish_diagnostics(stamp);
  }
  ++count_;
}

void LiveTopics::publish_contacts(const Stamp& stamp) {
  if (!index_) return;
  if (!lookup_) look_up_ellipsoids();
  if (!lookup_) return;
  query(*index_, tool_, feed_.newest().record.tool, ToolTracker::kMost, found_);
  contacts_.publish(
      marker_array(header(stamp, kWorld, count_), markers_.next(found_.contacts, *lookup_->ellipsoids)));
}

/// Builds the lookup, which sorts all Gaussians. No contacts are published until it is ready.
void LiveTopics::look_up_ellipsoids() {
  if (std::exchange(looking_up_, true)) return;
  auto made = std::make_shared<Lookup>();
  made->index = index_;
  const auto work = [made = made.get()] {
    try {
      made->ellipsoids = std::make_unique<EllipsoidLookup>(*made->index);
    } catch (const std::bad_alloc&) {
      // the next publish_contacts() tries again
    }
  };
  elsewhere(work, [this, made = std::move(made)]() mutable {
    looking_up_ = false;
    if (made->ellipsoids && made->index == index_) lookup_ = std::move(made);
    elsewhere([unused = std::move(made)] {}, [] {});
  });
}

void LiveTopics::publish_tool(const Stamp& stamp) {
  tool_topic_.publish(
      marker_array(header(stamp, kWorld, count_), tool_markers(tool_, feed_.newest().record.tool)));
}

void LiveTopics::publish_diagnostics(const Stamp& stamp) {
  const auto& [tick, times, answers] = feed_.newest();
  const LiveDiagnostics found = diagnose(tick, times, watch_, {is_held(), hub_.client_count()});
  Json values = Json::array();
  for (const auto& [key, value] : found.values) values.push_back({{"key", key}, {"value", value}});
  Json status{{"level", found.level},
              {"name", status_},
              {"message", found.message},
              {"hardware_id", ""},
              {"values", std::move(values)}};
  diagnostics_.publish({{"header", header(stamp, "", count_)}, {"status", Json::array({std::move(status)})}});
}

}  // namespace palpate
