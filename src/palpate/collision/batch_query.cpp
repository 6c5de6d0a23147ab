#include <palpate/collision/batch_query.h>

#include <algorithm>
#include <cassert>
#include <cstddef>
#include <vector>

#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <palpate/collision/contact_columns.h>

namespace palpate {
namespace {

/// Tools per thread whose contacts are held as sets before they become columns: enough that threads hardly
/// wait for each other, few enough for the sets of crowded poses, 270 KB each.
constexpr std::size_t kToolsPerThread = 64;

}  // namespace

void query_batch(const ContactQuery& query, std::span<const Ellipsoid> tools, std::span<ContactSet> results) {
  assert(results.size() == tools.size());
  tbb::parallel_for(std::size_t{0}, tools.size(), [&](std::size_t i) { query.query(tools[i], results[i]); });
}

void ContactQuery::query_batch(std::span<const Ellipsoid> tools, ContactColumns& result) const {
  const std::size_t block =
      kToolsPerThread * static_cast<std::size_t>(tbb::this_task_arena::max_concurrency());
  std::vector<ContactSet> sets(std::min(block, tools.size()));
  result.clear();
  for (std::size_t done = 0; done < tools.size(); done += block) {
    const std::span found = std::span(sets).first(std::min(block, tools.size() - done));
    palpate::query_batch(*this, tools.subspan(done, found.size()), found);
    result.append(found);
  }
}

}  // namespace palpate
