// What a loop is doing, for who looks on.
#include <palpate/servo/live_view.h>

#include <gtest/gtest.h>

namespace palpate {
namespace {

TickRecord record_of(double t, GovernorState state, Fault fault) {
  TickRecord record;
  record.t = t;
  record.state = state;
  record.fault = fault;
  return record;
}

TEST(LiveView, RemembersEachChangeOfStateAndOfFault) {
  LiveView view;
  view.see(record_of(1.0, GovernorState::kWaiting, Fault::kNone), {});
  EXPECT_TRUE(view.transitions().empty());
  view.see(record_of(2.0, GovernorState::kActive, Fault::kNone), {});
  view.see(record_of(3.0, GovernorState::kActive, Fault::kNone), {});
  view.see(record_of(4.0, GovernorState::kStopped, Fault::kJump), {});
  view.see(record_of(5.0, GovernorState::kStopped, Fault::kPaused), {});
  view.see(record_of(6.0, GovernorState::kStopped, Fault::kPaused), {});
  const auto told = view.transitions();
  ASSERT_EQ(told.size(), 3U);
  EXPECT_EQ(told[0].t, 2.0);
  EXPECT_EQ(told[1].t, 4.0);
  EXPECT_EQ(told[2].t, 5.0);
  EXPECT_EQ(told[1].fault, Fault::kJump);
  EXPECT_EQ(told[2].fault, Fault::kPaused);
}

TEST(LiveView, TheEndOfTheLoopIsNoChangeOfTheRun) {
  LiveView view;
  view.see(record_of(1.0, GovernorState::kActive, Fault::kNone), {});
  view.see(record_of(2.0, GovernorState::kFalling, Fault::kEnded), {});
  view.see(record_of(3.0, GovernorState::kFalling, Fault::kLateTick), {});
  view.see(record_of(4.0, GovernorState::kStopped, Fault::kEnded), {});
  view.update();
  ASSERT_EQ(view.transitions().size(), 1U);
  EXPECT_EQ(view.transitions()[0].t, 1.0);
  EXPECT_EQ(view.totals().state, GovernorState::kActive);
  EXPECT_EQ(view.newest().state, GovernorState::kStopped);
}

TEST(LiveView, ShowsALoopThatHasStalledWithoutForce) {
  LiveView view;
  TickRecord active = record_of(1.0, GovernorState::kActive, Fault::kNone);
  active.sent.force.x() = active.sent_world.force.x() = 2.0;
  active.force_scale = 1.0;
  view.see(active, {});
  EXPECT_TRUE(view.update());
  EXPECT_FALSE(view.update());
  EXPECT_FALSE(view.has_stalled());
  view.stall();
  EXPECT_TRUE(view.has_stalled());
  EXPECT_TRUE(view.update());
  EXPECT_FALSE(view.update()) << "it was told";
  EXPECT_EQ(view.newest().t, 1.0);
  EXPECT_EQ(view.newest().state, GovernorState::kStopped);
  EXPECT_EQ(view.newest().fault, Fault::kStalled);
  EXPECT_TRUE(view.newest().sent.force.isZero(0.0));
  EXPECT_TRUE(view.newest().sent_world.force.isZero(0.0));
  EXPECT_EQ(view.newest().force_scale, 0.0);
  EXPECT_EQ(view.totals().state, GovernorState::kStopped);
  active.t = 2.0;
  view.see(active, {});
  EXPECT_TRUE(view.update());
  EXPECT_FALSE(view.has_stalled());
  EXPECT_EQ(view.newest().sent.force.x(), 2.0);
  EXPECT_EQ(view.totals().state, GovernorState::kActive);
}

TEST(LiveView, OfTooManyChangesTheFirstAreTold) {
  LiveView view;
  for (std::size_t k = 0; k < LiveView::kRemembered + 10; ++k)
    view.see(record_of(static_cast<double>(k), k % 2 == 0 ? GovernorState::kActive : GovernorState::kWaiting,
                       Fault::kNone),
             {});
  const auto told = view.transitions();
  ASSERT_EQ(told.size(), LiveView::kRemembered);
  for (std::size_t k = 0; k < told.size(); ++k) ASSERT_EQ(told[k].t, static_cast<double>(k));
}

TEST(LiveView, CountsWhatHasBeenFelt) {
  LiveView view;
  EXPECT_FALSE(view.update());
  const auto see = [&](std::uint32_t contacts, double force, double margin, double port_energy) {
    TickRecord record;
    record.contacts = contacts;
    record.sent.force.y() = force;
    record.margin = margin;
    record.port_energy = port_energy;
    view.see(record, {});
    EXPECT_TRUE(view.update());
  };
  see(0, 0.0, 0.0, 0.0);
  EXPECT_EQ(view.totals().margin_min, 0.0);
  see(3, -4.0, 2.0, 0.1);
  see(7, 2.0, 1.5, 0.2);
  see(0, 0.0, 0.0, 0.2);
  see(2, 1.0, 3.0, 0.3);
  const LiveTotals totals = view.totals();
  EXPECT_EQ(totals.contact_ticks, 3U);
  EXPECT_EQ(totals.contacts_max, 7U);
  EXPECT_EQ(totals.force_max, 4.0);
  EXPECT_EQ(totals.margin_min, 1.5);
  EXPECT_EQ(totals.port_energy, 0.3);
  EXPECT_FALSE(view.update());
}

}  // namespace
}  // namespace palpate
