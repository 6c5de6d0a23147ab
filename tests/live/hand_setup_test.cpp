#include <palpate/live/hand_setup.h>

#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <palpate/base/error.h>

#include <support/temporary_file.h>

namespace palpate::test {
namespace {

using testing::HasSubstr;

std::string refusal_of_hands(const std::vector<std::string>& texts) {
  return message_of<Error>([&] { read_hands(texts, {}); });
}

TEST(HandSetup, NamesAreThoseOfRos) {
  for (const std::string name : {"left", "l", "right_2", "a234567890123456789012345678901b"})
    EXPECT_EQ(hand_name_problem(name), "") << name;
  for (const std::string name : {"", "Left", "2left", "_left", "le ft", "le-ft", "left/right", "le\nft",
                                 "h\xc3\xa4nd", "a2345678901234567890123456789012b"})
    EXPECT_NE(hand_name_problem(name), "") << name;
}

TEST(HandSetup, NamesOfTheFirstHandsTopicsAreTaken) {
  for (const std::string name : {"tool", "client", "emergency_stop", "stiffness"})
    EXPECT_THAT(hand_name_problem(name), HasSubstr("/palpate/" + name));
}

TEST(HandSetup, AFileSaysWhatDiffersFromTheFirst) {
  LiveConfig first;
  first.scene.path = "scene.ply";
  first.force.proxy.stiffness = 321.0;
  first.device.profile = "touch";
  const TemporaryFile file("profile = \"falcon\"\nfriction = 0.5\n", "left.toml");
  const auto hands = read_hands({"left=" + file.path(), "right"}, first);
  ASSERT_EQ(hands.size(), 2U);
  LiveConfig left = first;
  left.device.profile = "falcon";
  left.force.proxy.friction = 0.5;
  EXPECT_EQ(hands[0].name, "left");
  EXPECT_EQ(hands[0].config, left);
  EXPECT_EQ(hands[1].name, "right");
  EXPECT_EQ(hands[1].config, first);
}

TEST(HandSetup, SceneAndGatewayAreForAll) {
  for (const std::string line :
       {"scene = \"other.ply\"", "opacity-min = 0.5", "no-index-file = true", "port = 0"}) {
    const TemporaryFile file("friction = 0.1\n" + line + "\n", "left.toml");
    EXPECT_THAT(refusal_of_hands({"left=" + file.path()}),
                HasSubstr(file.path() + ": line 2: '" + line.substr(0, line.find(' '))));
  }
}

TEST(HandSetup, RefusesWhatCannotBe) {
  EXPECT_THAT(refusal_of_hands({"left", "left"}), HasSubstr("two hands called 'left'"));
  EXPECT_THAT(refusal_of_hands({"config"}), HasSubstr("'config'"));
  EXPECT_THAT(refusal_of_hands({"left=/nowhere.toml"}), HasSubstr("/nowhere.toml"));
  std::vector<std::string> many;
  for (std::size_t k = 0; k < kMostHands; ++k) many.push_back("h" + std::to_string(k));
  EXPECT_THAT(refusal_of_hands(many), HasSubstr("64 hands at most"));
}

}  // namespace
}  // namespace palpate::test
