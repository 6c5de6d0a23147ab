#include <palpate/haptics/tool_query.h>

#include <palpate/base/append.h>

namespace palpate {
namespace {

/// Queries part by part: `ask(part, solid, most, result)` finds the contacts of one part.
template <class Ask>
void query_parts(const Tool& tool, const Pose& pose, const Ask& ask, std::size_t most, ContactSet& of_part,
                 ContactSet& result) {
  const auto parts = tool.parts();
  ask(0, parts[0].at(pose), most, result);
  for (std::uint32_t k = 1; k < parts.size(); ++k) {
    if (result.filtered >= most) result.complete = false;
    if (!result.complete) return;
    ask(k, parts[k].at(pose), most - result.filtered, of_part);
    result.complete = of_part.complete;
    for (Contact& contact : of_part.contacts) contact.part = k;
    result.candidates += of_part.candidates;
    result.filtered += of_part.filtered;
    append(result.contacts, of_part.contacts);
  }
}

}  // namespace

void query(const ContactQuery& contacts, const Tool& tool, const Pose& pose, ContactSet& result) {
  ContactSet of_part;
  const auto ask = [&](std::size_t, const Ellipsoid& solid, std::size_t, ContactSet& found) {
    contacts.query(solid, found);
  };
  query_parts(tool, pose, ask, kAllPairs, of_part, result);
}

void query(const SceneIndex& index, const Tool& tool, const Pose& pose, std::size_t most,
           ContactSet& result) {
  ContactSet of_part;
  const auto ask = [&](std::size_t, const Ellipsoid& solid, std::size_t left, ContactSet& found) {
    index.query(solid, Precision::kDouble, found, {.pairs = left});
  };
  query_parts(tool, pose, ask, most, of_part, result);
}

ToolTracker::ToolTracker(const SceneIndex& index, const Tool& tool, Precision precision, Lookahead* lookahead)
    : tool_(tool) {
  const std::size_t parts = tool.parts().size(), capacity = CandidateCache::capacity_for(parts);
  for (std::size_t k = 0; k < parts; ++k) trackers_.emplace_back(index, precision, lookahead, capacity);
  of_part_.contacts.reserve(kRoom);
}

void ToolTracker::query(const Pose& pose, ContactSet& result, std::size_t most) {
  const auto ask = [&](std::size_t part, const Ellipsoid& solid, std::size_t left, ContactSet& found) {
    trackers_[part].query(solid, found, {.pairs = left});
  };
  query_parts(tool_, pose, ask, most, of_part_, result);
}

}  // namespace palpate
