#include <palpate/rosbridge/hub.h>

#include <algorithm>
#include <exception>
#include <new>
#include <utility>

#include <fmt/format.h>

#include <palpate/rosbridge/ros_definition.h>
#include <palpate/rosbridge/ros_message.h>
#include <palpate/rosbridge/ros_type.h>

namespace palpate {
namespace {

constexpr double kMilli = 1e-3;
/// Time by which a message may precede its throttle interval: messages at 60 Hz are 16.67 ms apart only on
/// average. Unit: [s].
constexpr double kEarly = 2e-3;

std::string full_name(const std::string& name) {
  return name.starts_with('/') ? name : fmt::format("/{}", name);
}

/// Returns `text` in quotes for an error message, shortened: a client may have sent anything.
std::string quoted(const std::string& text) {
  constexpr std::size_t kShown = 80;
  return fmt::format("'{}{}'", text.substr(0, kShown), text.size() > kShown ? "..." : "");
}

std::string named(const Json& message, const char* what) {
  const std::string name = text_field(message, what);
  if (name.empty()) throw Refusal(fmt::format("'{}' is missing", what));
  return full_name(name);
}

void check_type(const Json& message, const std::string& name, const std::string& type) {
  const std::string asked = plain_type(text_field(message, "type"));
  if (!asked.empty() && asked != "*" && asked != type)
    throw Refusal(fmt::format("{} is of type {}, not {}", name, type, quoted(asked)));
}

/// Returns the arguments of a call of a service of type `type`. \throws Refusal
const Json& arguments_of(const Json& message, const std::string& type) {
  static const Json none = Json::object();
  const RosType* const request = find_ros_type(type + "Request");
  // An emergency stop is heard whatever comes with it.
  if (request != nullptr && request->fields.empty()) return none;
  const auto arguments = message.find("args");
  if (arguments == message.end() || arguments->is_null() || arguments->empty()) return none;
  if (!arguments->is_object()) throw Refusal("'args' must be an object");
  return *arguments;
}

Encoding encoding_of(const Json& subscribe, const Topic& topic) {
  const std::string name = text_field(subscribe, "compression");
  if (name.empty() || name == "none") return Encoding::kText;
  if (name == "cbor") return Encoding::kCbor;
  if (name != "cbor-raw")
    throw Refusal(fmt::format("compression {} is not supported; use none, cbor or cbor-raw", quoted(name)));
  if (ros_definition(topic.type()).empty())
    throw Refusal(fmt::format("{} is not available as cbor-raw: {} is not a ROS message type", topic.name(),
                              topic.type()));
  return Encoding::kRaw;
}

}  // namespace

const std::string& Publication::bytes(Encoding encoding) const {
  std::string& made = bytes_[static_cast<std::size_t>(encoding)];
  if (made.empty()) made = encode(encoding);
  return made;
}

std::string Publication::encode(Encoding encoding) const {
  if (encoding == Encoding::kText) return encode_json(envelope_);
  std::string made;
  if (encoding == Encoding::kCbor) {
    Json::to_cbor(envelope_, nlohmann::detail::output_adapter<char>(made));
    return made;
  }
  const std::string bytes = ros_bytes(type_, envelope_["msg"]);
  const Stamp now = Stamp::now();
  const Json envelope{{"op", "publish"},
                      {"topic", envelope_["topic"]},
                      {"msg",
                       {{"secs", now.seconds},
                        {"nsecs", now.nanoseconds},
                        {"bytes", Json::binary({bytes.begin(), bytes.end()})}}}};
  Json::to_cbor(envelope, nlohmann::detail::output_adapter<char>(made));
  return made;
}

void Topic::publish(Json message, const Client* but) {
  newest_ = std::make_shared<Publication>(name_, type_, std::move(message), ++count_);
  // A client that is woken may unsubscribe or remove itself or others.
  const std::vector<Client*> watchers = watchers_;
  for (Client* client : watchers) {
    const bool still = std::find(watchers_.begin(), watchers_.end(), client) != watchers_.end();
    if (still && client != but) client->offer(*this, newest_);
  }
}

void Topic::publish_to(Client& client, Json message) {
  if (!is_watched_by(client)) return;
  client.offer(*this, std::make_shared<Publication>(name_, type_, std::move(message), ++count_));
}

bool Topic::is_watched_by(const Client& client) const {
  return std::find(watchers_.begin(), watchers_.end(), &client) != watchers_.end();
}

void Topic::set_reset(Json message, std::uint64_t reach) {
  reset_ = std::make_shared<Publication>(name_, type_, std::move(message), 0);
  reach_ = reach;
}

Topic& Hub::add_topic(const std::string& name, const std::string& type, bool latched) {
  return topics_.emplace(name, Topic(name, type, latched)).first->second;
}

void Hub::add_input(const std::string& name, const std::string& type, Listener listener) {
  inputs_[name] = {type, std::move(listener)};
}

void Hub::add_service(const std::string& name, const std::string& type, Service service) {
  add_slow_service(name, type, [service = std::move(service)](const Json& arguments, const Reply& reply) {
    reply.give(service(arguments));
  });
}

void Hub::add_slow_service(const std::string& name, const std::string& type, SlowService service) {
  services_[name] = {type, std::move(service)};
}

void Reply::give(Json values) const { send(std::move(values), true); }
void Reply::refuse(const std::string& why) const { send(why, false); }

void Reply::send(Json values, bool result) const {
  const std::shared_ptr<Client*> client = client_.lock();
  if (!client) return;
  Json response = response_;
  response["values"] = std::move(values);
  response["result"] = result;
  (*client)->answer(response);
}

double Client::Subscription::throttle() const {
  double least = wishes.begin()->second.throttle;
  for (const auto& [id, wish] : wishes) least = std::min(least, wish.throttle);
  return least;
}

std::size_t Client::Subscription::queue() const {
  std::size_t most = 1;
  for (const auto& [id, wish] : wishes) most = std::max(most, wish.queue);
  return most;
}

Client::Client(Hub& hub, std::function<void()> wake, std::function<double()> clock)
    : hub_(hub), wake_(std::move(wake)), clock_(std::move(clock)), counted_at_(clock_()) {
  ++hub_.clients_;
}

Client::~Client() {
  while (!subscriptions_.empty()) drop(subscriptions_.begin());
  --hub_.clients_;
  for (const auto& listener : hub_.on_leave) {
    try {
      listener(*this);
    } catch (const std::bad_alloc&) {
      // One that cannot tell others what has changed.
    }
  }
}

bool Client::admit(std::size_t bytes) {
  if (!fault_.empty()) return false;
  const double now = clock_(), passed = now - counted_at_;
  messages_left_ = std::min(kMostMessages, messages_left_ + kMostMessages * passed) - 1.0;
  bytes_left_ = std::min(kMostBytes, bytes_left_ + kMostBytes * passed) - static_cast<double>(bytes);
  counted_at_ = now;
  if (messages_left_ < 0.0) fault_ = fmt::format("more than {} messages a second", kMostMessages);
  if (bytes_left_ < 0.0) fault_ = fmt::format("more than {} bytes a second", kMostBytes);
  return fault_.empty();
}

/// Short enough for a std::string that does not allocate.
constexpr const char* kNoMemory = "no memory";

Client::Decoded Client::decode(std::string_view frame, bool binary) {
  try {
    return {binary ? decode_cbor(frame) : decode_json(frame), {}};
  } catch (const Refusal& refusal) {
    return {{}, refusal.what()};
  } catch (const std::bad_alloc&) {
    return {{}, kNoMemory};
  }
}

void Client::take(const Decoded& decoded) {
  if (!fault_.empty()) return;
  try {
    take_or_tell(decoded);
  } catch (const std::bad_alloc&) {  // also of what the client is told
    fault_ = kNoMemory;
  }
}

void Client::take_or_tell(const Decoded& decoded) {
  const Json& message = decoded.message;
  if (!decoded.refusal.empty()) return tell("error", decoded.refusal);
  Json id;
  try {
    if (!message.is_object()) throw Refusal("a message must be an object with an 'op'");
    if (const auto at = message.find("id"); at != message.end() && at->is_string()) id = *at;
    handle(message);
  } catch (const std::bad_alloc&) {
    throw;
  } catch (const std::exception& error) {
    // Refusals, and what nobody expects: no message of a client may end the program, whose device may be in
    // a user's hand.
    tell("error", error.what(), id);
  }
}

void Client::receive(std::string_view frame, bool binary) {
  if (admit(frame.size())) take(decode(frame, binary));
}

void Client::handle(const Json& message) {
  const std::string op = text_field(message, "op");
  if (op == "subscribe") return subscribe(message);
  if (op == "unsubscribe") return unsubscribe(message);
  if (op == "advertise") return advertise(message);
  if (op == "unadvertise") return;
  if (op == "publish") return publish(message);
  if (op == "call_service") return call(message);
  if (op == "set_level") {
    quiet_ = text_field(message, "level") == "none";
    return;
  }
  throw Refusal(op.empty() ? "'op' is missing"
                           : fmt::format("op {} is not supported; use subscribe, unsubscribe, advertise, "
                                         "unadvertise, publish, call_service or set_level",
                                         quoted(op)));
}

void Client::subscribe(const Json& message) {
  const std::string name = named(message, "topic");
  const auto topic = hub_.topics_.find(name);
  if (topic == hub_.topics_.end())
    throw Refusal(fmt::format("there is no topic {}; /rosapi/topics lists them", quoted(name)));
  check_type(message, name, topic->second.type());
  const Encoding encoding = encoding_of(message, topic->second);
  const Subscription::Wish wish{kMilli * std::max(0.0, number_field(message, "throttle_rate", 0.0)),
                                static_cast<std::size_t>(std::clamp(
                                    number_field(message, "queue_length", 1.0), 1.0, double{kMostQueued}))};
  const std::string id = text_field(message, "id");
  if (!subscriptions_.contains(name) && subscriptions_.size() == kMostSubscriptions)
    throw Refusal(fmt::format("more than {} subscriptions", kMostSubscriptions));
  Subscription& subscription = subscriptions_[name];
  const bool first = subscription.topic == nullptr;
  if (subscription.wishes.size() == kMostSubscriptions && !subscription.wishes.contains(id))
    throw Refusal(fmt::format("more than {} subscriptions of {}", kMostSubscriptions, name));
  subscription.topic = &topic->second;
  subscription.wishes[id] = wish;
  subscription.encoding = encoding;
  if (first) topic->second.watchers_.push_back(this);
  if (topic->second.latched_ && topic->second.newest_) offer(topic->second, topic->second.newest_);
}

void Client::drop(std::map<std::string, Subscription>::iterator subscription) {
  std::erase(subscription->second.topic->watchers_, this);
  std::erase(turn_, subscription->first);
  subscriptions_.erase(subscription);
}

void Client::unsubscribe(const Json& message) {
  const auto subscription = subscriptions_.find(named(message, "topic"));
  if (subscription == subscriptions_.end()) return;
  const std::string id = text_field(message, "id");
  if (!id.empty()) subscription->second.wishes.erase(id);
  if (id.empty() || subscription->second.wishes.empty()) drop(subscription);
}

void Client::advertise(const Json& message) {
  const std::string name = named(message, "topic");
  const auto input = hub_.inputs_.find(name);
  if (input == hub_.inputs_.end()) throw Refusal(fmt::format("clients cannot publish on {}", quoted(name)));
  check_type(message, name, input->second.type);
}

void Client::publish(const Json& message) {
  const std::string name = named(message, "topic");
  const auto input = hub_.inputs_.find(name);
  if (input == hub_.inputs_.end()) throw Refusal(fmt::format("clients cannot publish on {}", quoted(name)));
  const Json& published = field(message, "msg");
  if (!published.is_object()) throw Refusal("'msg' must be an object");
  input->second.listener(published, *this);
}

void Client::call(const Json& message) {
  const std::string name = named(message, "service");
  Json response{{"op", "service_response"}, {"service", name}};
  if (const auto id = message.find("id"); id != message.end()) response["id"] = *id;
  const Reply reply(self_, std::move(response));
  try {
    const auto offer = hub_.services_.find(name);
    if (offer == hub_.services_.end())
      throw Refusal(fmt::format("there is no service {}; /rosapi/services lists them", quoted(name)));
    offer->second.service(arguments_of(message, offer->second.type), reply);
  } catch (const std::bad_alloc&) {
    throw;  // take() ends the connection
  } catch (const std::exception& error) {
    reply.refuse(error.what());
  }
}

void Client::tell(const std::string& level, const std::string& text, const Json& id) {
  if (quiet_) return;
  Json status{{"op", "status"}, {"level", level}, {"msg", text}};
  if (!id.is_null()) status["id"] = id;
  answer(status);
}

void Client::answer(const Json& message) {
  auto text = std::make_shared<const std::string>(encode_json(message));
  answer_bytes_ += text->size();
  answers_.push_back(std::move(text));
  if (answers_.size() > kMostAnswers || answer_bytes_ > kMostAnswerBytes)
    fault_ = "the client does not read its responses";
  wake_();
}

void Client::offer(const Topic& topic, const std::shared_ptr<const Publication>& publication) {
  Subscription& subscription = subscriptions_.at(topic.name());
  const double now = clock_();
  if (!topic.latched() && now < subscription.taken_at + subscription.throttle() - kEarly) return;
  subscription.taken_at = now;
  if (subscription.waiting.empty()) turn_.push_back(topic.name());
  subscription.waiting.push_back(publication);
  if (subscription.waiting.size() > subscription.queue()) subscription.waiting.pop_front();
  wake_();
}

std::optional<Client::Outgoing> Client::next() {
  if (!answers_.empty()) {
    Outgoing outgoing{std::move(answers_.front()), false};
    answers_.pop_front();
    answer_bytes_ -= outgoing.bytes->size();
    return outgoing;
  }
  if (turn_.empty()) return std::nullopt;
  const std::string name = std::move(turn_.front());
  turn_.pop_front();
  Subscription& subscription = subscriptions_.at(name);
  const Topic& topic = *subscription.topic;
  std::shared_ptr<const Publication> sent = subscription.waiting.front();
  if (topic.reset_ && (subscription.last == 0 || sent->number() > subscription.last + topic.reach_)) {
    subscription.last = sent->number();  // the reset is sent first; the message stays in the queue
    sent = topic.reset_;
  } else {
    subscription.last = sent->number();
    subscription.waiting.pop_front();
  }
  if (!subscription.waiting.empty()) turn_.push_back(name);
  const std::string& bytes = sent->bytes(subscription.encoding);
  return Outgoing{std::shared_ptr<const std::string>(sent, &bytes), subscription.encoding != Encoding::kText};
}

}  // namespace palpate
