// Epochs: what a tracker has kept of one index is never used for another that is assigned to it.

#include <algorithm>
#include <array>
#include <atomic>
#include <memory>
#include <optional>
#include <set>
#include <thread>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include <palpate/collision/contact_tracker.h>
#include <palpate/collision/paper_pipeline.h>
#include <palpate/collision/splat_tracker.h>
#include <support/allocation_guard.h>
#include <support/brute_force.h>
#include <support/random_scenes.h>

namespace palpate {
namespace {

using Eigen::Vector3d;
using test::scene_of;

GaussianScene sphere(std::uint64_t seed, std::size_t count = 20000) {
  test::Random random(seed);
  return scene_of(test::sphere_of_splats(random, count));
}

/// `length` along any direction, and as far on the unit sphere by a turn.
Similarity nudge(test::Random& random, double length) {
  return {1.0, Eigen::Quaterniond(Eigen::AngleAxisd(length, random.direction())),
          length * random.direction()};
}

Similarity then(const Similarity& second, const Similarity& first) {
  return {second.scale * first.scale, (second.rotation * first.rotation).normalized(),
          second * first.translation};
}

Ellipsoid tool_at(test::Random& random) {
  return Ellipsoid::from_semi_axes({random.vector(0.97, 1.01), random.rotation()}, {0.02, 0.03, 0.04});
}

TEST(Epoch, IsAnotherForEveryIndexButACopy) {
  test::Random random(1);
  const SceneIndex index(sphere(2, 100), {}, {}), same_scene(sphere(2, 100), {}, {});
  const SceneIndex copy = index, moved = index.registered(nudge(random, 0.1)), again = index.registered({});
  const PaperPipeline paper({}, 1.0);
  const ContactQuery& as_query = copy;
  EXPECT_EQ(as_query.epoch(), index.epoch());
  const std::set<std::uint64_t> all{index.epoch(), same_scene.epoch(), moved.epoch(), again.epoch(),
                                    paper.epoch()};
  EXPECT_EQ(all.size(), 5U);
  EXPECT_EQ(all.count(0), 0U);
}

TEST(Epoch, ComesWithWhatIsAssigned) {
  test::Random random(3);
  SceneIndex index(sphere(4, 100), {}, {});
  const std::uint64_t before = index.epoch();
  const SceneIndex moved = index.registered(nudge(random, 0.1));
  index = moved;
  EXPECT_EQ(index.epoch(), moved.epoch());
  EXPECT_NE(index.epoch(), before);
}

/// A scene in which something changes now and then: it moves, or is another.
class ChangingScene {
 public:
  explicit ChangingScene(std::uint64_t seed)
      : random_(seed), of_one_(sphere(seed + 1), {}, {}), of_other_(sphere(seed + 2, 10000), {}, {}) {}

  /// \returns the next index: often the same one
  const SceneIndex& next() {
    if (random_.integer(0, 2) != 0) return now_;
    if (random_.integer(0, 9) == 0) std::swap(of_one_, of_other_);
    where_ = then(nudge(random_, random_.log_uniform(1e-6, 0.02)), where_);
    where_.translation *= 0.9;  // it stays where the tool is
    now_ = of_one_.registered(where_);
    return now_;
  }

