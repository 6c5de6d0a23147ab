/// \file
/// Visualization markers of contacts and tools.
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

/// Creates the markers of contacts: a sphere in namespace "contacts" and an arrow in "normals" for each, with
/// the Gaussian's id. A contact that has ended is deleted in kReach successive messages, so that a client may
/// miss some.
class ContactMarkers {
 public:
  static constexpr std::size_t kMost = 256;    ///< contacts in a message; the deepest are kept
  static constexpr std::uint64_t kReach = 60;  ///< messages in which an ended contact is deleted

  /// Returns the markers of the next message, valid until the next call. Reorders `contacts`.
  const std::vector<Marker>& next(std::vector<Contact>& contacts, const EllipsoidLookup& ellipsoids);
  /// Returns the marker for a client that missed more than kReach messages.
  static Marker reset() { return all_deleted_marker(); }

 private:
  std::vector<Marker> markers_;
  std::uint64_t count_ = 0;
  std::map<std::uint32_t, std::uint64_t> seen_;  ///< number of the message that an id was last in
};

/// Returns the ellipsoids of a tool at a pose in the world frame, in the namespace "tool".
std::vector<Marker> tool_markers(const Tool& tool, const Pose& pose);

/// Returns the markers of one of several hands: its tool in the namespace `name`, and the commanded force as
/// an arrow from the tool in `name`/force, of length kForceArrow per newton. \param number of the hand,
/// selects its colour
std::vector<Marker> hand_markers(const std::string& name, std::size_t number, const Tool& tool,
                                 const TickRecord& tick);
/// Length of a force arrow per newton. Unit: [m/N].
inline constexpr double kForceArrow = 0.02;

}  // namespace palpate
