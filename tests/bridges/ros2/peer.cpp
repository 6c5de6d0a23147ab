// A peer on Fast DDS that knows no message: it sends and takes the bytes that another program makes and
// reads. Commands, a line each, on stdin:
//
//   writer ID TOPIC TYPE [reliable|best_effort] [kept]
//   reader ID TOPIC TYPE [reliable|best_effort] [kept]
//   send ID HEX              once
//   newest ID                answers the bytes that came last, or -
//   count ID                 answers how many messages came
//   matched ID               answers how many others are connected
//   lost ID                  answers how many of those that were sent never came
//   clear ID                 forgets what came
//   walk WRITER RATE         sends the body so many times a second, from now on
//   sent                     answers how often that was
//   body HEX STAMP Z         of which bytes from STAMP on are the time, and from Z on a double; -1: none
//   to Z                     goes there at 0.1 m/s
//   late SECONDS             by which the time that is written is behind
//   mute 0|1                 sends nothing, or again
//   answer READER WRITER     sends back each message with the time in place of its stamp
//   trips READER             of messages that bear the stamp of a body: answers sent, answered,
//                            and p50, p99 in ms, since the last time
#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstring>
#include <iostream>
#include <map>
#include <memory>
#include <mutex>
#include <sstream>
#include <thread>
#include <vector>

#include <fastdds/rtps/transport/UDPv4TransportDescriptor.h>
#include <fastrtps/utils/IPLocator.h>
#include <fastdds/dds/domain/DomainParticipant.hpp>
#include <fastdds/dds/domain/DomainParticipantFactory.hpp>
#include <fastdds/dds/publisher/DataWriter.hpp>
#include <fastdds/dds/publisher/DataWriterListener.hpp>
#include <fastdds/dds/publisher/Publisher.hpp>
#include <fastdds/dds/subscriber/DataReader.hpp>
#include <fastdds/dds/subscriber/DataReaderListener.hpp>
#include <fastdds/dds/subscriber/SampleInfo.hpp>
#include <fastdds/dds/subscriber/Subscriber.hpp>
#include <fastdds/dds/topic/TopicDataType.hpp>
#include <fastdds/dds/topic/TypeSupport.hpp>

