// query_batch: what one query at a time answers, on any number of threads.

#include <algorithm>
#include <atomic>
#include <bit>
#include <cstdint>
#include <vector>

#include <gtest/gtest.h>
#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include <palpate/collision/batch_query.h>
#include <palpate/collision/contact_columns.h>
#include <palpate/collision/scene_index.h>
#include <support/parallel.h>
#include <support/random_scenes.h>

namespace palpate {
namespace {

using test::scene_of;

/// Every number of an answer, as bits.
std::vector<std::uint64_t> bits_of(const ContactSet& set) {
  std::vector<std::uint64_t> bits{set.candidates, set.filtered, set.contacts.size()};
  const auto add = [&](double v) { bits.push_back(std::bit_cast<std::uint64_t>(v)); };
  for (const Contact& c : set.contacts) {
    bits.push_back(c.id);
    for (const double v : {c.k_min, c.lambda, c.opacity, c.depth}) add(v);
    for (const Eigen::Vector3d& p : {c.center, c.point, c.normal})
      for (const double v : p) add(v);
  }
  return bits;
}

class BatchQuery : public testing::Test {
 protected:
  test::Random random_{501};
  const SceneIndex index_{scene_of(test::sphere_of_splats(random_, 5000)), {}, {}};
  const std::vector<Ellipsoid> tools_ = test::tools_at_sphere(random_, 900);

  /// One query after the other.
  std::vector<std::vector<std::uint64_t>> one_by_one() const {
    std::vector<std::vector<std::uint64_t>> answers;
    ContactSet set;
    for (const Ellipsoid& tool : tools_) {
      index_.query(tool, set);
      answers.push_back(bits_of(set));
    }
    return answers;
  }

