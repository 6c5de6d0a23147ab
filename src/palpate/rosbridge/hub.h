/// \file
/// Topics, services, and the clients that use them: rosbridge v2 without a network.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <palpate/rosbridge/message.h>

namespace palpate {

class Client;
class Hub;

/// What rosbridge calls the compression of a subscription.
enum class Encoding : std::uint8_t {
  kText,  ///< "none": JSON
  kCbor,
  kRaw,  ///< "cbor-raw": CBOR around the bytes that ROS 1 encodes the message as
};

/// A message of a topic, encoded once for all who get it.
class Publication {
 public:
  Publication(const std::string& topic, const std::string& type, Json message, std::uint64_t number)
      : type_(type),
        envelope_{{"op", "publish"}, {"topic", topic}, {"msg", std::move(message)}},
        number_(number) {}

  const std::string& bytes(Encoding encoding) const;
  std::uint64_t number() const { return number_; }  ///< of those of its topic, from 1

 private:
  std::string encode(Encoding encoding) const;

  std::string type_;
  Json envelope_;
  std::uint64_t number_;
  mutable std::array<std::string, 3> bytes_;  ///< empty until someone wants them
};

/// What the server publishes under one name.
class Topic {
 public:
  /// \param latched what was published last is sent to whoever subscribes, and never left out
  Topic(std::string name, std::string type, bool latched)
      : name_(std::move(name)), type_(std::move(type)), latched_(latched) {}

  const std::string& name() const { return name_; }
  const std::string& type() const { return type_; }
  bool latched() const { return latched_; }

  /// Whether anybody gets what is published: else it need not be made.
  bool is_watched() const { return !watchers_.empty(); }
  /// To all that subscribe, but for `but`.
  void publish(Json message, const Client* but = nullptr);
  /// To one, if it subscribes.
  void publish_to(Client& client, Json message);

  /// For a topic whose messages say what has changed since the `reach` before: a client that missed more gets
  /// `message` first.
  void set_reset(Json message, std::uint64_t reach);

 private:
  friend class Client;
  std::string name_, type_;
  bool latched_;
  std::uint64_t count_ = 0, reach_ = 0;
  std::shared_ptr<const Publication> newest_, reset_;
  std::vector<Client*> watchers_;
};

/// The way back of an answer to a call. On the Hub's thread; where the client has gone, it is lost.
class Reply {
 public:
  Reply(std::weak_ptr<Client*> client, Json response)
      : client_(std::move(client)), response_(std::move(response)) {}

  /// \name One of the two, once
  /// @{
  void give(Json values) const;
  void refuse(const std::string& why) const;
  /// @}

 private:
  void send(Json values, bool result) const;

  std::weak_ptr<Client*> client_;  ///< gone when that is
  Json response_;                  ///< but for what is answered
};

/// Everything there is to subscribe to, to publish, and to call. It and its Clients belong to one thread.
class Hub {
 public:
  /// Gets what a client published. \throws Refusal.
  using Listener = std::function<void(const Json& message, Client& from)>;
  /// Answers a call. \throws Refusal.
  using Service = std::function<Json(const Json& arguments)>;
  /// Begins to answer a call, which `reply` ends at any later time. \throws Refusal.
  using SlowService = std::function<void(const Json& arguments, const Reply& reply)>;

  struct Input {
    std::string type;
    Listener listener;
  };
  struct Offer {
    std::string type;
    SlowService service;
  };

  /// Names begin with '/'. References stay good.
  Topic& add_topic(const std::string& name, const std::string& type, bool latched = false);
  void add_input(const std::string& name, const std::string& type, Listener listener);
  void add_service(const std::string& name, const std::string& type, Service service);
  void add_slow_service(const std::string& name, const std::string& type, SlowService service);

  const std::map<std::string, Topic>& topics() const { return topics_; }
  const std::map<std::string, Input>& inputs() const { return inputs_; }
  const std::map<std::string, Offer>& services() const { return services_; }
  std::size_t client_count() const { return clients_; }  ///< Any thread.
  /// Told of every client that goes.
  std::vector<std::function<void(const Client&)>> on_leave;
  /// Told when nothing more of what a client has sent waits: what it published last is the newest there is.
  std::vector<std::function<void(Client&)>> on_caught_up;

