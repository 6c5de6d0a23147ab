/// \file
/// A participant of a DDS domain with its readers and writers, with the names and the quality of service of
/// ROS 2.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <string_view>

#include <dds/dds.h>

namespace palpate::ros2 {

/// Quality of service of a topic, as in ROS 2; both sides must be compatible.
struct Quality {
  bool reliable = true;
  bool keeps = false;  ///< transient local: late readers get the last `depth` samples too
  int depth = 1;
};
inline constexpr Quality kNewest{true, false, 1};     ///< writers
inline constexpr Quality kSensor{false, false, 8};    ///< readers: compatible with any writer
inline constexpr Quality kServices{true, false, 10};  ///< rmw_qos_profile_services_default
inline constexpr Quality kLatched{true, true, 1};     ///< latched in the terms of ROS 1

/// Reports one line to the user. Any thread.
using Say = std::function<void(const std::string& line)>;

/// A participant of the domain ROS_DOMAIN_ID (default 0), on the interfaces and with the peers of
/// CYCLONEDDS_URI; secured by the files of an enclave if ROS_SECURITY_ENABLE is set. It owns its readers and
/// writers. Thread-safe.
class Participant {
 public:
  /// \param say receives a message about a peer with incompatible quality of service or type, once per topic
  /// \param enclave name, see enclave_of_environment() \throws Error if the participant cannot be created.
  explicit Participant(Say say, const std::string& enclave = "/");
  ~Participant();
  Participant(const Participant&) = delete;
  Participant& operator=(const Participant&) = delete;

  dds_entity_t id() const { return id_; }
  /// \param prefix "rt" for topics, "rq" and "rr" for services \param name ROS name with leading slash
  /// \throws Error
  dds_entity_t make_reader(std::string_view prefix, std::string_view name, const dds_topic_descriptor_t& type,
                           const Quality& quality);
  dds_entity_t make_writer(std::string_view prefix, std::string_view name, const dds_topic_descriptor_t& type,
                           const Quality& quality);

 private:
  struct Told;

  dds_entity_t make_topic(std::string_view prefix, std::string_view name, const dds_topic_descriptor_t& type);

  std::unique_ptr<Told> told_;
  dds_entity_t id_ = 0;
};

/// Returns `code`. \throws Error if it is a negative return code of DDS. \param what action, for the message
dds_return_t checked(dds_return_t code, std::string_view what);

/// Returns how many readers a writer has had.
std::uint64_t matches(dds_entity_t writer);

/// Returns whether a writer has readers.
bool is_matched(dds_entity_t writer);

/// GUID of a participant, in hexadecimal.
std::string text_of(const dds_guid_t& guid);

/// Source of a writer: the GUID of its participant, which identifies a process in ROS 2.
std::string source_of(dds_entity_t reader, dds_instance_handle_t writer);

}  // namespace palpate::ros2