 private:
  test::Random random_;
  SceneIndex of_one_, of_other_, now_ = of_one_;
  Similarity where_;
};

void expect_fresh(const ContactSet& tracked, const SceneIndex& index, const Ellipsoid& tool) {
  ContactSet fresh;
  index.query(tool, fresh);
  test::expect_close(tracked.contacts, fresh.contacts, tool);
}

TEST(Epoch, ATrackerAnswersForTheIndexThatThereIs) {
  ChangingScene scene(10);
  test::Random random(11);
  SceneIndex index = scene.next();
  ContactTracker tracker(index);
  ContactSet tracked;
  std::size_t contacts = 0;
  Ellipsoid tool = tool_at(random);
  for (int k = 0; k < 2000; ++k) {
    SCOPED_TRACE(k);
    index = scene.next();
    if (k % 20 == 0) tool = tool_at(random);  // else only the scene changes
    tracker.query(tool, tracked);
    expect_fresh(tracked, index, tool);
    contacts += tracked.contacts.size();
    if (testing::Test::HasFailure()) break;
  }
  EXPECT_GT(contacts, 5000U);
}

TEST(Epoch, ATrackerOfWhatIsDrawnAnswersForTheIndexThatThereIs) {
  ChangingScene scene(20);
  test::Random random(21);
  SceneIndex index = scene.next();
  SplatTracker tracker(index);
  std::size_t replaced = 0, drawn = 0;
  Ellipsoid solid = tool_at(random);
  for (int k = 0; k < 1000; ++k) {
    const std::uint64_t before = index.epoch();
    index = scene.next();
    if (k % 20 == 0) solid = tool_at(random);
    const LocalSplats& found = tracker.around(solid);
    if (index.epoch() == before) continue;
    ++replaced;
    EXPECT_TRUE(tracker.has_searched());
    SplatTracker other(index);
    const LocalSplats& fresh = other.around(solid);
    ASSERT_EQ(found.size, fresh.size) << k;
    for (std::size_t i = 0; i < found.size; ++i) {
      ASSERT_EQ(found.id[i], fresh.id[i]) << k;
      ASSERT_EQ(found.position(i), fresh.position(i)) << k;
      for (std::size_t r = 0; r < 9; ++r) ASSERT_EQ(found.whitening[r][i], fresh.whitening[r][i]) << k;
    }
    drawn += found.size;
  }
  EXPECT_GT(replaced, 200U);
  EXPECT_GT(drawn, 5000U);
}

// In the rounds of another thread that come late, too: what it has found in an index that is gone is not
// used.
TEST(Epoch, LookingAheadAnswersForTheIndexThatThereIsHoweverLate) {
  for (const int rounds : {1, 3, 20}) {
    SCOPED_TRACE(rounds);
    ChangingScene scene(30);
    test::Random random(31);
    SceneIndex index = scene.next();
    Lookahead lookahead;
    ContactTracker tracker(index, Precision::kDouble, &lookahead);
    SplatTracker splats(index, &lookahead);
    ContactSet tracked;
    Ellipsoid tool = tool_at(random);
    for (int k = 0; k < 1000; ++k) {
      SCOPED_TRACE(k);
      index = scene.next();
      if (k % 50 == 0) tool = tool_at(random);
      tracker.query(tool, tracked);
      expect_fresh(tracked, index, tool);
      splats.around(tool);
      if (k % rounds == 0) lookahead.take();
      if (k % rounds == rounds / 2) lookahead.finish();
      if (HasFailure()) return;
    }
  }
}

TEST(Epoch, LookingAheadComesToKnowTheNewIndex) {
  test::Random random(40);
  SceneIndex index(sphere(41), {}, {});
  Lookahead lookahead;
  Lookahead::Line& line = lookahead.add(index, Precision::kDouble);
  const Ellipsoid tool = tool_at(random);
  const auto round = [&] {
    line.want(index, tool);
    lookahead.take();
    lookahead.finish();
    line.want(index, tool);
  };
  round();
  EXPECT_TRUE(line.newest().covers(index, tool));
  const SceneIndex before = index;
  for (int k = 0; k < 3; ++k) {
    index = index.registered(nudge(random, 0.01));
    line.want(index, tool);
    EXPECT_FALSE(line.newest().covers(index, tool)) << "of the index before";
    round();
    EXPECT_TRUE(line.newest().covers(index, tool)) << "though the tool has not moved";
    EXPECT_FALSE(line.newest().covers(before, tool));
  }
}

/// Notes which thread lets go of it.
class Witness final : public IndexStorage {
 public:
  Witness(SceneIndex of, std::optional<std::thread::id>& gone) : of_(std::move(of)), gone_(gone) {}
  ~Witness() override { gone_ = std::this_thread::get_id(); }
  IndexView view() const override { return of_.view(); }

