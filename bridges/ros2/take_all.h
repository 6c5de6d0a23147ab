/// \file
/// Reading of all samples of a DDS reader.
#pragma once

#include <array>
#include <cstddef>

#include <dds/dds.h>

namespace palpate::ros2 {

/// Calls `work(message, writer)` for each received message, in order of reception. The message is in memory
/// loaned from the reader.
template <class Message, class Work>
void take_all(dds_entity_t reader, const Work& work) {
  constexpr std::size_t kMost = 8;
  std::array<void*, kMost> samples{};
  std::array<dds_sample_info_t, kMost> info;
  for (;;) {
    const dds_return_t count = dds_take(reader, samples.data(), info.data(), kMost, kMost);
    if (count <= 0) return;
    for (std::size_t k = 0; k < static_cast<std::size_t>(count); ++k)
      if (info[k].valid_data) work(*static_cast<const Message*>(samples[k]), info[k].publication_handle);
    dds_return_loan(reader, samples.data(), count);
  }
}

}  // namespace palpate::ros2
