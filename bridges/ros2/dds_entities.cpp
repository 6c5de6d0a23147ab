#include "dds_entities.h"

#include <atomic>
#include <charconv>
#include <cstdlib>
#include <mutex>
#include <set>

#include <dds/ddsrt/log.h>
#include <fmt/format.h>

#include <palpate/base/clock.h>
#include <palpate/base/error.h>
#include <palpate/base/nonblocking_stderr.h>
#include <palpate/base/real_time.h>

#include "dds_security.h"
#include "type_hash.h"

namespace palpate::ros2 {
namespace {

/// Largest domain id for which DDS has ports.
constexpr std::uint32_t kMostDomain = 232;
/// Longest time that a writer blocks for a slow reader. Unit: [ns].
constexpr dds_duration_t kBlocks = 0;

std::uint32_t domain() {
  // No code here sets environment variables. NOLINTNEXTLINE(concurrency-mt-unsafe)
  const char* text = std::getenv("ROS_DOMAIN_ID");
  if (text == nullptr || *text == '\0') return 0;
  const std::string_view all(text);
  std::uint32_t number = 0;
  const auto [end, error] = std::from_chars(all.data(), all.data() + all.size(), number);
  if (error != std::errc() || end != all.data() + all.size() || number > kMostDomain)
    throw Error("ROS_DOMAIN_ID: '{}' is not a whole number from 0 to {}", printable(text), kMostDomain);
  return number;
}

struct QosDeleter {
  void operator()(dds_qos_t* qos) const { dds_delete_qos(qos); }
};
using Qos = std::unique_ptr<dds_qos_t, QosDeleter>;

Qos qos_of(const Quality& quality) {
  Qos qos(dds_create_qos());
  dds_qset_reliability(qos.get(), quality.reliable ? DDS_RELIABILITY_RELIABLE : DDS_RELIABILITY_BEST_EFFORT,
                       kBlocks);
  dds_qset_durability(qos.get(), quality.keeps ? DDS_DURABILITY_TRANSIENT_LOCAL : DDS_DURABILITY_VOLATILE);
  dds_qset_history(qos.get(), DDS_HISTORY_KEEP_LAST, quality.depth);
  return qos;
}

struct ListenerDeleter {
  void operator()(dds_listener_t* listener) const { dds_delete_listener(listener); }
};
using Listener = std::unique_ptr<dds_listener_t, ListenerDeleter>;

/// Name of a quality-of-service policy from its id (DDS 1.4, 2.3.3).
std::string policy_name(std::uint32_t policy) {
  switch (policy) {
    case 2: return "durability";
    case 4: return "deadline";
    case 6: return "ownership";
    case 8: return "liveliness";
    case 11: return "reliability";
    default: return fmt::format("policy {}", policy);
  }
}

/// Shows what DDS logs on its own threads, such as messages that it cannot decode: one line a second at most,
/// and without waiting for the terminal.
void show_log(void*, const dds_log_data_t* data) {
  constexpr double kPause = 1.0;  // s
  static std::atomic<double> told = -kPause;
  const double now = monotonic_now();
  double last = told.load(std::memory_order_relaxed);
  if (now - last < kPause || !told.compare_exchange_strong(last, now, std::memory_order_relaxed)) return;
  std::string_view text(data->message);
  while (text.ends_with('\n')) text.remove_suffix(1);
  write_to_stderr(fmt::format("palpate: note: DDS: {}\n", message_line(text)));
}

std::string topic_of(dds_entity_t endpoint) {
  std::string name(256, '\0');
  const dds_entity_t topic = dds_get_topic(endpoint);
  if (topic < 0 || dds_get_name(topic, name.data(), name.size()) < 0) return "a topic";
  name.resize(name.find('\0'));
  return name;
}

}  // namespace

/// Messages already reported, for the DDS listeners.
struct Participant::Told {
  Say say;
  std::mutex mutex;
  std::set<std::string> topics;

