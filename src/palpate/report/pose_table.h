/// \file
/// Contacts and wrench of one pose, as text and JSON.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include <palpate/collision/contact.h>
#include <palpate/haptics/force_model.h>
#include <palpate/report/ordered_json.h>

namespace palpate {

/// One contact as it is shown.
struct PoseContact {
  Contact contact;
  const std::string* part;  ///< of the tool
  double confidence;        ///< NaN where nobody asked
};

/// Contacts and force of a pose.
struct PoseReport {
  std::size_t candidates, filtered;
  std::vector<PoseContact> rows;
  ForceOutput felt;
};

/// Contacts in the order of their file, whatever index found them.
OrderedJson pose_json(PoseReport report);

/// The deepest contacts first, as many as fit a screen. \param model that felt
std::string pose_text(const PoseReport& report, std::string_view model);

}  // namespace palpate
