/// \file
/// Services of a node over DDS.
#pragma once

#include <functional>
#include <memory>
#include <thread>
#include <vector>

#include <node_sink.h>

#include "dds_entities.h"
#include "ros2_transport.h"

namespace palpate::ros2 {

/// Provides the NodeServices of all hands that have one pace as services (std_srvs/Trigger, SetBool) and
/// topics (std_msgs/String), on its own thread, during its lifetime. DDS itself has no services, and ROS 2
/// implementations map them differently; this is the mapping of rmw_cyclonedds_cpp.
class Services {
 public:
  /// \param participant must outlive it
  Services(Participant& participant, const Resolve& resolve, const std::vector<node::SinkHand>& hands,
           node::Pace pace);
  ~Services();
  Services(const Services&) = delete;
  Services& operator=(const Services&) = delete;

 private:
  struct Service {
    dds_entity_t reader, writer;                 ///< writer 0: a topic, without a response
    std::function<void(const Service&)> answer;  ///< handles all pending requests
  };

  void trigger(const std::string& name, std::function<node::Answer()> work);
  void set_bool(const std::string& name, std::function<node::Answer(bool)> work);
  void listen(const std::string& name, std::function<void(const std::string&)> work);
  void add(const std::string& name, const dds_topic_descriptor_t& request,
           const dds_topic_descriptor_t& response, std::function<void(const Service&)> answer);
  void attach(Service service);
  void run();

  Participant& participant_;
  const Resolve& resolve_;  ///< valid during construction only
  std::vector<Service> all_;
  dds_entity_t set_ = 0, end_ = 0;
  std::thread thread_;
};

}  // namespace palpate::ros2
