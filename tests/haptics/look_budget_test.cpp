// What a tick may spend to look at the scene.

#include <gtest/gtest.h>

#include <palpate/haptics/look_budget.h>

namespace palpate {
namespace {

int looks_of_a_tick(LookBudget& budget, std::size_t near, std::size_t drawn) {
  budget.refill();
  int looks = 0;
  for (; !budget.is_spent(); ++looks) budget.spend_on_look(near, drawn);
  return looks;
}

TEST(LookBudget, AllowsFewerLooksTheMoreTheySee) {
  LookBudget budget(true);
  const int empty = looks_of_a_tick(budget, 0, 0), near = looks_of_a_tick(budget, 500, 0),
            drawn = looks_of_a_tick(budget, 500, 500);
  EXPECT_GT(empty, near);
  EXPECT_GT(near, drawn);
  EXPECT_GT(drawn, 4);
  LookBudget of_few;
  EXPECT_GT(looks_of_a_tick(of_few, 500, 500), drawn);
}

TEST(LookBudget, OfAToolOfFewPartsCountsLooksAlone) {
  for (const bool counts_all : {false, true}) {
    LookBudget budget(counts_all);
    for (int k = 0; k < 1000; ++k) {
      budget.spend_on_touch();
      budget.spend_on_fit();
      budget.spend_on_search(100);
      budget.spend_on_selection(100, 10);
      budget.spend_on_start(10);
      budget.spend_on_motion(100);
    }
    EXPECT_EQ(budget.is_spent(), counts_all);
    EXPECT_EQ(budget.allows_motion(100), !counts_all);
  }
}

// However many planes there are: or the proxy would wait for ever.
TEST(LookBudget, AllowsAMotionInATickThatHasDoneNothingElse) {
  for (const std::size_t planes : {0U, 1U, 256U, 100'000U}) {
    LookBudget budget(true);
    EXPECT_TRUE(budget.allows_motion(planes));
    budget.spend_on_motion(planes);
    EXPECT_FALSE(budget.is_spent()) << "there is some left to look where it goes";
  }
}

TEST(LookBudget, IsHalfSpentBeforeItIsSpent) {
  LookBudget budget(true);
  int halves = 0;
  for (; !budget.is_half_spent(); ++halves) budget.spend_on_part();
  EXPECT_FALSE(budget.is_spent());
  for (int k = 0; k < halves; ++k) budget.spend_on_part();
  EXPECT_TRUE(budget.is_spent());
}

}  // namespace
}  // namespace palpate