namespace {

using namespace eprosima::fastdds::dds;
using eprosima::fastrtps::rtps::InstanceHandle_t;
using eprosima::fastrtps::rtps::SerializedPayload_t;
using Bytes = std::vector<unsigned char>;
using Clock = std::chrono::steady_clock;

constexpr int kStamp = 4;  // behind the four bytes that tell the encoding

class RawType final : public TopicDataType {
 public:
  explicit RawType(const std::string& name) {
    setName(name.c_str());
    m_typeSize = 1 << 18;
    m_isGetKeyDefined = false;
    auto_fill_type_object(false);
    auto_fill_type_information(false);
  }
  bool serialize(void* data, SerializedPayload_t* payload) override {
    const Bytes& bytes = *static_cast<Bytes*>(data);
    if (bytes.size() > payload->max_size) return false;
    std::memcpy(payload->data, bytes.data(), bytes.size());
    payload->length = static_cast<std::uint32_t>(bytes.size());
    payload->encapsulation = CDR_LE;
    return true;
  }
  bool deserialize(SerializedPayload_t* payload, void* data) override {
    static_cast<Bytes*>(data)->assign(payload->data, payload->data + payload->length);
    return true;
  }
  std::function<std::uint32_t()> getSerializedSizeProvider(void* data) override {
    return [data] { return static_cast<std::uint32_t>(static_cast<Bytes*>(data)->size()); };
  }
  void* createData() override { return new Bytes; }
  void deleteData(void* data) override { delete static_cast<Bytes*>(data); }
  bool getKey(void*, InstanceHandle_t*, bool) override { return false; }
};

double now() {
  return std::chrono::duration<double>(std::chrono::system_clock::now().time_since_epoch()).count();
}

void stamp(Bytes& bytes, std::size_t at, double time) {
  const auto seconds = static_cast<std::int32_t>(std::floor(time));
  // Whole microseconds, which come back as they were from who keeps time in a double.
  const auto nanoseconds = static_cast<std::uint32_t>((time - seconds) * 1e6) * 1000U;
  std::memcpy(bytes.data() + at, &seconds, 4);
  std::memcpy(bytes.data() + at + 4, &nanoseconds, 4);
}
/// Of the stamp. Unit: [us].
std::int64_t stamp_of(const Bytes& bytes) {
  std::int32_t seconds = 0;
  std::uint32_t nanoseconds = 0;
  std::memcpy(&seconds, bytes.data() + kStamp, 4);
  std::memcpy(&nanoseconds, bytes.data() + kStamp + 4, 4);
  return seconds * std::int64_t{1000000} + (nanoseconds + 500U) / 1000U;
}

Bytes from_hex(const std::string& text) {
  Bytes bytes;
  for (std::size_t k = 0; k + 1 < text.size(); k += 2)
    bytes.push_back(static_cast<unsigned char>(std::stoi(text.substr(k, 2), nullptr, 16)));
  return bytes;
}
std::string to_hex(const Bytes& bytes) {
  static const char* kDigits = "0123456789abcdef";
  std::string text;
  for (const unsigned char byte : bytes) {
    text += kDigits[byte >> 4U];
    text += kDigits[byte & 15U];
  }
  return text;
}

/// Of poses that were sent, and the times from these to what answers them.
struct Trips {
  std::mutex mutex;
  std::map<std::int64_t, Clock::time_point> sent;
  std::vector<double> all;  ///< ms
  std::size_t count = 0;

  void send(std::int64_t at) {
    const std::scoped_lock lock(mutex);
    sent[at] = Clock::now();
    ++count;
  }
  void answer(std::int64_t at) {
    const std::scoped_lock lock(mutex);
    const auto found = sent.find(at);
    if (found == sent.end()) return;
    all.push_back(std::chrono::duration<double, std::milli>(Clock::now() - found->second).count());
    sent.erase(sent.begin(), std::next(found));
  }
};

struct Ear final : DataReaderListener {
  std::mutex mutex;
  Bytes newest;
  std::size_t count = 0;
  std::atomic<int> matched = 0, lost = 0;
  std::atomic<DataWriter*> answers = nullptr;
  std::atomic<Trips*> trips = nullptr;

  void on_data_available(DataReader* reader) override {
    Bytes bytes;
    SampleInfo info;
    while (reader->take_next_sample(&bytes, &info) == ReturnCode_t::RETCODE_OK) {
      if (!info.valid_data) continue;
      if (Trips* all = trips) all->answer(stamp_of(bytes));
      if (DataWriter* to = answers) {
        Bytes back = bytes;
        stamp(back, kStamp, now());
        to->write(&back);
      }
      const std::scoped_lock lock(mutex);
      newest = bytes;
      ++count;
    }
  }
  void on_sample_lost(DataReader*, const SampleLostStatus& status) override { lost = status.total_count; }
  void on_subscription_matched(DataReader*, const SubscriptionMatchedStatus& status) override {
    matched = status.current_count;
  }
};

struct Mouth final : DataWriterListener {
  std::atomic<int> matched = 0;
  void on_publication_matched(DataWriter*, const PublicationMatchedStatus& status) override {
    matched = status.current_count;
  }
};

class Peer {
 public:
  /// \param enclave a folder with the files of DDS Security; empty: not secured
  explicit Peer(std::uint32_t domain, const std::string& enclave = {}) {
    DomainParticipantQos qos;
    if (!enclave.empty()) secure(qos, enclave);
    const auto udp = std::make_shared<eprosima::fastdds::rtps::UDPv4TransportDescriptor>();
    udp->interfaceWhiteList.emplace_back("127.0.0.1");
    qos.transport().use_builtin_transports = false;
    qos.transport().user_transports.push_back(udp);
    eprosima::fastrtps::rtps::Locator_t here;
    eprosima::fastrtps::rtps::IPLocator::setIPv4(here, "127.0.0.1");
    qos.wire_protocol().builtin.initialPeersList.push_back(here);
    participant_ = DomainParticipantFactory::get_instance()->create_participant(domain, qos);
    publisher_ = participant_->create_publisher(PUBLISHER_QOS_DEFAULT);
    subscriber_ = participant_->create_subscriber(SUBSCRIBER_QOS_DEFAULT);
  }
  ~Peer() {
    ends_ = true;
    if (walker_.joinable()) walker_.join();
    participant_->delete_contained_entities();
    DomainParticipantFactory::get_instance()->delete_participant(participant_);
  }

