// Recordings of several hands: a file each, whole or not at all.
#include <palpate/live/run_recordings.h>

#include <filesystem>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <palpate/base/error.h>
#include <palpate/record/run_log.h>

#include <support/live_scene.h>
#include <support/temporary_file.h>

namespace palpate::test {
namespace {

std::vector<HandSetup> two_hands() {
  std::vector<HandSetup> setups;
  setups.push_back({"", plane_config(), nullptr});
  setups.push_back({"left", plane_config(), nullptr});
  return setups;
}

TEST(RunRecordings, RecordEveryTickOfEachHandInAFileOfItsOwn) {
  const TemporaryFile other("");  // for its folder
  LiveHands hands(two_hands());
  RunRecordings recordings((other.folder() / "run.csv").string(), hands, "embedder");
  ASSERT_EQ(recordings.all().size(), 2U);
  EXPECT_EQ(recordings.all()[0]->path, (other.folder() / "run.csv").string());
  EXPECT_EQ(recordings.all()[1]->path, (other.folder() / "run-left.csv").string());
  hands.start({{recordings.observer(0)}, {recordings.observer(1)}});
  EXPECT_TRUE(comes_true([&] { return hands.all()[1].system->loop().statistics().ticks > 100; }));
  hands.stop();
  recordings.close();
  EXPECT_EQ(recordings.failure(), std::nullopt);
  for (const auto& recording : recordings.all()) {
    const palpate::Run run = read_run(recording->path);
    EXPECT_GT(run.rows.size(), 0U);
    EXPECT_EQ(run.rows.size(), recording->recorder.written());
    EXPECT_THAT(run.made, testing::HasSubstr("command = \"embedder\""));
  }
}

TEST(RunRecordings, AreNoneWithoutAPath) {
  const LiveHands hands(two_hands());
  const RunRecordings recordings("", hands, "run");
  EXPECT_TRUE(recordings.all().empty());
  EXPECT_EQ(recordings.observer(1), nullptr);
  EXPECT_EQ(recordings.failure(), std::nullopt);
}

TEST(RunRecordings, LeaveNoFileOfTheirOwnIfOneExists) {
  const TemporaryFile existing("kept", "run-left.csv");
  const std::string path = (existing.folder() / "run.csv").string();
  const LiveHands hands(two_hands());
  EXPECT_THAT(message_of<Error>([&] { const RunRecordings none(path, hands, "run"); }),
              testing::HasSubstr("run-left.csv"));
  EXPECT_FALSE(std::filesystem::exists(path));
  EXPECT_EQ(existing.bytes(), "kept");
}

}  // namespace
}  // namespace palpate::test
