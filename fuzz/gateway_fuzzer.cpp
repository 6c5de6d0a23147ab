// Network input handled by this project: messages of clients, or the head of an HTTP request after parsing by
// Beast (the parser itself needs a connection and is not covered). The first byte selects which; the rest is
// split at 0xfe, which occurs in no UTF-8 text and starts no CBOR value.
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <string>
#include <string_view>
#include <vector>

#include <palpate/rosbridge/access.h>
#include <palpate/rosbridge/hub.h>
#include <palpate/rosbridge/ros_message.h>

#include "input_file.h"

namespace {

using palpate::Client;
using palpate::Hub;
using palpate::Json;
using palpate::RangeRequest;
using palpate::fuzz::require;

std::vector<std::string_view> pieces(std::string_view input) {
  constexpr char kCut = '\xfe';
  std::vector<std::string_view> result;
  for (;;) {
    const std::size_t end = input.find(kCut);
    result.push_back(input.substr(0, end));
    if (end == std::string_view::npos) return result;
    input.remove_prefix(end + 1);
  }
}

/// Takes all outgoing messages, whose encoding and operation must be valid.
void drain(Client& client) {
  while (const auto outgoing = client.next()) {
    const Json message = outgoing->binary ? Json::from_cbor(*outgoing->bytes) : Json::parse(*outgoing->bytes);
    const std::string op = message.at("op");
    require(op == "publish" || op == "status" || op == "service_response");
    require(!outgoing->binary || op == "publish");
  }
}

/// Sends frames to a hub with topics, an input and services. Topics publish after every frame.
void talk(const std::vector<std::string_view>& frames, bool binary) {
  double now = 0.0;
  Hub hub;
  palpate::add_rosapi(hub);
  palpate::Topic& topic = hub.add_topic("/t", "std_msgs/String");
  palpate::Topic& latched = hub.add_topic("/l", "std_msgs/String", true);
  topic.set_reset("reset", 2);
  hub.add_input("/i", "geometry_msgs/PoseStamped", [&](const Json& message, Client& from) {
    const palpate::StampedPose said = palpate::pose_stamped(message);
    require(said.pose.position.allFinite());
    require(std::abs(said.pose.orientation.norm() - 1.0) < 1e-12);
    topic.publish_to(from, palpate::to_json(said.pose));
  });
  hub.add_service("/s", "std_srvs/SetBool", [](const Json& arguments) {
    return Json{{"success", true},
                {"text", palpate::text_field(arguments, "text")},
                {"number", palpate::number_field(arguments, "number", 0.0)},
                {"data", palpate::field(arguments, "data")}};
  });
  Client other(
      hub, [] {}, [&] { return now; });
  other.receive(R"({"op": "subscribe", "topic": "/t", "compression": "cbor"})", false);
  {
    Client client(
        hub, [] {}, [&] { return now; });
    int number = 0;
    for (const std::string_view frame : frames) {
      client.receive(frame, binary);
      topic.publish(++number);
      if (number % 3 == 0) latched.publish(number);
      if (number % 4 == 0) drain(client);
      now += 0.01;
    }
    drain(client);
  }
  drain(other);
  require(hub.client_count() == 1 && other.fault().empty());
}

/// Checks a request head of six pieces: target, host, origin, authorization, cookie and range.
void ask(std::vector<std::string_view> head) {
  head.resize(6);
  for (const char* token : {"", "s3cret"}) {
    for (const unsigned port : {80U, 9090U}) {
      const auto refused = palpate::Access("127.0.0.1", port, token, "c00kie")
                               .refusal({head[1], head[2], head[3], head[4], head[0]}, 0.0);
      require(!refused || refused->status == 401 || refused->status == 403);
      // With a token set, access requires a secret in the request, possibly percent-encoded.
      const auto has = [](std::string_view text, std::string_view secret) {
        return text.find(secret) != std::string_view::npos;
      };
      if (*token != '\0' && !refused)
        require(has(palpate::query_value(head[0], "token"), token) || has(head[3], token) ||
                has(head[4], "c00kie"));
    }
  }
  const std::string without = palpate::without_query_value(head[0], "token");
  require(without.size() <= head[0].size() && palpate::query_value(without, "token").empty());
  if (const auto path = palpate::path_of(head[0])) {
    require(path->starts_with('/') && path->find("..") == std::string::npos);
    require(path->find('\0') == std::string::npos && path->find('\\') == std::string::npos);
    require(path->size() <= head[0].size());
  }
  for (const std::uint64_t size :
       {std::uint64_t{0}, std::uint64_t{1}, std::uint64_t{1000}, std::numeric_limits<std::uint64_t>::max()}) {
    const RangeRequest request = palpate::parse_range(head[5], size);
    if (request.kind != RangeRequest::Kind::kPart) continue;
    require(request.range.count > 0 && request.range.first < size);
    require(request.range.count <= size - request.range.first);
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  const std::vector<std::string_view> rest = pieces({reinterpret_cast<const char*>(data) + 1, size - 1});
  switch (data[0] % 3) {
    case 0: talk(rest, false); break;
    case 1: talk(rest, true); break;
    default: ask(rest);
  }
  return 0;
}