  void expect_all(const std::vector<ContactSet>& results) const {
    const auto expected = one_by_one();
    ASSERT_EQ(results.size(), expected.size());
    for (std::size_t i = 0; i < results.size(); ++i) ASSERT_EQ(bits_of(results[i]), expected[i]) << i;
  }
};

TEST_F(BatchQuery, AnswersAsOneQueryAtATimeOnAnyNumberOfThreads) {
  for (const std::size_t threads : {1, 2, 4}) {
    SCOPED_TRACE(threads);
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    std::vector<ContactSet> results(tools_.size());
    query_batch(index_, tools_, results);
    expect_all(results);
  }
}

TEST_F(BatchQuery, TouchesSomethingAndMissesSomething) {  // else the others would prove little
  std::vector<ContactSet> results(tools_.size());
  query_batch(index_, tools_, results);
  const auto touching =
      std::count_if(results.begin(), results.end(), [](const ContactSet& r) { return !r.contacts.empty(); });
  EXPECT_GT(touching, 100);
  EXPECT_LT(touching, static_cast<std::ptrdiff_t>(tools_.size()));
}

TEST_F(BatchQuery, ReplacesWhatIsThere) {
  std::vector<ContactSet> results(tools_.size());
  for (ContactSet& set : results) {
    set.candidates = set.filtered = 12345;
    set.contacts.resize(1000);
  }
  query_batch(index_, tools_, results);
  expect_all(results);
}

TEST_F(BatchQuery, ReusesTheMemoryOfTheResults) {
  std::vector<ContactSet> results(tools_.size());
  query_batch(index_, tools_, results);
  std::vector<const Contact*> memory;
  for (const ContactSet& set : results) memory.push_back(set.contacts.data());
  query_batch(index_, tools_, results);
  for (std::size_t i = 0; i < results.size(); ++i) EXPECT_EQ(results[i].contacts.data(), memory[i]) << i;
}

TEST_F(BatchQuery, ServesManyThreadsAtOnce) {
  std::vector<std::vector<ContactSet>> results(test::kThreads, std::vector<ContactSet>(tools_.size()));
  test::on_threads([&](std::size_t i) { query_batch(index_, tools_, results[i]); });
  for (const auto& own : results) expect_all(own);
}

/// Notes whether it is ever asked outside a given arena.
class ArenaWitness final : public ContactQuery {
 public:
  void query(const Ellipsoid&, ContactSet& result) const override {
    result.clear();
    ++asked;
    if (tbb::this_task_arena::max_concurrency() != 3) ++elsewhere;
  }
  mutable std::atomic<int> asked{0}, elsewhere{0};
};

TEST_F(BatchQuery, StaysInTheArenaOfTheCaller) {
  const ArenaWitness witness;
  std::vector<ContactSet> results(tools_.size());
  tbb::task_arena arena(3);
  arena.execute([&] { query_batch(witness, tools_, results); });
  EXPECT_EQ(witness.asked, static_cast<int>(tools_.size()));
  EXPECT_EQ(witness.elsewhere, 0);
}

/// The contacts of tool `i`, as one query has them.
ContactSet set_of(const ContactColumns& columns, std::size_t i) {
  ContactSet set;
  set.candidates = columns.candidates[i];
  set.filtered = columns.filtered[i];
  for (std::size_t k = columns.first[i]; k < columns.first[i + 1]; ++k)
    set.contacts.push_back(columns.contact(k));
  return set;
}

TEST_F(BatchQuery, ColumnsAreWhatOneQueryAtATimeAnswersOnAnyNumberOfThreads) {
  const auto expected = one_by_one();
  ContactColumns columns;  // that are filled again
  for (const std::size_t threads : {1, 2, 4}) {
    SCOPED_TRACE(threads);
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    index_.query_batch(tools_, columns);
    ASSERT_EQ(columns.tools(), tools_.size());
    ASSERT_EQ(columns.candidates.size(), tools_.size());
    ASSERT_EQ(columns.filtered.size(), tools_.size());
    for (std::size_t i = 0; i < tools_.size(); ++i) ASSERT_EQ(bits_of(set_of(columns, i)), expected[i]) << i;
    EXPECT_EQ(columns.first.back(), columns.contacts());
    EXPECT_GT(columns.contacts(), 1000U);
  }
}

TEST_F(BatchQuery, ColumnsHaveARowEachForAllContacts) {
  ContactColumns columns;
  index_.query_batch(tools_, columns);
  const std::size_t n = columns.contacts();
  for (const std::size_t size :
       {columns.k_min.size(), columns.lambda.size(), columns.opacity.size(), columns.center.size(),
        columns.point.size(), columns.normal.size(), columns.depth.size(), columns.extent.size()})
    EXPECT_EQ(size, n);
  ContactSet set;
  index_.query(tools_[0], set);
  for (std::size_t k = 0; k < set.contacts.size(); ++k)
    EXPECT_EQ(columns.contact(columns.first[0] + k).extent, set.contacts[k].extent);
  index_.query_batch({}, columns);
  EXPECT_EQ(columns.tools() + columns.contacts() + columns.candidates.size() + columns.depth.size(), 0U);
  EXPECT_EQ(columns.first, std::vector<std::size_t>{0});
}

/// Answers batches by itself, and never a single tool.
class Elsewhere final : public ContactQuery {
 public:
  void query(const Ellipsoid&, ContactSet&) const override { FAIL() << "one at a time"; }
  void query_batch(std::span<const Ellipsoid> tools, ContactColumns& result) const override {
    result.clear();
    result.append(std::vector<ContactSet>(tools.size()));
  }
};

TEST_F(BatchQuery, MayBeAnsweredElsewhere) {
  const Elsewhere elsewhere;
  const ContactQuery& query = elsewhere;
  ContactColumns columns;
  index_.query_batch(tools_, columns);
  query.query_batch(tools_, columns);
  EXPECT_EQ(columns.tools(), tools_.size());
  EXPECT_EQ(columns.contacts(), 0U);
}

TEST_F(BatchQuery, OfNothingDoesNothing) { EXPECT_NO_THROW(query_batch(index_, {}, {})); }

}  // namespace
}  // namespace palpate
