#include "ros2_services.h"

#include <array>

#include "ros_messages.h"
#include "take_all.h"

namespace palpate::ros2 {
namespace {

using String_ = std_msgs_msg_dds__String_;
using Trigger_ = std_srvs_srv_dds__Trigger_Request_;
using TriggerDone_ = std_srvs_srv_dds__Trigger_Response_;
using SetBool_ = std_srvs_srv_dds__SetBool_Request_;
using SetBoolDone_ = std_srvs_srv_dds__SetBool_Response_;

}  // namespace

Services::Services(Participant& participant, const Resolve& resolve, const std::vector<node::SinkHand>& hands,
                   node::Pace pace)
    : participant_(participant), resolve_(resolve) {
  set_ = checked(dds_create_waitset(participant.id()), "wait for services");
  end_ = checked(dds_create_guardcondition(participant.id()), "wait for services");
  checked(dds_waitset_attach(set_, end_, end_), "wait for services");
  for (const node::SinkHand& hand : hands) {
    node::make_services(
        hand, pace, [this](const auto& name, const auto& work) { trigger(name, work); },
        [this](const auto& name, const auto& work) { set_bool(name, work); });
    node::make_listeners(hand, pace, [this](const auto& name, const auto& work) { listen(name, work); });
  }
  thread_ = std::thread([this] { run(); });
}

Services::~Services() {
  dds_set_guardcondition(end_, true);
  thread_.join();
  for (const Service& service : all_) {
    dds_delete(service.reader);
    if (service.writer != 0) dds_delete(service.writer);
  }
  dds_delete(set_);
  dds_delete(end_);
}

void Services::add(const std::string& name, const dds_topic_descriptor_t& request,
                   const dds_topic_descriptor_t& response, std::function<void(const Service&)> answer) {
  const std::string full = resolve_(name);
  const dds_entity_t reader = participant_.make_reader("rq", full + "Request", request, kServices);
  const dds_entity_t writer = participant_.make_writer("rr", full + "Reply", response, kServices);
  attach({reader, writer, std::move(answer)});
}

void Services::attach(Service service) {
  checked(dds_set_status_mask(service.reader, DDS_DATA_AVAILABLE_STATUS), "wait for services");
  checked(dds_waitset_attach(set_, service.reader, service.reader), "wait for services");
  all_.push_back(std::move(service));
}

void Services::listen(const std::string& name, std::function<void(const std::string&)> work) {
  const dds_entity_t reader =
      participant_.make_reader("rt", resolve_(name), std_msgs_msg_dds__String__desc, kServices);
  attach({reader, 0, [work = std::move(work)](const Service& service) {
            take_all<String_>(service.reader,
                              [&](const String_& message, dds_instance_handle_t) { work(message.data); });
          }});
}

void Services::trigger(const std::string& name, std::function<node::Answer()> work) {
  add(name, std_srvs_srv_dds__Trigger_Request__desc, std_srvs_srv_dds__Trigger_Response__desc,
      [work = std::move(work)](const Service& service) {
        take_all<Trigger_>(service.reader, [&](const Trigger_& request, dds_instance_handle_t) {
          node::Answer answer = work();
          const TriggerDone_ done{request.client, request.number, answer.success, answer.message.data()};
          dds_write(service.writer, &done);
        });
      });
}

void Services::set_bool(const std::string& name, std::function<node::Answer(bool)> work) {
  add(name, std_srvs_srv_dds__SetBool_Request__desc, std_srvs_srv_dds__SetBool_Response__desc,
      [work = std::move(work)](const Service& service) {
        take_all<SetBool_>(service.reader, [&](const SetBool_& request, dds_instance_handle_t) {
          node::Answer answer = work(request.data);
          const SetBoolDone_ done{request.client, request.number, answer.success, answer.message.data()};
          dds_write(service.writer, &done);
        });
      });
}

void Services::run() {
  std::array<dds_attach_t, 5> triggered{};
  for (bool ends = false; !ends;) {
    dds_waitset_wait(set_, triggered.data(), triggered.size(), DDS_INFINITY);
    for (const Service& service : all_) service.answer(service);
    if (dds_read_guardcondition(end_, &ends) < 0) return;
  }
}

}  // namespace palpate::ros2
