#include "type_hash.h"

#include <algorithm>
#include <array>
#include <string>

namespace palpate::ros2 {
namespace {

struct TypeHash {
  std::string_view type, hash;
};

/// Type hashes of REP 2016: SHA-256 of a type's description. tests/bridges/ros2/messages.mjs recomputes them.
constexpr std::array<TypeHash, 10> kHashes{{
    {"geometry_msgs::msg::dds_::PoseStamped_",
     "10f3786d7d40fd2b54367835614bff85d4ad3b5dab62bf8bca0cc232d73b4cd8"},
    {"geometry_msgs::msg::dds_::TwistStamped_",
     "5f0fcd4f81d5d06ad9b4c4c63e3ea51b82d6ae4d0558f1d475229b1121db6f64"},
    {"geometry_msgs::msg::dds_::WrenchStamped_",
     "8dc3deaf06b2ab281f9f9a742a8961c328ca7cec16e3fd6586d3a5c83fa78f77"},
    {"std_msgs::msg::dds_::Header_", "f49fb3ae2cf070f793645ff749683ac6b06203e41c891e17701b1cb597ce6a01"},
    {"std_msgs::msg::dds_::String_", "df668c740482bbd48fb39d76a70dfd4bd59db1288021743503259e948f6b1a18"},
    {"std_msgs::msg::dds_::Float64MultiArray_",
     "1025ddc6b9552d191f89ef1a8d2f60f3d373e28b283d8891ddcc974e8c55397f"},
    {"visualization_msgs::msg::dds_::MarkerArray_",
     "86cb8800b6fb05b5eff1abd7a56f62a5641d3ae9a1c29e78e67e704f1d067dcf"},
    {"tf2_msgs::msg::dds_::TFMessage_", "e369d0f05a23ae52508854b66f6aa0437f3449d652e8cbf22d5abe85d020f087"},
    {"diagnostic_msgs::msg::dds_::DiagnosticArray_",
     "5a8a36efb05fb25070fa0fb3810290c0e6cd4862b54a8fb975a1ee8dc55a333e"},
    {"sensor_msgs::msg::dds_::PointCloud2_",
     "9198cabf7da3796ae6fe19c4cb3bdd3525492988c70522628af5daa124bae2b5"},
}};

}  // namespace

void set_type_hash(dds_qos_t& qos, std::string_view type) {
  const auto* const at =
      std::find_if(kHashes.begin(), kHashes.end(), [&](const TypeHash& known) { return known.type == type; });
  if (at == kHashes.end()) return;
  const std::string text = "typehash=RIHS01_" + std::string(at->hash) + ";";
  dds_qset_userdata(&qos, text.data(), text.size());
}

}  // namespace palpate::ros2
