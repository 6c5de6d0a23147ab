#include <palpate/collision/batch_query.h>

#include <cassert>
#include <cstddef>

#include <tbb/parallel_for.h>

namespace palpate {

void query_batch(const ContactQuery& query, std::span<const Ellipsoid> tools, std::span<ContactSet> results) {
  assert(results.size() == tools.size());
  tbb::parallel_for(std::size_t{0}, tools.size(), [&](std::size_t i) { query.query(tools[i], results[i]); });
}

}  // namespace palpate
