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

/// Has those of each hand's NodeServices that have one pace as services (std_srvs/Trigger, SetBool) and
/// topics (std_msgs/String), as long as it lives, on a thread of its own. DDS knows no services, and
/// implementations of ROS 2 differ in how they make them: this is how rmw_cyclonedds_cpp does.
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
    dds_entity_t reader, writer;                 ///< no writer (0): nothing is answered
    std::function<void(const Service&)> answer;  ///< all that has been asked
  };

  void trigger(const std::string& name, std::function<node::Answer()> work);
  void set_bool(const std::string& name, std::function<node::Answer(bool)> work);
  void listen(const std::string& name, std::function<void(const std::string&)> work);
  void add(const std::string& name, const dds_topic_descriptor_t& request,
           const dds_topic_descriptor_t& response, std::function<void(const Service&)> answer);
  void attach(Service service);
  void run();

  Participant& participant_;
  const Resolve& resolve_;  ///< while it is made
  std::vector<Service> all_;
  dds_entity_t set_ = 0, end_ = 0;
  std::thread thread_;
};

}  // namespace palpate::ros2