 private:
  friend class Client;
  std::map<std::string, Topic> topics_;
  std::map<std::string, Input> inputs_;
  std::map<std::string, Offer> services_;
  std::atomic<std::size_t> clients_ = 0;
};

/// Adds what clients of rosbridge ask on connecting: /rosapi/topics, services and so on.
void add_rosapi(Hub& hub);

/// The server's end of one connection: what comes in, what is to go out, and how much of either is too much.
class Client {
 public:
  /// \param wake called whenever next() may have something. \param clock Unit: [s].
  Client(Hub& hub, std::function<void()> wake, std::function<double()> clock);
  ~Client();
  Client(const Client&) = delete;
  Client& operator=(const Client&) = delete;

  /// A frame that was read, or why it cannot be.
  struct Decoded {
    Json message;
    std::string refusal;  ///< empty: there is none
  };

  /// \name One frame: admit(), then decode(), then take()
  /// What is wrong with it is told to the client.
  /// @{
  /// Counts it. \returns false where it is too much: see fault().
  bool admit(std::size_t bytes);
  /// Any thread: it is the part that takes long.
  static Decoded decode(std::string_view frame, bool binary);
  void take(const Decoded& decoded);
  /// All three.
  void receive(std::string_view frame, bool binary);
  /// @}
  /// Nothing more waits of what it has sent.
  void caught_up() {
    for (const auto& listener : hub_.on_caught_up) listener(*this);
  }

  /// Of whom frames go before those of others: who moves a hand.
  bool is_urgent() const { return hands_ > 0; }
  /// One hand more, or one less.
  void take_hand() { ++hands_; }
  void leave_hand() { --hands_; }

  struct Outgoing {
    std::shared_ptr<const std::string> bytes;
    bool binary = false;
  };
  /// What to send next, if there is anything.
  std::optional<Outgoing> next();
  bool has_next() const { return !answers_.empty() || !turn_.empty(); }

  /// Why the connection must be closed; empty while it need not.
  const std::string& fault() const { return fault_; }
  void tell(const std::string& level, const std::string& text, const Json& id = nullptr);

  static constexpr std::size_t kMostSubscriptions = 64;
  static constexpr std::size_t kMostQueued = 100;    ///< messages of a topic
  static constexpr std::size_t kMostAnswers = 1024;  ///< that it has not read
  static constexpr std::size_t kMostAnswerBytes = 1 << 22;
  static constexpr double kMostMessages = 5000.0;  ///< a second
  /// Bytes a second: poses as JSON at kMostMessages are 1.5 MB. A second's worth may come at once.
  static constexpr double kMostBytes = 2 << 20;

 private:
  friend class Topic;
  friend class Reply;
  struct Subscription {
    /// A topic may be subscribed several times, under several ids: what is sent does for all.
    struct Wish {
      double throttle = 0.0;  ///< Unit: [s].
      std::size_t queue = 1;
    };
    Topic* topic = nullptr;
    std::map<std::string, Wish> wishes;
    Encoding encoding = Encoding::kText;
    double taken_at = -1e300;  ///< the last message, for sending. Unit: [s].
    std::uint64_t last = 0;    ///< number of the publication that was sent last
    std::deque<std::shared_ptr<const Publication>> waiting;

    double throttle() const;
    std::size_t queue() const;
  };

  void handle(const Json& message);
  void subscribe(const Json& message);
  void unsubscribe(const Json& message);
  void advertise(const Json& message);
  void publish(const Json& message);
  void call(const Json& message);
  void answer(const Json& message);
  void offer(const Topic& topic, const std::shared_ptr<const Publication>& publication);
  void drop(std::map<std::string, Subscription>::iterator subscription);

  Hub& hub_;
  std::function<void()> wake_;
  std::function<double()> clock_;
  std::map<std::string, Subscription> subscriptions_;
  std::deque<std::string> turn_;  ///< topics with something waiting, each once
  std::deque<std::shared_ptr<const std::string>> answers_;
  std::size_t answer_bytes_ = 0;
  /// Messages and bytes that may still come, when that was counted last.
  double messages_left_ = kMostMessages, bytes_left_ = kMostBytes, counted_at_;
  bool quiet_ = false;
  int hands_ = 0;  ///< that it moves
  std::string fault_;
  std::shared_ptr<Client*> self_ = std::make_shared<Client*>(this);  ///< for Reply
};

}  // namespace palpate
