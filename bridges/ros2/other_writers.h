/// \file
/// Detection of other writers of a topic.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "dds_entities.h"

namespace palpate::ros2 {

/// Writers of given topics but one's own, as DDS discovers them, those of other hands of the process
/// included: a writer is gone once its participant deletes it, or has been silent for its lease. One thread
/// at a time.
class OtherWriters {
 public:
  /// \param topics full names ("rt/omni/spatial/servo_cf") \param own writers \param participant must outlive
  /// it \throws Error
  OtherWriters(const Participant& participant, std::vector<std::string> topics,
               const std::vector<dds_entity_t>& own);
  ~OtherWriters() { dds_delete(news_); }
  OtherWriters(const OtherWriters&) = delete;
  OtherWriters& operator=(const OtherWriters&) = delete;

  /// Returns the reader that has data when writers have come or gone.
  dds_entity_t news() const { return news_; }
  /// Takes the news. \returns the GUID of a participant with such a writer; empty: none.
  std::string update();

 private:
  void take(const dds_builtintopic_endpoint_t& writer, const dds_sample_info_t& info);

  std::vector<std::string> topics_;
  std::vector<dds_guid_t> own_;
  dds_entity_t news_ = 0;
  std::map<dds_instance_handle_t, std::string> writers_;  ///< GUIDs of their participants
};

}  // namespace palpate::ros2
