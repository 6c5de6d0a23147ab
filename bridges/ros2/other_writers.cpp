#include "other_writers.h"

#include <algorithm>
#include <array>
#include <utility>

namespace palpate::ros2 {

OtherWriters::OtherWriters(const Participant& participant, std::vector<std::string> topics,
                           const std::vector<dds_entity_t>& own)
    : topics_(std::move(topics)), own_(own.size()) {
  for (std::size_t k = 0; k < own.size(); ++k) checked(dds_get_guid(own[k], &own_[k]), "read its own GUID");
  news_ = checked(dds_create_reader(participant.id(), DDS_BUILTIN_TOPIC_DCPSPUBLICATION, nullptr, nullptr),
                  "watch for other writers");
}

void OtherWriters::take(const dds_builtintopic_endpoint_t& writer, const dds_sample_info_t& info) {
  if (info.instance_state != DDS_IST_ALIVE) {
    writers_.erase(info.instance_handle);
    return;
  }
  const bool own = std::ranges::any_of(
      own_, [&](const dds_guid_t& guid) { return std::ranges::equal(guid.v, writer.key.v); });
  if (info.valid_data && !own && std::count(topics_.begin(), topics_.end(), writer.topic_name) > 0)
    writers_[info.instance_handle] = text_of(writer.participant_key);
}

std::string OtherWriters::update() {
  constexpr std::size_t kMost = 16;
  std::array<void*, kMost> samples{};
  std::array<dds_sample_info_t, kMost> info;
  for (dds_return_t count = 0; (count = dds_take(news_, samples.data(), info.data(), kMost, kMost)) > 0;) {
    for (std::size_t k = 0; k < static_cast<std::size_t>(count); ++k)
      take(*static_cast<const dds_builtintopic_endpoint_t*>(samples[k]), info[k]);
    dds_return_loan(news_, samples.data(), count);
  }
  return writers_.empty() ? std::string() : writers_.begin()->second;
}

}  // namespace palpate::ros2
