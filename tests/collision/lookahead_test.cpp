#include <palpate/collision/contact_tracker.h>

#include <algorithm>
#include <atomic>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include <palpate/study/procedural.h>
#include <support/allocation_guard.h>

namespace palpate {
namespace {

using Eigen::Vector3d;

const SceneIndex& torus() {
  static const SceneIndex index(make_scene(*make_surface("torus"), {}), {}, {});
  return index;
}

/// Where a tool is that goes round the torus at `speed`, in and out of it, and turns.
Ellipsoid tool_at(double t, double speed) {
  const double turn = speed * t / 0.12;
  Pose pose;
  pose.position = {0.12 * std::cos(turn), 0.12 * std::sin(turn), 0.07 * std::cos(3.0 * turn)};
  pose.orientation = Eigen::AngleAxisd(2.0 * turn, Vector3d(1, 2, 3).normalized());
  return Ellipsoid::from_semi_axes(pose, {0.02, 0.02, 0.04});
}

std::vector<std::uint32_t> ids(const ContactSet& set) {
  std::vector<std::uint32_t> all;
  for (const Contact& contact : set.contacts) all.push_back(contact.id);
  std::sort(all.begin(), all.end());
  return all;
}

/// Follows the tool for two seconds while looking ahead takes `rounds` ticks. \returns in how many ticks the
/// neighbourhood that was found ahead was enough.
int follow(double speed, int rounds) {
  Lookahead lookahead;
  ContactTracker tracker(torus(), Precision::kDouble, &lookahead);
  Lookahead::Line& same = lookahead.add(torus(), Precision::kDouble);
  ContactSet tracked, fresh;
  int known = 0;
  std::size_t contacts = 0;
  for (int k = 0; k < 2000; ++k) {
    const Ellipsoid tool = tool_at(1e-3 * k, speed);
    tracker.query(tool, tracked);
    torus().query(tool, fresh);
    EXPECT_EQ(ids(tracked), ids(fresh)) << "tick " << k;
    contacts += fresh.contacts.size();
    same.want(torus(), tool);
    known += same.newest().covers(torus(), tool) ? 1 : 0;
    if (k % rounds != 0) continue;
    if (k > 0) lookahead.finish();
    lookahead.take();
  }
  EXPECT_GT(contacts, 1000U);
  return known;
}

TEST(Lookahead, ContactsAreThoseOfAFreshQueryHoweverLateItIs) {
  for (const double speed : {0.01, 0.1, 1.0, 5.0})
    for (const int rounds : {1, 10, 50, 400}) follow(speed, rounds);
}

// All but the first two rounds, before which nothing is known.
TEST(Lookahead, IsThereBeforeAHandThatSlides) {
  EXPECT_GE(follow(0.1, 1), 1990);
  EXPECT_GE(follow(0.1, 50), 1890);
  EXPECT_GE(follow(0.5, 50), 1850);
}

TEST(Lookahead, DoesNothingWhileNothingMoves) {
  Lookahead lookahead;
  Lookahead::Line& line = lookahead.add(torus(), Precision::kDouble);
  const Ellipsoid tool = tool_at(0.0, 0.0);
  line.want(torus(), tool);
  lookahead.take();
  lookahead.finish();
  line.want(torus(), tool);
  const CandidateCache* const first = &line.newest();
  for (int k = 0; k < 3; ++k) {
    lookahead.take();
    lookahead.finish();
    line.want(torus(), tool);
    EXPECT_EQ(&line.newest(), first);
  }
}

TEST(Lookahead, FollowsFromAThreadOfItsOwn) {
  Lookahead lookahead;
  ContactTracker tracker(torus(), Precision::kDouble, &lookahead);
  std::atomic<bool> ends = false;
  std::thread worker([&] {
    while (!ends) {
      lookahead.take();
      lookahead.finish();
    }
  });
  ContactSet tracked, fresh;
  for (int k = 0; k < 3000; ++k) {
    const Ellipsoid tool = tool_at(1e-3 * k, 0.2);
    tracker.query(tool, tracked);
    torus().query(tool, fresh);
    ASSERT_EQ(ids(tracked), ids(fresh)) << "tick " << k;
  }
  ends = true;
  worker.join();
}

TEST(Lookahead, TakesNothingFromTheHeapOnceItRuns) {
  Lookahead lookahead;
  ContactTracker tracker(torus(), Precision::kDouble, &lookahead);
  ContactSet set;
  set.contacts.reserve(4096);
  const test::AllocationGuard guard;
  for (int k = 0; k < 500; ++k) {
    tracker.query(tool_at(1e-3 * k, 0.2), set);
    lookahead.take();
    lookahead.finish();
  }
  EXPECT_EQ(guard.count(), 0U);
}

}  // namespace
}  // namespace palpate
