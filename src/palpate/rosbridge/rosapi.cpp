// Services of rosapi, the companion node of rosbridge: existing topics, services and types.
#include <chrono>
#include <map>
#include <string>

#include <palpate/rosbridge/hub.h>
#include <palpate/rosbridge/ros_definition.h>
#include <palpate/rosbridge/type_details.h>

namespace palpate {
namespace {

/// Topics of both directions with their types.
std::map<std::string, std::string> all_topics(const Hub& hub) {
  std::map<std::string, std::string> types;
  for (const auto& [name, topic] : hub.topics()) types[name] = topic.type();
  for (const auto& [name, input] : hub.inputs()) types[name] = input.type;
  return types;
}

Json names_of(const auto& map) {
  Json names = Json::array();
  for (const auto& [name, value] : map) names.push_back(name);
  return names;
}

/// The names in `types` whose type is `type`.
Json names_of_type(const std::map<std::string, std::string>& types, const std::string& type) {
  Json names = Json::array();
  for (const auto& [name, of] : types) {
    if (of == type) names.push_back(name);
  }
  return names;
}

std::map<std::string, std::string> all_services(const Hub& hub) {
  std::map<std::string, std::string> types;
  for (const auto& [name, offer] : hub.services()) types[name] = offer.type;
  return types;
}

/// Returns the type of a topic or service; empty if there is none, as in rosapi.
std::string type_of(const std::map<std::string, std::string>& types, const std::string& name) {
  const auto at = types.find(name);
  return at == types.end() ? "" : at->second;
}

/// Returns the only node, if it has that topic.
Json nodes_of(const auto& topics, const std::string& topic) {
  return topics.contains(topic) ? Json::array({"/palpate"}) : Json::array();
}

Json now() {
  const auto since = std::chrono::system_clock::now().time_since_epoch();
  const auto seconds = std::chrono::duration_cast<std::chrono::seconds>(since);
  const auto rest = std::chrono::duration_cast<std::chrono::nanoseconds>(since - seconds);
  return {{"secs", seconds.count()}, {"nsecs", rest.count()}};
}

}  // namespace

void add_rosapi(Hub& hub) {
  const auto add = [&hub](const char* name, const char* type, Hub::Service service) {
    hub.add_service(std::string("/rosapi/") + name, std::string("rosapi/") + type, std::move(service));
  };
  add("topics", "Topics", [&hub](const Json&) {
    Json names = Json::array(), types = Json::array();
    for (const auto& [name, type] : all_topics(hub)) {
      names.push_back(name);
      types.push_back(type);
    }
    return Json{{"topics", names}, {"types", types}};
  });
  add("topics_and_raw_types", "TopicsAndRawTypes", [&hub](const Json&) {
    Json names = Json::array(), types = Json::array(), texts = Json::array();
    for (const auto& [name, type] : all_topics(hub)) {
      names.push_back(name);
      types.push_back(type);
      texts.push_back(ros_definition(type));
    }
    return Json{{"topics", names}, {"types", types}, {"typedefs_full_text", texts}};
  });
  add("topics_for_type", "TopicsForType", [&hub](const Json& args) {
    return Json{{"topics", names_of_type(all_topics(hub), text_field(args, "type"))}};
  });
  add("topic_type", "TopicType", [&hub](const Json& args) {
    return Json{{"type", type_of(all_topics(hub), text_field(args, "topic"))}};
  });
  add("publishers", "Publishers", [&hub](const Json& args) {
    return Json{{"publishers", nodes_of(hub.topics(), text_field(args, "topic"))}};
  });
  add("subscribers", "Subscribers", [&hub](const Json& args) {
    return Json{{"subscribers", nodes_of(hub.inputs(), text_field(args, "topic"))}};
  });
  add("services", "Services", [&hub](const Json&) { return Json{{"services", names_of(hub.services())}}; });
  add("services_for_type", "ServicesForType", [&hub](const Json& args) {
    return Json{{"services", names_of_type(all_services(hub), text_field(args, "type"))}};
  });
  add("service_type", "ServiceType", [&hub](const Json& args) {
    return Json{{"type", type_of(all_services(hub), text_field(args, "service"))}};
  });
  add("service_node", "ServiceNode", [](const Json&) { return Json{{"node", "/palpate"}}; });
  add("nodes", "Nodes", [](const Json&) { return Json{{"nodes", {"/palpate"}}}; });
  add("node_details", "NodeDetails", [&hub](const Json&) {
    return Json{{"subscribing", names_of(hub.inputs())},
                {"publishing", names_of(hub.topics())},
                {"services", names_of(hub.services())}};
  });
  add("action_servers", "GetActionServers", [](const Json&) {
    return Json{{"action_servers", Json::array()}};
  });
  add("message_details", "MessageDetails", [](const Json& args) {
    return Json{{"typedefs", message_details(text_field(args, "type"))}};
  });
  add("service_request_details", "ServiceRequestDetails", [](const Json& args) {
    return Json{{"typedefs", service_request_details(text_field(args, "type"))}};
  });
  add("service_response_details", "ServiceResponseDetails", [](const Json& args) {
    return Json{{"typedefs", service_response_details(text_field(args, "type"))}};
  });
  add("get_time", "GetTime", [](const Json&) { return Json{{"time", now()}}; });
}

}  // namespace palpate
