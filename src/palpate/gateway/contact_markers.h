/// \file
/// Contacts as markers, message by message.
#pragma once

#include <cstdint>
#include <map>
#include <vector>

#include <palpate/collision/contact.h>
#include <palpate/collision/ellipsoid_lookup.h>
#include <palpate/rosbridge/ros_message.h>

namespace palpate {

/// Makes visualization_msgs/MarkerArrays of contacts: a SPHERE in "contacts" and an ARROW in "normals" for
/// each, with the Gaussian's id, and a DELETE for each that is gone, in as many messages as a client may
/// miss.
class ContactMarkers {
 public:
  static constexpr std::size_t kMost = 256;    ///< contacts in a message, the deepest
  static constexpr std::uint64_t kReach = 60;  ///< messages in which a contact that is gone is deleted

  /// Reorders `contacts`.
  Json message(const Json& header, std::vector<Contact>& contacts, const EllipsoidLookup& ellipsoids);
  /// For a client that missed more than kReach.
  static Json reset(const Json& header) { return {{"markers", {all_deleted_marker(header)}}}; }

 private:
  std::uint64_t count_ = 0;
  std::map<std::uint32_t, std::uint64_t> seen_;  ///< number of the message that an id was last in
};

}  // namespace palpate