  /// \returns what to answer; empty: nothing.
  std::string obey(std::istringstream& words);

 private:
  static void secure(DomainParticipantQos& qos, const std::string& enclave) {
    const std::string auth = "dds.sec.auth.builtin.PKI-DH.",
                      access = "dds.sec.access.builtin.Access-Permissions.";
    const std::string file = "file://" + enclave + "/";
    for (const auto& [name, value] : std::vector<std::pair<std::string, std::string>>{
             {"dds.sec.auth.plugin", "builtin.PKI-DH"},
             {"dds.sec.access.plugin", "builtin.Access-Permissions"},
             {"dds.sec.crypto.plugin", "builtin.AES-GCM-GMAC"},
             {auth + "identity_ca", file + "identity_ca.cert.pem"},
             {auth + "identity_certificate", file + "cert.pem"},
             {auth + "private_key", file + "key.pem"},
             {access + "permissions_ca", file + "permissions_ca.cert.pem"},
             {access + "governance", file + "governance.p7s"},
             {access + "permissions", file + "permissions.p7s"}})
      qos.properties().properties().emplace_back(name, value);
  }

  Topic* topic(const std::string& name, const std::string& type) {
    TypeSupport support(new RawType(type));
    support.register_type(participant_);
    return participant_->create_topic(name, type, TOPIC_QOS_DEFAULT);
  }
  template <class Qos>
  static Qos with(Qos qos, std::istringstream& words) {
    qos.reliability().kind = BEST_EFFORT_RELIABILITY_QOS;
    for (std::string word; words >> word;) {
      if (word == "reliable") qos.reliability().kind = RELIABLE_RELIABILITY_QOS;
      if (word == "kept") qos.durability().kind = TRANSIENT_LOCAL_DURABILITY_QOS;
    }
    if (words.str().find(" kept") == std::string::npos) qos.durability().kind = VOLATILE_DURABILITY_QOS;
    qos.history().kind = KEEP_LAST_HISTORY_QOS;
    qos.history().depth = 10;
    qos.endpoint().history_memory_policy = eprosima::fastrtps::rtps::PREALLOCATED_WITH_REALLOC_MEMORY_MODE;
    return qos;
  }
  void walk(DataWriter* writer, double rate);
  std::string trips(const std::string& reader);

  DomainParticipant* participant_ = nullptr;
  Publisher* publisher_ = nullptr;
  Subscriber* subscriber_ = nullptr;
  std::map<std::string, DataWriter*> writers_;
  std::map<std::string, DataReader*> readers_;
  std::map<std::string, Ear> ears_;
  std::map<std::string, Mouth> mouths_;
  std::mutex mutex_;  ///< of what follows
  Bytes body_;
  int stamp_at_ = -1, z_at_ = -1;
  double to_ = 0.05, late_ = 0.0;
  bool mute_ = false;
  Trips trips_;
  std::atomic<bool> ends_ = false;
  std::atomic<std::size_t> sent_ = 0;
  std::thread walker_;
};

void Peer::walk(DataWriter* writer, double rate) {
  double z = 0.05;
  for (auto due = Clock::now(); !ends_;
       due += std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(1.0 / rate))) {
    std::this_thread::sleep_until(due);
    Bytes bytes;
    {
      const std::scoped_lock lock(mutex_);
      z += std::clamp(to_ - z, -0.1 / rate, 0.1 / rate);
      if (mute_ || body_.empty()) continue;
      bytes = body_;
      if (stamp_at_ >= 0) stamp(bytes, static_cast<std::size_t>(stamp_at_), now() - late_);
      if (z_at_ >= 0) std::memcpy(bytes.data() + z_at_, &z, sizeof z);
    }
    trips_.send(stamp_of(bytes));
    ++sent_;
    writer->write(&bytes);
  }
}

