#include <palpate/record/recorder.h>

#include <atomic>
#include <bit>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <limits>
#include <new>
#include <random>
#include <string>
#include <thread>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include <palpate/base/error.h>
#include <palpate/record/run_log.h>
#include <support/allocation_guard.h>
#include <support/full_disk.h>
#include <support/temporary_file.h>

namespace palpate {
namespace {

using std::chrono::milliseconds;
using std::chrono::steady_clock;
using test::message_of;
using test::TemporaryFile;
using testing::AllOf;
using testing::HasSubstr;

/// A recording that is not there yet, in a folder of its own.
struct Place {
  TemporaryFile neighbour{""};
  std::string path = (neighbour.folder() / "live.csv").string();
};

/// The i-th row of a recording: every number is another, and none is short.
RunRow row_of(std::uint64_t i) {
  std::mt19937_64 engine(i);
  RunRow row;
  for (const RunColumn& column : run_columns({.user_force = true, .live = true})) {
    const double fraction = static_cast<double>(engine()) - 0x1p63;
    const double any = std::ldexp(fraction, static_cast<int>(engine() % 90) - 90);
    column.set(row, column.whole_number.empty() ? any : std::fmod(static_cast<double>(i), column.most + 1.0));
  }
  row.t = 1e-3 * static_cast<double>(i);
  return row;
}

/// Whether the i-th row came back, to the bit.
bool is_row(const RunRow& row, std::uint64_t i) {
  const RunRow expected = row_of(i);
  for (const RunColumn& column : run_columns(RunGroups::of(row))) {
    if (std::bit_cast<std::uint64_t>(column.get(row)) != std::bit_cast<std::uint64_t>(column.get(expected)))
      return false;
  }
  return true;
}

TEST(Recorder, WritesARunThatReadsBackToTheBit) {
  for (const bool user_force : {false, true}) {
    const Place place;
    Recorder recorder(place.path, {.user_force = user_force});
    for (std::uint64_t i = 0; i < 5000; ++i) EXPECT_TRUE(recorder.push(row_of(i)));
    recorder.close();
    EXPECT_EQ(recorder.written(), 5000U);
    EXPECT_EQ(recorder.lost(), 0U);
    EXPECT_EQ(recorder.failure(), std::nullopt);
    const palpate::Run run = read_run(place.path);
    EXPECT_FALSE(run.cut);
    ASSERT_EQ(run.rows.size(), 5000U);
    for (std::uint64_t i = 0; i < 5000; ++i) {
      EXPECT_EQ(run.rows[i].user_force.has_value(), user_force);
      ASSERT_TRUE(run.rows[i].live.has_value());
      ASSERT_TRUE(is_row(run.rows[i], i)) << i;
    }
  }
}

TEST(Recorder, WritesTheFileThatWriteRunDoes) {
  const Place place;
  std::vector<RunRow> rows;
  for (std::uint64_t i = 0; i < 100; ++i) rows.push_back(row_of(i));
  {
    Recorder recorder(place.path, {.user_force = true});
    for (const RunRow& row : rows) recorder.push(row);
  }  // the destructor closes it
  const TemporaryFile written("");
  write_run(rows, written.path());
  std::ifstream in(place.path, std::ios::binary);
  EXPECT_EQ(std::string(std::istreambuf_iterator<char>(in), {}), written.bytes());
}

TEST(Recorder, CanBeReadWhileItGoesOn) {
  const Place place;
  Recorder recorder(place.path);
  for (std::uint64_t i = 0; i < 100; ++i) recorder.push(row_of(i));
  while (recorder.written() < 100) std::this_thread::sleep_for(milliseconds(1));
  EXPECT_EQ(read_run(place.path).rows.size(), 100U);
  EXPECT_TRUE(recorder.push(row_of(100)));
}

TEST(Recorder, CountsEveryRowThatItLoses) {
  const Place place;
  Recorder recorder(place.path, {.room = 64});
  std::uint64_t pushed = 0, taken = 0;
  std::thread producer([&] {  // faster than any writer, until the ring has gone round many times
    for (RunRow row = row_of(1); pushed < 100'000 || recorder.written() < 1000; ++pushed) {
      row.t = static_cast<double>(pushed);
      taken += recorder.push(row) ? 1 : 0;
    }
  });
  producer.join();
  recorder.close();
  EXPECT_EQ(recorder.written(), taken);
  EXPECT_EQ(recorder.written() + recorder.lost(), pushed);
  EXPECT_GT(recorder.lost(), 0U) << "the ring was to be too small";
  EXPECT_EQ(read_run(place.path).rows.size(), taken);
}

TEST(Recorder, LosesARowWhoseTimeDoesNotFollow) {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  const Place place;
  Recorder recorder(place.path);
  const auto push_at = [&](double t) {
    RunRow row = row_of(0);
    row.t = t;
    return recorder.push(row);
  };
  EXPECT_FALSE(push_at(-kInfinity));
  EXPECT_TRUE(push_at(-1.0));
  EXPECT_FALSE(push_at(-1.0));
  EXPECT_FALSE(push_at(-2.0));
  EXPECT_FALSE(push_at(kNan));
  EXPECT_FALSE(push_at(kInfinity));
  EXPECT_TRUE(push_at(std::nextafter(-1.0, 0.0)));
  recorder.close();
  EXPECT_EQ(recorder.lost(), 5U);
  EXPECT_EQ(read_run(place.path).rows.size(), 2U);
}

TEST(Recorder, WritesWhatIsNotFiniteOrNotThereAsZero) {
  const Place place;
  Recorder recorder(place.path, {.user_force = true});
  RunRow failed = row_of(1);
  failed.wrench.force.y() = std::numeric_limits<double>::quiet_NaN();
  failed.k_max = -std::numeric_limits<double>::infinity();
  failed.live->stored_energy = std::numeric_limits<double>::quiet_NaN();  // of a model without a potential
  RunRow bare;
  bare.t = 1.0;
  recorder.push(failed);
  recorder.push(bare);
  recorder.close();
  const palpate::Run run = read_run(place.path);
  ASSERT_EQ(run.rows.size(), 2U);
  EXPECT_EQ(run.rows[0].wrench.force.y(), 0.0);
  EXPECT_EQ(run.rows[0].wrench.force.x(), failed.wrench.force.x());
  EXPECT_EQ(run.rows[0].k_max, 0.0);
  EXPECT_EQ(run.rows[0].live->stored_energy, 0.0);
  EXPECT_EQ(run.rows[0].live->energy, failed.live->energy);
  EXPECT_EQ(run.rows[1].live->energy, 0.0);
  EXPECT_EQ(*run.rows[1].user_force, Eigen::Vector3d(0, 0, 0));
}

TEST(Recorder, PushTakesNothingFromTheHeap) {
  const Place place;
  Recorder recorder(place.path, {.room = 256});
  const RunRow first = row_of(0);
  RunRow row = first;
  const test::AllocationGuard guard;
  for (int i = 0; i < 2000; ++i) {  // also where the ring is full, and where the time stands still
    row.t = 1e-3 * (i / 2);
    recorder.push(row);
  }
  EXPECT_EQ(guard.count(), 0U);
}

TEST(Recorder, LosesWhatComesAfterTheEnd) {
  const Place place;
  Recorder recorder(place.path);
  EXPECT_TRUE(recorder.push(row_of(0)));
  recorder.close();
  EXPECT_FALSE(recorder.push(row_of(1)));
  recorder.close();
  EXPECT_EQ(recorder.written(), 1U);
  EXPECT_EQ(recorder.lost(), 1U);
}

TEST(Recorder, OfNothingIsARunWithoutRows) {
  const Place place;
  Recorder(place.path).close();
  EXPECT_THAT(message_of<Error>([&] { read_run(place.path); }),
              AllOf(HasSubstr("live.csv"), HasSubstr("no rows")));
}

TEST(Recorder, ReplacesNothing) {
  const TemporaryFile precious("precious", "hand.csv");
  EXPECT_THAT(message_of<Error>([&] { Recorder(precious.path()); }),
              AllOf(HasSubstr("hand.csv"), HasSubstr("exists")));
  EXPECT_EQ(precious.bytes(), "precious");
}

TEST(Recorder, RefusesAMissingFolderAndADiskThatIsFullAtOnce) {
  const Place place;
  EXPECT_THAT(message_of<Error>([&] { Recorder(place.path + "/in/none.csv"); }),
              AllOf(HasSubstr("none.csv"), HasSubstr("No such file")));
  const test::FileSizeLimit limit(100);
  EXPECT_THAT(message_of<Error>([&] { Recorder recorder(place.path); }),
              AllOf(HasSubstr("live.csv"), HasSubstr("too large")));
  EXPECT_FALSE(std::filesystem::exists(place.path));
}

/// Records onto a disk that becomes full, until the recorder notices, and looks at what is left.
void record_until_full(const std::string& path, const std::string& reason) {
  Recorder recorder(path);
  std::uint64_t pushed = 0;
  while (!recorder.failure()) {
    for (int i = 0; i < 50; ++i) recorder.push(row_of(pushed++));
    std::this_thread::sleep_for(milliseconds(1));
  }
  EXPECT_THAT(*recorder.failure(), AllOf(HasSubstr(path), HasSubstr(reason), HasSubstr("; ")));
  EXPECT_FALSE(recorder.push(row_of(pushed++)));
  recorder.close();
  EXPECT_GT(recorder.written(), 10U);
  EXPECT_GT(recorder.lost(), 0U);
  EXPECT_EQ(recorder.written() + recorder.lost(), pushed);
  EXPECT_THAT(*recorder.failure(), HasSubstr(reason));  // the first is the one to tell

  const palpate::Run run = read_run(path);
  EXPECT_FALSE(run.cut);
  ASSERT_EQ(run.rows.size(), recorder.written());
  for (std::uint64_t i = 0; i < run.rows.size(); ++i) ASSERT_TRUE(is_row(run.rows[i], i)) << i;
}

TEST(Recorder, OfADiskThatBecomesFullKeepsTheRowsThatFit) {
  const Place place;
  const test::SmallDisk disk(place.neighbour.folder(), "128k");
  if (!disk.mounted()) GTEST_SKIP() << "mounting needs root";
  record_until_full(place.path, "No space left");
}

TEST(Recorder, OfAFileThatBecomesTooLargeKeepsTheRowsThatFit) {
  // Left as it is, the signal of a file beyond its limit kills a process; it must not reach ours.
  const Place place;
  const test::FileSizeLimit limit(100'001);
  const auto before = std::signal(SIGXFSZ, SIG_DFL);
  record_until_full(place.path, "too large");
  std::signal(SIGXFSZ, before);
}

/// What a child that is killed tells its parent.
struct Shared {
  std::atomic<std::uint64_t> pushed = 0;
  /// A bystander that sleeps as the writer does wakes so late, and woke last then. How slow the machine is at
  /// the time is not the recorder's doing. Unit: [ns].
  std::atomic<std::int64_t> longest_sleep = 0, woke = 0;
};
static_assert(std::atomic<std::uint64_t>::is_always_lock_free, "shared by processes");

std::int64_t now_ns() {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(steady_clock::now().time_since_epoch()).count();
}

[[noreturn]] void record_until_killed(const std::string& path, Shared& shared) {
  Recorder recorder(path);
  std::thread bystander([&] {
    for (shared.woke = now_ns();;) {
      std::this_thread::sleep_for(milliseconds(20));
      const std::int64_t slept = now_ns() - shared.woke;
      if (slept > shared.longest_sleep) shared.longest_sleep = slept;
      shared.woke = now_ns();
    }
  });
  for (std::uint64_t i = 0;; ++i) {
    if (recorder.push(row_of(i))) shared.pushed = i + 1;
    std::this_thread::sleep_for(milliseconds(1));
  }
}

TEST(Recorder, SurvivesItsProcess) {
  std::mt19937_64 engine(201);
  std::uniform_int_distribution<int> instant(1, 250);  // ms
  void* memory = ::mmap(nullptr, sizeof(Shared), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
  ASSERT_NE(memory, MAP_FAILED);
  std::uint64_t read_in_all = 0;
  for (int round = 0; round < 20; ++round) {
    const Place place;
    auto& shared = *new (memory) Shared;
    const pid_t child = ::fork();
    ASSERT_GE(child, 0);
    if (child == 0) record_until_killed(place.path, shared);
    while (shared.pushed == 0 || shared.woke == 0) std::this_thread::sleep_for(milliseconds(1));
    std::this_thread::sleep_for(milliseconds(instant(engine)));
    ASSERT_EQ(::kill(child, SIGKILL), 0);
    ASSERT_EQ(::waitpid(child, nullptr, 0), child);
    const std::int64_t stall = std::max<std::int64_t>(shared.longest_sleep, now_ns() - shared.woke);

    std::uint64_t read = 0;
    try {
      for (const RunRow& row : read_run(place.path).rows) {
        ASSERT_TRUE(is_row(row, read)) << read;
        ++read;
      }
    } catch (const Error& error) {
      EXPECT_THAT(error.what(), HasSubstr("no rows"));
    }
    // A row takes a millisecond; the writer sleeps for twenty.
    const std::uint64_t may_be_missing = 80 + static_cast<std::uint64_t>(stall) / 1'000'000;
    EXPECT_LE(shared.pushed, read + may_be_missing) << "stall " << stall << " ns";
    EXPECT_LE(read, shared.pushed + 1);  // a row is pushed before that is told
    read_in_all += read;
  }
  EXPECT_GT(read_in_all, 200U);
  ::munmap(memory, sizeof(Shared));
}

}  // namespace
}  // namespace palpate
