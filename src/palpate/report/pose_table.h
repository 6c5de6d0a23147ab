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

/// One contact for display.
struct PoseContact {
  Contact contact;
  const std::string* part;  ///< name of the tool's part
  double confidence;        ///< NaN if not computed
};

/// Contacts and force of a pose.
struct PoseReport {
  std::size_t candidates, filtered;
  std::vector<PoseContact> rows;
  ForceOutput felt;
};

/// Lists contacts in the order of the scene file, independent of the index that found them.
OrderedJson pose_json(PoseReport report);

/// Lists contacts in decreasing order of K_min, as many as fit a screen. \param model name of the force model
std::string pose_text(const PoseReport& report, std::string_view model);

}  // namespace palpate
