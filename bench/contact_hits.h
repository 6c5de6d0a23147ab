/// \file
/// Conversion of the result of a ContactQuery to the hits that all pipelines report.
#pragma once

#include <palpate/collision/contact.h>

#include "pipeline.h"

namespace palpate::bench {

inline void assign_hits(const ContactSet& contacts, std::vector<Hit>& out) {
  out.clear();
  for (const Contact& contact : contacts.contacts) out.push_back({contact.id, contact.k_min});
}

}  // namespace palpate::bench
