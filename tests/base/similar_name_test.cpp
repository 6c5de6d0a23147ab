// Distances and suggestions worked out by hand.
#include <palpate/base/similar_name.h>

#include <array>
#include <string>

#include <gtest/gtest.h>

namespace palpate {
namespace {

TEST(EditDistance, CountsInsertedRemovedAndReplacedLetters) {
  EXPECT_EQ(edit_distance("", ""), 0U);
  EXPECT_EQ(edit_distance("scene", "scene"), 0U);
  EXPECT_EQ(edit_distance("", "tool"), 4U);
  EXPECT_EQ(edit_distance("tool", ""), 4U);
  EXPECT_EQ(edit_distance("rate", "rates"), 1U);
  EXPECT_EQ(edit_distance("rate", "late"), 1U);
  EXPECT_EQ(edit_distance("sede", "seed"), 2U);       // two letters exchanged
  EXPECT_EQ(edit_distance("kitten", "sitting"), 3U);  // k to s, e to i, and a g
  EXPECT_EQ(edit_distance("sunday", "saturday"), 3U);
}

std::string similar(const std::string& argument) {
  const std::array<std::string, 5> names{"seed", "stiffness", "tool", "record", "opacity-min"};
  return similar_option(argument, names);
}

TEST(SimilarOption, IsTheNearestNameWithinTwoLettersOrOneForAShortName) {
  EXPECT_EQ(similar("--stifness"), "stiffness");
  EXPECT_EQ(similar("--stifnes"), "stiffness");
  EXPECT_EQ(similar("--tol"), "tool");
  EXPECT_EQ(similar("--sed=3"), "seed");
  EXPECT_EQ(similar("--opacity_min"), "opacity-min");
  EXPECT_EQ(similar("--sede"), "");    // two letters of a short name
  EXPECT_EQ(similar("--stfnes"), "");  // three letters
  EXPECT_EQ(similar("--plugin"), "");
}

TEST(SimilarOption, IsANameThatTheArgumentBeginsOrContinues) {
  EXPECT_EQ(similar("--opacity"), "opacity-min");
  EXPECT_EQ(similar("--recording-file"), "record");
}

TEST(SimilarOption, IsNothingForAnArgumentThatIsNoName) {
  EXPECT_EQ(similar("stiffness"), "");
  EXPECT_EQ(similar("-s"), "");
  EXPECT_EQ(similar("--"), "");
  EXPECT_EQ(similar("--seed" + std::string(37, 'x')), "");  // 41 letters
  EXPECT_EQ(similar("--seed" + std::string(36, 'x')), "seed");
}

}  // namespace
}  // namespace palpate
