#include "ros2_sink.h"

#include <deque>
#include <vector>

#include "dds_time.h"
#include "ros2_services.h"
#include "ros_messages.h"

namespace palpate::ros2 {
namespace {

using node::SinkMarker;
using node::SinkStatus;
using node::SinkTransform;
using Header_ = std_msgs_msg_dds__Header_;
using Marker_ = visualization_msgs_msg_dds__Marker_;
using Transform_ = geometry_msgs_msg_dds__TransformStamped_;
using Status_ = diagnostic_msgs_msg_dds__DiagnosticStatus_;
using KeyValue_ = diagnostic_msgs_msg_dds__KeyValue_;
using Point_ = geometry_msgs_msg_dds__Point_;
using Field_ = sensor_msgs_msg_dds__PointField_;

constexpr Quality kTf{true, false, 100};  // as in tf2_ros
constexpr Quality kShown{true, false, 2};
constexpr std::uint8_t kFloat32 = 7;  // sensor_msgs/PointField

/// DDS only reads messages to be written, but their fields are not const.
char* text_of(const std::string& text) { return const_cast<char*>(text.c_str()); }
char* empty_text() {
  static char nothing[] = "";
  return nothing;
}
template <class Sequence, class Item>
Sequence sequence_of(const std::vector<Item>& items) {
  const auto count = static_cast<std::uint32_t>(items.size());
  return {count, count, const_cast<Item*>(items.data()), false};
}

Header_ header_of(const std::string& frame) { return {time_of(now()), text_of(frame)}; }
geometry_msgs_msg_dds__Quaternion_ quaternion_of(const std::array<double, 4>& q) {
  return {q[1], q[2], q[3], q[0]};
}
geometry_msgs_msg_dds__Vector3_ vector_of(const node::Vector3& v) { return {v[0], v[1], v[2]}; }
Point_ point_of(const node::Vector3& v) { return {v[0], v[1], v[2]}; }

/// \param points storage of the marker's points
Marker_ message_of(const SinkMarker& marker, const Header_& header, std::vector<Point_>& points) {
  for (const node::Vector3& point : marker.points) points.push_back(point_of(point));
  Marker_ out{};
  out.header = header;
  out.ns = text_of(marker.ns);
  out.id = marker.id;
  out.type = marker.type;
  out.action = marker.action;
  out.pose = {point_of(marker.pose.position), quaternion_of(marker.pose.orientation)};
  out.scale = vector_of(marker.scale);
  const auto& c = marker.color;
  out.color = {static_cast<float>(c[0]), static_cast<float>(c[1]), static_cast<float>(c[2]),
               static_cast<float>(c[3])};
  out.points = sequence_of<decltype(out.points)>(points);
  out.texture.header.frame_id = out.texture.format = empty_text();
  out.texture_resource = out.text = out.mesh_resource = out.mesh_file.filename = empty_text();
  return out;
}

class Ros2Sink final : public node::NodeSink {
 public:
  Ros2Sink(Participant& participant, const Resolve& resolve, std::string world,
           const std::vector<node::SinkHand>& hands)
      : world_(std::move(world)) {
    const auto writer = [&](const std::string& name, const dds_topic_descriptor_t& type,
                            const Quality& quality) {
      return participant.make_writer("rt", resolve(name), type, quality);
    };
    for (const node::SinkHand& hand : hands)
      hands_.push_back(
          {writer(hand.prefix + "/contacts", visualization_msgs_msg_dds__MarkerArray__desc, kShown),
           writer(hand.prefix + "/tool", visualization_msgs_msg_dds__MarkerArray__desc, kShown)});
    transforms_ = writer("/tf", tf2_msgs_msg_dds__TFMessage__desc, kTf);
    diagnostics_ = writer("/diagnostics", diagnostic_msgs_msg_dds__DiagnosticArray__desc, kShown);
    centers_ = writer("palpate/centers", sensor_msgs_msg_dds__PointCloud2__desc, kLatched);
    for (const node::Pace pace : node::kPaces) services_.emplace_back(participant, resolve, hands, pace);
  }
  ~Ros2Sink() override {
    for (const Hand& hand : hands_) {
      dds_delete(hand.contacts);
      dds_delete(hand.tool);
    }
    for (const dds_entity_t writer : {transforms_, diagnostics_, centers_}) dds_delete(writer);
  }

