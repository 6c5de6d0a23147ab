/// \file
/// rosbridge v2 broker without the network: topics, services and clients.
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

/// Encoding of a subscription, the "compression" of rosbridge.
enum class Encoding : std::uint8_t {
  kText,  ///< "none": JSON
  kCbor,
  kRaw,  ///< "cbor-raw": CBOR that contains the message in ROS 1 serialization
};

/// A published message, encoded once for all subscribers.
class Publication {
 public:
  Publication(const std::string& topic, const std::string& type, Json message, std::uint64_t number)
      : type_(type),
        envelope_{{"op", "publish"}, {"topic", topic}, {"msg", std::move(message)}},
        number_(number) {}

  const std::string& bytes(Encoding encoding) const;
  std::uint64_t number() const { return number_; }  ///< sequence number in its topic, from 1

 private:
  std::string encode(Encoding encoding) const;

  std::string type_;
  Json envelope_;
  std::uint64_t number_;
  mutable std::array<std::string, 3> bytes_;  ///< encoded on demand
};

/// A topic that the server publishes.
class Topic {
 public:
  /// \param latched the last message is sent to new subscribers, and never dropped
  Topic(std::string name, std::string type, bool latched)
      : name_(std::move(name)), type_(std::move(type)), latched_(latched) {}

  const std::string& name() const { return name_; }
  const std::string& type() const { return type_; }
  bool latched() const { return latched_; }

  /// Returns whether the topic has subscribers; without any, messages need not be generated.
  bool is_watched() const { return !watchers_.empty(); }
  bool is_watched_by(const Client& client) const;
  /// Publishes to all subscribers except `but`.
  void publish(Json message, const Client* but = nullptr);
  /// Publishes to one client, if it subscribes.
  void publish_to(Client& client, Json message);

  /// For a topic of incremental messages, each of which covers the previous `reach` ones: a client that
  /// missed more gets `message` first.
  void set_reset(Json message, std::uint64_t reach);

 private:
  friend class Client;
  std::string name_, type_;
  bool latched_;
  std::uint64_t count_ = 0, reach_ = 0;
  std::shared_ptr<const Publication> newest_, reset_;
  std::vector<Client*> watchers_;
};

/// Pending reply to a service call. Used on the Hub's thread; dropped if the client has disconnected.
class Reply {
 public:
  Reply(std::weak_ptr<Client*> client, Json response)
      : client_(std::move(client)), response_(std::move(response)) {}

  /// \name Exactly one of these, once
  /// @{
  void give(Json values) const;
  void refuse(const std::string& why) const;
  /// @}

 private:
  void send(Json values, bool result) const;

  std::weak_ptr<Client*> client_;  ///< expires with the client
  Json response_;                  ///< without the result
};

/// Registry of all topics, inputs and services. It and its Clients belong to one thread.
class Hub {
 public:
  /// Receives a message that a client published. \throws Refusal. Whatever else is thrown, here or by a
  /// service, is reported to the client in the same way; std::bad_alloc ends its connection.
  using Listener = std::function<void(const Json& message, Client& from)>;
  /// Answers a service call. \throws Refusal.
  using Service = std::function<Json(const Json& arguments)>;
  /// Starts answering a service call; `reply` completes it at any later time. \throws Refusal.
  using SlowService = std::function<void(const Json& arguments, const Reply& reply)>;

  struct Input {
    std::string type;
    Listener listener;
  };
  struct Offer {
    std::string type;
    SlowService service;
  };

  /// Names begin with '/'. References stay valid.
  Topic& add_topic(const std::string& name, const std::string& type, bool latched = false);
  void add_input(const std::string& name, const std::string& type, Listener listener);
  void add_service(const std::string& name, const std::string& type, Service service);
  void add_slow_service(const std::string& name, const std::string& type, SlowService service);

  const std::map<std::string, Topic>& topics() const { return topics_; }
  const std::map<std::string, Input>& inputs() const { return inputs_; }
  const std::map<std::string, Offer>& services() const { return services_; }
  std::size_t client_count() const { return clients_; }  ///< Any thread.
  /// Called for every client that disconnects. One that runs out of memory is abandoned.
  std::vector<std::function<void(const Client&)>> on_leave;
  /// Called when all received messages of a client have been processed: its last publication is the newest.
  std::vector<std::function<void(Client&)>> on_caught_up;

