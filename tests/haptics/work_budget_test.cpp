// What a tick may spend to look at the scene.

#include <functional>

#include <gtest/gtest.h>

#include <palpate/haptics/work_budget.h>

namespace palpate {
namespace {

int views_of_a_tick(WorkBudget& budget, std::size_t near, std::size_t in_window, std::size_t drawn) {
  budget.refill();
  int views = 0;
  for (; !budget.is_spent(); ++views) budget.spend_on_view(near, in_window, drawn);
  return views;
}

TEST(WorkBudget, AllowsFewerViewsTheMoreTheyContain) {
  WorkBudget budget;
  const int empty = views_of_a_tick(budget, 0, 0, 0), near = views_of_a_tick(budget, 500, 0, 0),
            in_window = views_of_a_tick(budget, 500, 500, 0), drawn = views_of_a_tick(budget, 500, 500, 500);
  EXPECT_GT(empty, near);
  EXPECT_GT(near, in_window);
  EXPECT_GT(in_window, drawn);
  EXPECT_GT(drawn, 4);
}

// Of a patch with as many witnesses and a scene with as many regions as there may be, a few.
TEST(WorkBudget, AllowsToFindTheMaterialsOfAFewPatches) {
  WorkBudget budget;
  int patches = 0;
  for (; !budget.is_spent(); ++patches) budget.spend_on_materials(64, 256);
  EXPECT_GE(patches, 2);
  EXPECT_LE(patches, 8);
}

TEST(WorkBudget, CountsAllThatATickDoes) {
  const std::function<void(WorkBudget&)> all[] = {
      [](WorkBudget& b) { b.spend_on_touch(10); },
      [](WorkBudget& b) { b.spend_on_fit(); },
      [](WorkBudget& b) { b.spend_on_search(100, 50); },
      [](WorkBudget& b) { b.spend_on_taking_up(100); },
      [](WorkBudget& b) { b.spend_on_selection(100, 10); },
      [](WorkBudget& b) { b.spend_on_start(); },
      [](WorkBudget& b) { b.spend_on_motion(10); },
      [](WorkBudget& b) { b.spend_on_materials(64, 256); },
  };
  for (const auto& spend : all) {
    WorkBudget budget;
    for (int k = 0; k < 10'000; ++k) spend(budget);
    EXPECT_TRUE(budget.is_spent());
  }
}

// A search of any size goes on in every tick in which it is asked for.
TEST(WorkBudget, LimitsASearchToWhatIsLeft) {
  WorkBudget budget;
  const std::size_t most = budget.search_limit();
  budget.spend_on_search(most, most);
  EXPECT_LT(budget.search_limit(), most);
  while (!budget.is_spent()) budget.spend_on_part();
  EXPECT_GT(budget.search_limit(), 0U);
  EXPECT_LT(budget.search_limit(), most / 4);
}

// However many planes there are: or the proxy would wait for ever.
TEST(WorkBudget, AllowsAMotionInATickThatHasDoneNothingElse) {
  for (const std::size_t planes : {0U, 1U, 256U, 100'000U}) {
    WorkBudget budget;
    EXPECT_TRUE(budget.allows_motion(planes));
    budget.spend_on_motion(planes);
    EXPECT_FALSE(budget.is_spent()) << "there is some left to look where it goes";
  }
}

TEST(WorkBudget, IsHalfSpentBeforeItIsSpent) {
  WorkBudget budget;
  int halves = 0;
  for (; !budget.is_half_spent(); ++halves) budget.spend_on_part();
  EXPECT_FALSE(budget.is_spent());
  for (int k = 0; k < halves; ++k) budget.spend_on_part();
  EXPECT_TRUE(budget.is_spent());
}

}  // namespace
}  // namespace palpate