  bool wants_contacts(std::size_t hand) const override { return is_matched(hands_[hand].contacts); }
  void publish_contacts(std::size_t hand, const std::vector<SinkMarker>& markers) override {
    write_markers(hands_[hand].contacts, markers);
  }
  void publish_tool(std::size_t hand, const std::vector<SinkMarker>& markers) override {
    write_markers(hands_[hand].tool, markers);
  }

  void publish_transforms(const std::vector<SinkTransform>& transforms) override {
    std::vector<Transform_> all;
    all.reserve(transforms.size());
    for (const SinkTransform& transform : transforms)
      all.push_back({header_of(world_),
                     text_of(transform.child),
                     {vector_of(transform.pose.position), quaternion_of(transform.pose.orientation)}});
    tf2_msgs_msg_dds__TFMessage_ message{};
    message.transforms = sequence_of<decltype(message.transforms)>(all);
    dds_write(transforms_, &message);
  }

  void publish_diagnostics(const std::vector<SinkStatus>& statuses) override {
    std::vector<std::vector<KeyValue_>> values;
    std::vector<Status_> all;
    for (const SinkStatus& status : statuses) {
      std::vector<KeyValue_>& pairs = values.emplace_back();
      for (const auto& [key, value] : status.values) pairs.push_back({text_of(key), text_of(value)});
      Status_& out = all.emplace_back();
      out = {static_cast<std::uint8_t>(status.level),
             text_of(status.name),
             text_of(status.message),
             text_of(status.hardware_id),
             {}};
      out.values = sequence_of<decltype(out.values)>(pairs);
    }
    diagnostic_msgs_msg_dds__DiagnosticArray_ message{};
    message.header = {time_of(now()), empty_text()};
    message.status = sequence_of<decltype(message.status)>(all);
    dds_write(diagnostics_, &message);
  }

  void publish_centers(const std::vector<float>& points) override {
    constexpr std::uint32_t kStep = 3 * sizeof(float);
    std::array<std::string, 3> names{"x", "y", "z"};
    std::vector<Field_> fields;
    for (std::uint32_t k = 0; k < 3; ++k) fields.push_back({names[k].data(), k * 4U, kFloat32, 1});
    sensor_msgs_msg_dds__PointCloud2_ message{};
    message.header = header_of(world_);
    message.height = 1;
    message.width = static_cast<std::uint32_t>(points.size() / 3);
    message.fields = sequence_of<decltype(message.fields)>(fields);
    message.point_step = kStep;
    message.row_step = kStep * message.width;
    auto* const bytes = reinterpret_cast<std::uint8_t*>(const_cast<float*>(points.data()));
    message.data = {message.row_step, message.row_step, bytes, false};
    message.is_dense = true;
    dds_write(centers_, &message);
  }

 private:
  void write_markers(dds_entity_t writer, const std::vector<SinkMarker>& markers) {
    const Header_ header = header_of(world_);
    std::vector<std::vector<Point_>> points(markers.size());
    std::vector<Marker_> all;
    for (std::size_t k = 0; k < markers.size(); ++k) all.push_back(message_of(markers[k], header, points[k]));
    visualization_msgs_msg_dds__MarkerArray_ message{};
    message.markers = sequence_of<decltype(message.markers)>(all);
    dds_write(writer, &message);
  }

  struct Hand {
    dds_entity_t contacts, tool;
  };

  std::string world_;
  std::vector<Hand> hands_;
  dds_entity_t transforms_ = 0, diagnostics_ = 0, centers_ = 0;
  std::deque<Services> services_;  ///< one for each pace
};

}  // namespace

std::unique_ptr<node::NodeSink> make_sink(Participant& participant, const Resolve& resolve, std::string world,
                                          const std::vector<node::SinkHand>& hands) {
  return std::make_unique<Ros2Sink>(participant, resolve, std::move(world), hands);
}

}  // namespace palpate::ros2