 private:
  friend class Client;
  std::map<std::string, Topic> topics_;
  std::map<std::string, Input> inputs_;
  std::map<std::string, Offer> services_;
  std::atomic<std::size_t> clients_ = 0;
};

/// Adds the services that rosbridge clients call on connecting: /rosapi/topics, /rosapi/services and so on.
void add_rosapi(Hub& hub);

/// Server side of one client connection: input, output queues, and limits of both.
class Client {
 public:
  /// \param wake called whenever next() may have a frame. \param clock Unit: [s].
  Client(Hub& hub, std::function<void()> wake, std::function<double()> clock);
  ~Client();
  Client(const Client&) = delete;
  Client& operator=(const Client&) = delete;

  /// A decoded frame, or why it cannot be decoded.
  struct Decoded {
    Json message;
    std::string refusal;  ///< empty: valid
  };

  /// \name One frame: admit(), then decode(), then take()
  /// Errors are reported to the client.
  /// @{
  /// Counts the frame. \returns false if a limit is exceeded: see fault().
  bool admit(std::size_t bytes);
  /// Decodes a frame, the slow part. Any thread.
  static Decoded decode(std::string_view frame, bool binary);
  void take(const Decoded& decoded);
  /// Does all three.
  void receive(std::string_view frame, bool binary);
  /// @}
  /// Called when no more of its messages are pending.
  void caught_up() {
    for (const auto& listener : hub_.on_caught_up) listener(*this);
  }

  /// Returns whether its frames have priority: it moves a hand.
  bool is_urgent() const { return hands_ > 0; }
  /// Increments or decrements the number of hands it moves.
  void take_hand() { ++hands_; }
  void leave_hand() { --hands_; }

  struct Outgoing {
    std::shared_ptr<const std::string> bytes;
    bool binary = false;
  };
  /// Returns the next frame to send, if any.
  std::optional<Outgoing> next();
  bool has_next() const { return !answers_.empty() || !turn_.empty(); }

  /// Returns why the connection must be closed; empty if it may stay open.
  const std::string& fault() const { return fault_; }
  void tell(const std::string& level, const std::string& text, const Json& id = nullptr);

  static constexpr std::size_t kMostSubscriptions = 64;
  static constexpr std::size_t kMostQueued = 100;    ///< messages of a topic
  static constexpr std::size_t kMostAnswers = 1024;  ///< answers not yet read by the client
  static constexpr std::size_t kMostAnswerBytes = 1 << 22;
  static constexpr double kMostMessages = 5000.0;  ///< per second
  /// Bytes per second: poses as JSON at kMostMessages are 1.5 MB. A second's worth may come at once.
  static constexpr double kMostBytes = 2 << 20;

 private:
  friend class Topic;
  friend class Reply;
  struct Subscription {
    /// A topic may be subscribed several times, under several ids: the messages sent satisfy the rates and
    /// queues of all, in the encoding of the newest.
    struct Wish {
      double throttle = 0.0;  ///< Unit: [s].
      std::size_t queue = 1;
    };
    Topic* topic = nullptr;
    std::map<std::string, Wish> wishes;
    Encoding encoding = Encoding::kText;
    double taken_at = -1e300;  ///< time when a message was last queued. Unit: [s].
    std::uint64_t last = 0;    ///< number of the publication that was sent last
    std::deque<std::shared_ptr<const Publication>> waiting;

    double throttle() const;
    std::size_t queue() const;
  };

  void take_or_tell(const Decoded& decoded);
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
  std::deque<std::string> turn_;  ///< topics with pending messages, each once
  std::deque<std::shared_ptr<const std::string>> answers_;
  std::size_t answer_bytes_ = 0;
  /// Remaining allowance of messages and bytes at the last count.
  double messages_left_ = kMostMessages, bytes_left_ = kMostBytes, counted_at_;
  bool quiet_ = false;
  int hands_ = 0;  ///< hands that it moves
  std::string fault_;
  std::shared_ptr<Client*> self_ = std::make_shared<Client*>(this);  ///< for Reply
};

}  // namespace palpate