 private:
  SceneIndex of_;
  std::optional<std::thread::id>& gone_;
};

// Four memories in a row, of which the second is replaced before the other thread has taken it.
TEST(Epoch, TheThreadThatLooksAheadLetsGoOfWhatIsReplaced) {
  std::array<std::optional<std::thread::id>, 4> gone;
  const SceneIndex scene(sphere(50, 1000), {}, {});
  const auto make = [&](std::size_t k) {
    return SceneIndex(std::make_shared<Witness>(scene, gone[k]), Similarity{});
  };
  test::Random random(51);
  const Ellipsoid tool = tool_at(random);
  ContactSet set;
  {
    SceneIndex index = make(0);
    Lookahead lookahead;
    ContactTracker tracker(index, Precision::kDouble, &lookahead);
    const auto work = [&] {
      std::thread([&] {
        lookahead.take();
        lookahead.finish();
      }).join();
    };
    const auto use = [&](SceneIndex next) {
      index = std::move(next);
      for (int k = 0; k < 10; ++k) tracker.query(tool, set);
    };
    const auto gone_here = [&] {
      return std::count(gone.begin(), gone.end(), std::optional(std::this_thread::get_id()));
    };
    use(make(1));
    EXPECT_FALSE(gone[0]) << "what looks ahead has it yet";
    use(make(2));
    EXPECT_FALSE(gone[1]) << "it is on its way";
    work();
    EXPECT_TRUE(gone[0]);
    use(index);
    work();
    EXPECT_TRUE(gone[1]);
    EXPECT_EQ(gone_here(), 0);
    use(make(3));  // its one before is in use there
    EXPECT_FALSE(gone[2]);
    work();
    EXPECT_TRUE(gone[2]);
    EXPECT_EQ(gone_here(), 0);
  }
  EXPECT_TRUE(gone[3]);
}

// For ThreadSanitizer, too.
TEST(Epoch, AnIndexIsReplacedWhileAnotherThreadLooksAhead) {
  ChangingScene scene(60);
  test::Random random(61);
  SceneIndex index = scene.next();
  Lookahead lookahead;
  ContactTracker tracker(index, Precision::kDouble, &lookahead);
  SplatTracker splats(index, &lookahead);
  std::atomic<bool> ends = false;
  std::thread worker([&] {
    while (!ends) {
      lookahead.take();
      lookahead.finish();
    }
  });
  ContactSet tracked;
  Ellipsoid tool = tool_at(random);
  for (int k = 0; k < 2000 && !testing::Test::HasFailure(); ++k) {
    SCOPED_TRACE(k);
    index = scene.next();
    if (k % 50 == 0) tool = tool_at(random);
    tracker.query(tool, tracked);
    splats.around(tool);
    expect_fresh(tracked, index, tool);
  }
  ends = true;
  worker.join();
}

TEST(Epoch, AnotherRegistrationTakesNothingFromTheHeap) {
  test::Random random(70);
  SceneIndex index(sphere(71), {}, {});
  Lookahead lookahead;
  ContactTracker tracker(index, Precision::kDouble, &lookahead);
  SplatTracker splats(index, &lookahead);
  const Ellipsoid tool = tool_at(random);
  ContactSet set;
  set.contacts.reserve(5000);
  const test::AllocationGuard guard;
  for (int k = 0; k < 200; ++k) {
    index = index.registered(nudge(random, 0.002));
    tracker.query(tool, set);
    splats.around(tool);
    lookahead.take();
    lookahead.finish();
  }
  EXPECT_EQ(guard.count(), 0U);
}

}  // namespace
}  // namespace palpate
