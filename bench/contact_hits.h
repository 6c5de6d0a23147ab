/// \file
/// From the answer of a ContactQuery to what all pipelines have in common.
#pragma once

#include <palpate/collision/contact.h>

#include "pipeline.h"

namespace palpate::bench {

inline void assign_hits(const ContactSet& contacts, std::vector<Hit>& out) {
  out.clear();
  for (const Contact& contact : contacts.contacts) out.push_back({contact.id, contact.k_min});
}

}  // namespace palpate::bench
