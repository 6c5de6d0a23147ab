/// \file
/// Contacts and tools as markers.
#pragma once

#include <cstdint>
#include <map>
#include <vector>

#include <palpate/collision/contact.h>
#include <palpate/collision/ellipsoid_lookup.h>
#include <palpate/haptics/tool.h>
#include <palpate/rosbridge/marker.h>
#include <palpate/servo/servo_tick.h>

namespace palpate {

/// Makes the markers of contacts: a sphere in "contacts" and an arrow in "normals" for each, with the
/// Gaussian's id, and a deletion for each that is gone, in as many messages as a client may miss.
class ContactMarkers {
 public:
  static constexpr std::size_t kMost = 256;    ///< contacts in a message, the deepest
  static constexpr std::uint64_t kReach = 60;  ///< messages in which a contact that is gone is deleted

  /// Those of a message, until the next call. Reorders `contacts`.
  const std::vector<Marker>& next(std::vector<Contact>& contacts, const EllipsoidLookup& ellipsoids);
  /// For a client that missed more than kReach.
  static Marker reset() { return all_deleted_marker(); }

 private:
  std::vector<Marker> markers_;
  std::uint64_t count_ = 0;
  std::map<std::uint32_t, std::uint64_t> seen_;  ///< number of the message that an id was last in
};

/// The ellipsoids of a tool at a pose in the world, in the namespace "tool".
std::vector<Marker> tool_markers(const Tool& tool, const Pose& pose);

/// One of several hands: its tool in the namespace `name`, and what its device is sent as an arrow from the
/// tool in `name`/force, kForceArrow long a newton. \param number of the hand, by which its colour is chosen
std::vector<Marker> hand_markers(const std::string& name, std::size_t number, const Tool& tool,
                                 const TickRecord& tick);
/// Unit: [m/N].
inline constexpr double kForceArrow = 0.02;

}  // namespace palpate