  void once(dds_entity_t endpoint, const char* who, std::uint32_t policy) {
    const std::string topic = topic_of(endpoint);
    const std::scoped_lock lock(mutex);
    if (!topics.insert(topic + who).second) return;
    say(fmt::format(
        "{} of {} has an incompatible quality of service ({}) and is not connected; set it to best "
        "effort or reliable, volatile, keep last",
        who, topic, policy_name(policy)));
  }
  static void on_reader(dds_entity_t reader, const dds_requested_incompatible_qos_status_t status,
                        void* told) {
    static_cast<Told*>(told)->once(reader, "a publisher", status.last_policy_id);
  }
  static void on_writer(dds_entity_t writer, const dds_offered_incompatible_qos_status_t status, void* told) {
    static_cast<Told*>(told)->once(writer, "a subscriber", status.last_policy_id);
  }
};

dds_return_t checked(dds_return_t code, std::string_view what) {
  if (code < 0)
    throw Error("DDS: cannot {}: {}; see CYCLONEDDS_URI and ROS_DOMAIN_ID", what, dds_strretcode(code));
  return code;
}

Participant::Participant(Say say, const std::string& enclave) : told_(std::make_unique<Told>()) {
  told_->say = std::move(say);
  dds_set_log_sink(show_log, nullptr);
  const Enclave security = enclave_of_environment(enclave);
  if (!security.notice.empty()) told_->say(security.notice);
  const Qos qos(dds_create_qos());
  if (security.is_secured()) set_security(*qos, security);
  const Listener listener(dds_create_listener(told_.get()));
  dds_lset_requested_incompatible_qos(listener.get(), Told::on_reader);
  dds_lset_offered_incompatible_qos(listener.get(), Told::on_writer);
  // Poses arrive on threads of Cyclone DDS, which inherit the scheduling unless CYCLONEDDS_URI sets it.
  call_real_time(kNetworkPriority, [&] {
    id_ = checked(dds_create_participant(domain(), qos.get(), listener.get()), "join the domain");
  });
}

Participant::~Participant() { dds_delete(id_); }

dds_entity_t Participant::make_topic(std::string_view prefix, std::string_view name,
                                     const dds_topic_descriptor_t& type) {
  const std::string full = fmt::format("{}{}", prefix, name);
  return checked(dds_create_topic(id_, &type, full.c_str(), nullptr, nullptr), "create the topic " + full);
}

dds_entity_t Participant::make_reader(std::string_view prefix, std::string_view name,
                                      const dds_topic_descriptor_t& type, const Quality& quality) {
  const dds_entity_t topic = make_topic(prefix, name, type);
  const Qos qos = qos_of(quality);
  set_type_hash(*qos, type.m_typename);
  return checked(dds_create_reader(id_, topic, qos.get(), nullptr), fmt::format("subscribe to {}", name));
}

dds_entity_t Participant::make_writer(std::string_view prefix, std::string_view name,
                                      const dds_topic_descriptor_t& type, const Quality& quality) {
  const dds_entity_t topic = make_topic(prefix, name, type);
  const Qos qos = qos_of(quality);
  set_type_hash(*qos, type.m_typename);
  return checked(dds_create_writer(id_, topic, qos.get(), nullptr), fmt::format("publish {}", name));
}

std::uint64_t matches(dds_entity_t writer) {
  dds_publication_matched_status_t status{};
  return dds_get_publication_matched_status(writer, &status) == DDS_RETCODE_OK ? status.total_count : 0;
}

bool is_matched(dds_entity_t writer) {
  dds_publication_matched_status_t status{};
  return dds_get_publication_matched_status(writer, &status) == DDS_RETCODE_OK && status.current_count > 0;
}

std::string text_of(const dds_guid_t& guid) {
  std::string text;
  for (std::size_t k = 0; k < sizeof guid.v; ++k)
    text += fmt::format("{}{:02x}", k > 0 && k % 4 == 0 ? "." : "", guid.v[k]);
  return text;
}

std::string source_of(dds_entity_t reader, dds_instance_handle_t writer) {
  dds_builtintopic_endpoint_t* found = dds_get_matched_publication_data(reader, writer);
  if (found == nullptr) return fmt::format("writer {}", writer);
  std::string text = text_of(found->participant_key);
  dds_builtintopic_free_endpoint(found);
  return text;
}

}  // namespace palpate::ros2
