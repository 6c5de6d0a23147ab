/// \file
/// The contacts of many tools at once.
#pragma once

#include <span>

#include <palpate/collision/contact.h>

namespace palpate {

/// Replaces results[i] by the contacts of tools[i], as ContactQuery::query does, for all i. Runs in parallel
/// on the calling thread's oneTBB arena and returns when all are found; no result depends on the number of
/// threads. The contacts go where earlier ones were, so that going through many tools in batches costs the
/// memory of one. Those of all at once, as columns: ContactQuery::query_batch().
///
/// Any number of threads may call at once, each with results of its own.
///
/// \pre as ContactQuery::query for every tool; results.size() == tools.size().
void query_batch(const ContactQuery& query, std::span<const Ellipsoid> tools, std::span<ContactSet> results);

}  // namespace palpate