std::string Peer::trips(const std::string& reader) {
  ears_.at(reader).trips = &trips_;
  const std::scoped_lock lock(trips_.mutex);
  std::vector<double> all = std::exchange(trips_.all, {});
  std::sort(all.begin(), all.end());
  std::ostringstream out;
  out << std::exchange(trips_.count, 0) << ' ' << all.size();
  if (!all.empty()) out << ' ' << all[all.size() / 2] << ' ' << all[all.size() * 99 / 100];
  trips_.sent.clear();
  return out.str();
}

std::string Peer::obey(std::istringstream& words) {
  std::string what, id;
  words >> what >> id;
  if (what == "writer" || what == "reader") {
    std::string name, type;
    words >> name >> type;
    Topic* const on = topic(name, type);
    if (on == nullptr) throw std::runtime_error("no topic " + name);
    if (what == "writer")
      writers_[id] = publisher_->create_datawriter(on, with(DATAWRITER_QOS_DEFAULT, words), &mouths_[id]);
    else
      readers_[id] = subscriber_->create_datareader(on, with(DATAREADER_QOS_DEFAULT, words), &ears_[id]);
    return {};
  }
  if (what == "count" || what == "newest" || what == "clear") {
    Ear& ear = ears_.at(id);
    const std::scoped_lock lock(ear.mutex);
    if (what == "count") return std::to_string(ear.count);
    if (what == "newest") return ear.newest.empty() ? "-" : to_hex(ear.newest);
    ear.newest.clear();
    ear.count = 0;
    return {};
  }
  if (what == "matched")
    return std::to_string(ears_.count(id) > 0 ? ears_.at(id).matched.load() : mouths_.at(id).matched.load());
  if (what == "trips") return trips(id);
  if (what == "lost") return std::to_string(ears_.at(id).lost);
  if (what == "sent") return std::to_string(sent_);
  std::string more;
  if (what == "send") {
    words >> more;
    Bytes bytes = from_hex(more);
    writers_.at(id)->write(&bytes);
  } else if (what == "answer") {
    words >> more;
    ears_.at(id).answers = writers_.at(more);
  } else if (what == "walk") {
    double rate = 0.0;
    words >> rate;
    walker_ = std::thread([this, writer = writers_.at(id), rate] { walk(writer, rate); });
  } else {
    const std::scoped_lock lock(mutex_);
    if (what == "body") {
      body_ = from_hex(id);
      words >> stamp_at_ >> z_at_;
    } else if (what == "to") {
      to_ = std::stod(id);
    } else if (what == "late") {
      late_ = std::stod(id);
    } else if (what == "mute") {
      mute_ = id == "1";
    } else {
      throw std::runtime_error("no command " + what);
    }
  }
  return {};
}

}  // namespace

int main(int argc, char** argv) {
  Peer peer(static_cast<std::uint32_t>(argc > 1 ? std::atoi(argv[1]) : 0), argc > 2 ? argv[2] : "");
  for (std::string line; std::getline(std::cin, line);) {
    std::istringstream words(line);
    const std::string answer = peer.obey(words);
    if (!answer.empty()) std::cout << answer << std::endl;
  }
  return 0;
}
