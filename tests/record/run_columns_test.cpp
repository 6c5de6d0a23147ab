#include <palpate/record/run_columns.h>

#include <cmath>
#include <limits>
#include <set>

#include <gtest/gtest.h>

namespace palpate {
namespace {

TEST(RunColumns, BeginWithTheTimeAndHaveNamesOfTheirOwn) {
  ASSERT_FALSE(run_columns().empty());
  EXPECT_EQ(run_columns().front().name, "t");
  std::set<std::string_view> names;
  for (const RunColumn& column : run_columns()) EXPECT_TRUE(names.insert(column.name).second) << column.name;
}

TEST(RunColumns, EachHasAPlaceOfItsOwnInARow) {
  // Small enough for every column, and another in each as far as whole numbers allow.
  const auto value_of = [](const RunColumn& column, std::size_t k) {
    return column.whole_number.empty() ? 0.5 + static_cast<double>(k)
                                       : std::fmod(static_cast<double>(k), column.most + 1.0);
  };
  RunRow row;
  for (std::size_t k = 0; k < run_columns().size(); ++k) {
    const RunColumn& column = run_columns()[k];
    ASSERT_TRUE(column.takes(value_of(column, k))) << column.name;
    column.set(row, value_of(column, k));
  }
  for (std::size_t k = 0; k < run_columns().size(); ++k) {
    const RunColumn& column = run_columns()[k];
    EXPECT_EQ(column.get(row), value_of(column, k)) << column.name;
  }
}

TEST(RunColumns, AGroupIsThereOrNot) {
  for (const RunColumn& column : run_columns()) {
    if (column.group == ColumnGroup::kAlways) continue;
    EXPECT_EQ(column.get(RunRow{}), 0.0) << column.name;
    RunRow row;
    EXPECT_FALSE(RunGroups::of(row).has(column.group));
    column.set(row, 1.0);
    EXPECT_TRUE(RunGroups::of(row).has(column.group)) << column.name;
    std::size_t of_the_group = 0;
    for (const RunColumn& other : run_columns(RunGroups::of(row)))
      of_the_group += other.group == column.group ? 1 : 0;
    EXPECT_GT(of_the_group, 1U) << column.name;
  }
}

TEST(RunColumns, EveryWordIsAnotherAndThereIsOneForEachNumber) {
  std::size_t found = 0;
  for (const RunColumn& column : run_columns()) {
    if (column.words.empty()) continue;
    ++found;
    EXPECT_EQ(column.words.size(), static_cast<std::size_t>(column.most) + 1U) << column.name;
    const std::set<std::string_view> different(column.words.begin(), column.words.end());
    EXPECT_EQ(different.size(), column.words.size()) << column.name;
    EXPECT_FALSE(different.contains("")) << column.name;
  }
  EXPECT_EQ(found, 2U);
}

TEST(RunColumns, AWholeNumberIsOneUpToItsMost) {
  std::size_t found = 0;
  for (const RunColumn& column : run_columns()) {
    if (column.whole_number.empty()) {
      EXPECT_TRUE(column.takes(-1.5)) << column.name;
      continue;
    }
    ++found;
    for (const double good : {0.0, 1.0, column.most}) EXPECT_TRUE(column.takes(good)) << column.name;
    for (const double bad : {-1.0, 0.5, column.most + 1.0, std::numeric_limits<double>::quiet_NaN()})
      EXPECT_FALSE(column.takes(bad)) << column.name << " " << bad;
  }
  EXPECT_GE(found, 3U);
}

}  // namespace
}  // namespace palpate
