#include <palpate/report/ordered_json.h>

namespace palpate {

std::string json_text(const OrderedJson& json, int indent) {
  return json.dump(indent, ' ', false, OrderedJson::error_handler_t::replace);
}

OrderedJson vector_json(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }

OrderedJson tool_json(const Tool& tool) {
  OrderedJson json = OrderedJson::array();
  for (const ToolPart& part : tool.parts()) {
    const Eigen::Quaterniond& q = part.pose.orientation;
    json.push_back({{"name", part.name},
                    {"semi_axes", vector_json(part.semi_axes)},
                    {"position", vector_json(part.pose.position)},
                    {"orientation", {q.w(), q.x(), q.y(), q.z()}}});
  }
  return json;
}

}  // namespace palpate
