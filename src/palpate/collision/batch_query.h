/// \file
/// Batched contact query of many tools.
#pragma once

#include <span>

#include <palpate/collision/contact.h>

namespace palpate {

/// Replaces results[i] by the contacts of tools[i], as ContactQuery::query does, for all i. Runs in parallel
/// on the calling thread's oneTBB arena and returns when all are found; the results do not depend on the
/// number of threads. Results reuse the memory of earlier contacts, so that processing many tools in batches
/// needs the memory of one batch. For all contacts as columns, see ContactQuery::query_batch().
///
/// Any number of threads may call concurrently, each with its own results.
///
/// \pre as ContactQuery::query for every tool; results.size() == tools.size().
void query_batch(const ContactQuery& query, std::span<const Ellipsoid> tools, std::span<ContactSet> results);

}  // namespace palpate
