/// \file
/// A participant of a DDS domain, its readers and writers, under the names and with the quality of service of
/// ROS 2. Without DDS headers but for handles.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <string_view>

#include <dds/dds.h>

namespace palpate::ros2 {

/// Of a topic, as ROS 2's: what both sides agree to.
struct Quality {
  bool reliable = true;
  bool keeps = false;  ///< transient local: who comes later gets the last `depth` too
  int depth = 1;
};
inline constexpr Quality kNewest{true, false, 1};     ///< a writer's
inline constexpr Quality kSensor{false, false, 8};    ///< a reader's: any writer will do
inline constexpr Quality kServices{true, false, 10};  ///< rmw_qos_profile_services_default
inline constexpr Quality kLatched{true, true, 1};     ///< what ROS 1 calls latched

/// One line for a person. Any thread.
using Say = std::function<void(const std::string& line)>;

/// A participant of the domain ROS_DOMAIN_ID (0), on the interfaces and with the peers of CYCLONEDDS_URI.
/// Secured by the files of an enclave where ROS_SECURITY_ENABLE says so. Readers and writers are its own, and
/// gone with it. Thread-safe.
class Participant {
 public:
  /// \param say told of a peer that is found, but whose quality of service or type does not fit; once a topic
  /// \param enclave its name, see enclave_of_environment() \throws Error where it cannot be made.
  explicit Participant(Say say, const std::string& enclave = "/");
  ~Participant();
  Participant(const Participant&) = delete;
  Participant& operator=(const Participant&) = delete;

  dds_entity_t id() const { return id_; }
  /// \param prefix "rt" of topics, "rq" and "rr" of services \param name as ROS has it, from its slash on
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

/// \throws Error that says what could not be done where `code` is a return code of DDS below 0; else returns
/// it.
dds_return_t checked(dds_return_t code, std::string_view what);

/// Whether a writer has readers.
bool is_matched(dds_entity_t writer);

/// Whose a writer is: the GUID of its participant, which in ROS 2 is that of a process.
std::string source_of(dds_entity_t reader, dds_instance_handle_t writer);

}  // namespace palpate::ros2
