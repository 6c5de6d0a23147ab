#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <palpate/base/error.h>
#include <palpate/record/run_columns.h>
#include <palpate/record/run_log.h>
#include <support/temporary_file.h>

namespace palpate {
namespace {

using test::message_of;
using test::TemporaryFile;
using testing::AllOf;
using testing::AnyOf;
using testing::HasSubstr;

const std::string kHeader =
    "t,x,y,z,qw,qx,qy,qz,candidates,filtered,colliding,k_max,fx,fy,fz,tx,ty,tz,px,py,pz,compute_us";

/// A row whose every number is another.
RunRow numbered_row() {
  RunRow row;
  row.t = 1.5;
  row.tool.position << 2, 3, 4;
  row.tool.orientation = Eigen::Quaterniond(0.5, -0.5, 0.5, -0.5);
  row.candidates = 9;
  row.filtered = 8;
  row.colliding = 7;
  row.k_max = 0.25;
  row.wrench.force << 10, 11, 12;
  row.wrench.torque << 13, 14, 15;
  row.proxy << 16, 17, 18;
  row.compute_us = 19.5;
  return row;
}

const std::string kNumberedLine = "1.5,2,3,4,0.5,-0.5,0.5,-0.5,9,8,7,0.25,10,11,12,13,14,15,16,17,18,19.5";

TEST(WriteRun, WritesTheColumnsOfTheContractInOrder) {
  const TemporaryFile file("");
  write_run({numbered_row()}, file.path());
  EXPECT_EQ(file.bytes(), kHeader + "\n" + kNumberedLine + "\n");
}

TEST(WriteRun, AddsTheUserForceWhereThereIsOne) {
  const TemporaryFile file("");
  RunRow row = numbered_row();
  row.user_force = Eigen::Vector3d(20, 21, 22);
  write_run({row}, file.path());
  EXPECT_EQ(file.bytes(), kHeader + ",ufx,ufy,ufz\n" + kNumberedLine + ",20,21,22\n");
}

const std::string kLiveHeader =
    ",vx,vy,vz,wx,wy,wz,sfx,sfy,sfz,stx,sty,stz,state,fault,energy,stored,damping,margin,age_us";
const std::string kLiveLine = ",23,24,25,26,27,28,29,30,31,34,35,36,falling,over-speed,-0.5,0.25,32,1.5,33";

LiveColumns numbered_live() {
  LiveColumns live;
  live.velocity.linear << 23, 24, 25;
  live.velocity.angular << 26, 27, 28;
  live.sent.force << 29, 30, 31;
  live.sent.torque << 34, 35, 36;
  live.state = GovernorState::kFalling;
  live.fault = Fault::kOverSpeed;
  live.energy = -0.5;
  live.stored_energy = 0.25;
  live.damping = 32;
  live.margin = 1.5;
  live.age_us = 33;
  return live;
}

TEST(WriteRun, AddsWhatALiveLoopKnows) {
  const TemporaryFile file("");
  RunRow row = numbered_row();
  row.live = numbered_live();
  write_run({row}, file.path());
  EXPECT_EQ(file.bytes(), kHeader + kLiveHeader + "\n" + kNumberedLine + kLiveLine + "\n");
  row.user_force = Eigen::Vector3d(20, 21, 22);
  write_run({row}, file.path());
  EXPECT_EQ(file.bytes(),
            kHeader + ",ufx,ufy,ufz" + kLiveHeader + "\n" + kNumberedLine + ",20,21,22" + kLiveLine + "\n");
}

TEST(WriteRun, SaysHowTheRunWasMadeBeforeTheColumns) {
  const TemporaryFile file("");
  const std::string made = "[made]\nversion = \"1\"\n";
  write_run({numbered_row()}, file.path(), made);
  EXPECT_EQ(file.bytes(), "# [made]\n# version = \"1\"\n" + kHeader + "\n" + kNumberedLine + "\n");
  const palpate::Run run = read_run(file.path());
  EXPECT_EQ(run.made, made);
  ASSERT_EQ(run.rows.size(), 1U);
  EXPECT_EQ(run.rows[0].t, 1.5);
}

TEST(WriteRun, WritesTheHeaderOfAnEmptyRun) {
  const TemporaryFile file("");
  write_run({}, file.path());
  EXPECT_EQ(file.bytes(), kHeader + "\n");
}

TEST(ReadRun, ReadsEveryColumnToItsPlace) {
  const TemporaryFile file(kHeader + ",ufx,ufy,ufz\n" + kNumberedLine + ",20,21,22\n");
  const palpate::Run run = read_run(file.path());
  EXPECT_EQ(run.source, file.path());
  ASSERT_EQ(run.rows.size(), 1U);
  const RunRow& row = run.rows[0];
  const RunRow expected = numbered_row();
  EXPECT_EQ(row.t, expected.t);
  EXPECT_EQ(row.tool.position, expected.tool.position);
  EXPECT_EQ(row.tool.orientation.coeffs(), expected.tool.orientation.coeffs());
  EXPECT_EQ(row.candidates, 9U);
  EXPECT_EQ(row.filtered, 8U);
  EXPECT_EQ(row.colliding, 7U);
  EXPECT_EQ(row.k_max, 0.25);
  EXPECT_EQ(row.wrench.force, expected.wrench.force);
  EXPECT_EQ(row.wrench.torque, expected.wrench.torque);
  EXPECT_EQ(row.proxy, expected.proxy);
  EXPECT_EQ(row.compute_us, 19.5);
  ASSERT_TRUE(row.user_force.has_value());
  EXPECT_EQ(*row.user_force, Eigen::Vector3d(20, 21, 22));
}

TEST(ReadRun, ReadsWhatALiveLoopKnows) {
  const TemporaryFile file(kHeader + kLiveHeader + "\n" + kNumberedLine + kLiveLine + "\n");
  const palpate::Run run = read_run(file.path());
  ASSERT_EQ(run.rows.size(), 1U);
  EXPECT_FALSE(run.rows[0].user_force.has_value());
  ASSERT_TRUE(run.rows[0].live.has_value());
  const LiveColumns &live = *run.rows[0].live, expected = numbered_live();
  EXPECT_EQ(live.velocity.linear, expected.velocity.linear);
  EXPECT_EQ(live.velocity.angular, expected.velocity.angular);
  EXPECT_EQ(live.sent.force, expected.sent.force);
  EXPECT_EQ(live.sent.torque, expected.sent.torque);
  EXPECT_EQ(live.state, GovernorState::kFalling);
  EXPECT_EQ(live.fault, Fault::kOverSpeed);
  EXPECT_EQ(live.energy, -0.5);
  EXPECT_EQ(live.stored_energy, 0.25);
  EXPECT_EQ(live.damping, 32);
  EXPECT_EQ(live.margin, 1.5);
  EXPECT_EQ(live.age_us, 33);
}

TEST(ReadRun, TakesColumnsInAnyOrderAndMore) {
  const TemporaryFile file(
      "note,z,y,x,t,qz,qy,qx,qw,compute_us,pz,py,px,tz,ty,tx,fz,fy,fx,k_max,colliding,filtered,candidates,"
      "more\n"
      "99,4,3,2,1.5,-0.5,0.5,-0.5,0.5,19.5,18,17,16,15,14,13,12,11,10,0.25,7,8,9,98\n");
  const TemporaryFile again("");
  write_run(read_run(file.path()).rows, again.path());
  EXPECT_EQ(again.bytes(), kHeader + "\n" + kNumberedLine + "\n");
  EXPECT_FALSE(read_run(file.path()).rows[0].user_force.has_value());
}

TEST(Run, NumbersReadBackToTheBit) {
  std::mt19937_64 engine(111);
  const auto any = [&] {
    for (;;) {
      const auto v = std::bit_cast<double>(engine());
      if (std::isfinite(v)) return v;
    }
  };
  const auto vector = [&] { return Eigen::Vector3d{any(), any(), any()}; };
  std::vector<RunRow> rows;
  for (int i = 0; i < 500; ++i) {
    RunRow row;
    row.t = 0.001 * i + 1e-13 * static_cast<double>(engine() % 1000);
    row.tool.position = vector();
    row.tool.orientation.coeffs() << any(), any(), any(), any();
    row.candidates = engine() % 4294967296;
    row.filtered = engine() % 4294967296;
    row.colliding = i == 7 ? 4294967295 : engine() % 100;
    row.k_max = any();
    row.wrench = {vector(), vector()};
    row.proxy = vector();
    row.compute_us = any();
    row.user_force = vector();
    row.live.emplace().velocity = {vector(), vector()};
    row.live->sent = {vector(), vector()};
    row.live->energy = any();
    rows.push_back(row);
  }
  rows[3].wrench.force << -0.0, 5e-324, 0.0;
  const TemporaryFile file(""), again("");
  write_run(rows, file.path());
  const palpate::Run run = read_run(file.path());
  ASSERT_EQ(run.rows.size(), rows.size());
  const auto same = [](double a, double b) {
    return std::bit_cast<std::uint64_t>(a) == std::bit_cast<std::uint64_t>(b);
  };
  for (std::size_t i = 0; i < rows.size(); ++i) {
    EXPECT_TRUE(same(run.rows[i].t, rows[i].t));
    EXPECT_EQ(run.rows[i].candidates, rows[i].candidates);
    EXPECT_EQ(run.rows[i].filtered, rows[i].filtered);
    EXPECT_EQ(run.rows[i].colliding, rows[i].colliding);
    for (int k = 0; k < 3; ++k) {
      EXPECT_TRUE(same(run.rows[i].wrench.force[k], rows[i].wrench.force[k]));
      EXPECT_TRUE(same(run.rows[i].tool.position[k], rows[i].tool.position[k]));
      EXPECT_TRUE(same((*run.rows[i].user_force)[k], (*rows[i].user_force)[k]));
      EXPECT_TRUE(same(run.rows[i].live->sent.force[k], rows[i].live->sent.force[k]));
      EXPECT_TRUE(same(run.rows[i].live->sent.torque[k], rows[i].live->sent.torque[k]));
    }
  }
  write_run(run.rows, again.path());
  EXPECT_EQ(again.bytes(), file.bytes());
}

TEST(WriteRun, LeavesAnEarlierFileOnFailure) {
  const TemporaryFile file("before");
  const std::string inside_a_file = file.path() + "/run.csv";
  EXPECT_THAT(message_of<Error>([&] { write_run({numbered_row()}, inside_a_file); }),
              HasSubstr(inside_a_file));
  EXPECT_THAT(message_of<Error>([&] { write_run({numbered_row()}, "/dev/full"); }),
              HasSubstr("No space left"));
  EXPECT_EQ(file.bytes(), "before");
}

/// The message for a run of the header and these lines.
std::string message_for(const std::string& lines, const std::string& header = kHeader) {
  const TemporaryFile file(header + "\n" + lines, "run.csv");
  return message_of<Error>([&] { read_run(file.path()); });
}

std::string quoted(const std::string& name) { return std::string(1, '\'') + name + '\''; }

/// kNumberedLine with the cell of this column replaced.
std::string line_with(const std::string& column, const std::string& cell) {
  std::string line, name;
  std::size_t at = 0, cell_at = 0;
  const std::string names = kHeader + ",";
  const std::string cells = kNumberedLine + ",";
  while (at < names.size()) {
    const std::size_t end = names.find(',', at), cell_end = cells.find(',', cell_at);
    line += (names.substr(at, end - at) == column ? cell : cells.substr(cell_at, cell_end - cell_at)) + ",";
    at = end + 1;
    cell_at = cell_end + 1;
  }
  line.back() = '\n';
  return line;
}

TEST(ReadRun, NamesAMissingColumn) {
  std::size_t at = 0;
  while (at < kHeader.size()) {
    const std::size_t end = std::min(kHeader.find(',', at), kHeader.size());
    const std::string name = kHeader.substr(at, end - at);
    std::string header = kHeader;
    header.replace(at, end - at, "other");
    EXPECT_THAT(message_for(kNumberedLine + "\n", header),
                AllOf(HasSubstr("run.csv"), HasSubstr("line 1"), HasSubstr(quoted(name))));
    at = end + 1;
  }
  EXPECT_THAT(message_for(kNumberedLine + ",20,21\n", kHeader + ",ufx,ufz"),
              AllOf(HasSubstr("run.csv"), HasSubstr("'ufy'")));
}

TEST(ReadRun, NamesAMissingColumnOfAGroup) {
  for (const std::string& header : {kLiveHeader, std::string(",ufx,ufy,ufz")}) {
    for (std::size_t at = 0; at != std::string::npos; at = header.find(',', at + 1)) {
      const std::size_t end = header.find(',', at + 1);
      std::string without = header, values;
      without.erase(at, end == std::string::npos ? end : end - at);
      for (const char c : without) values += c == ',' ? ",0" : "";
      const std::string name = header.substr(at + 1, end == std::string::npos ? end : end - at - 1);
      if (name == "stx" || name == "sty" || name == "stz") continue;  // added later
      EXPECT_THAT(message_for(kNumberedLine + values + "\n", kHeader + without),
                  AllOf(HasSubstr("run.csv"), HasSubstr("line 1"), HasSubstr(quoted(name))));
    }
  }
}

TEST(ReadRun, TakesARecordingOfBeforeTheTorqueThatWasSent) {
  std::string header = kHeader + kLiveHeader, line = kNumberedLine + kLiveLine;
  header.erase(header.find(",stx,sty,stz"), std::string(",stx,sty,stz").size());
  line.erase(line.find(",34,35,36"), std::string(",34,35,36").size());
  const TemporaryFile file(header + "\n" + line + "\n");
  const palpate::Run run = read_run(file.path());
  ASSERT_EQ(run.rows.size(), 1U);
  const LiveColumns& live = run.rows.front().live.value();
  EXPECT_EQ(live.sent.force, Eigen::Vector3d(29, 30, 31));
  EXPECT_EQ(live.sent.torque, Eigen::Vector3d::Zero().eval());
  EXPECT_EQ(live.age_us, 33.0);
}

TEST(ReadRun, TakesARecordingOfBeforeStatesAndFaultsWereWords) {
  std::string line = kNumberedLine + kLiveLine;
  line.replace(line.find("falling,over-speed"), std::string("falling,over-speed").size(), "3,5");
  const TemporaryFile file(kHeader + kLiveHeader + "\n" + line + "\n");
  const palpate::Run run = read_run(file.path());
  const LiveColumns& live = run.rows.front().live.value();
  EXPECT_EQ(live.state, GovernorState::kFalling);
  EXPECT_EQ(live.fault, Fault::kOverSpeed);
}

TEST(ReadRun, NamesLineAndColumnOfWhatIsNoStateOrFault) {
  // The last of each is read; the next is not.
  const auto lines = [](const std::string& state, const std::string& fault) {
    return kNumberedLine + ",0,0,0,0,0,0,0,0,0,0,0,0," + state + "," + fault + ",0,0,0,0,0\n";
  };
  const TemporaryFile good(kHeader + kLiveHeader + "\n" + lines("4", std::to_string(kFaultCount - 1)));
  EXPECT_EQ(read_run(good.path()).rows[0].live->state, GovernorState::kStopped);
  EXPECT_EQ(read_run(good.path()).rows[0].live->fault, Fault::kEnded);
  for (const std::string bad : {"5", "-1", "0.5"}) {
    EXPECT_THAT(message_for(lines(bad, "0"), kHeader + kLiveHeader),
                AllOf(HasSubstr("line 2"), HasSubstr("'state'"), HasSubstr(bad), HasSubstr("0 to 4")));
  }
  for (const std::string& bad : {std::to_string(kFaultCount), std::string("-1"), std::string("0.5")}) {
    EXPECT_THAT(message_for(lines("0", bad), kHeader + kLiveHeader),
                AllOf(HasSubstr("line 2"), HasSubstr("'fault'"), HasSubstr(bad),
                      HasSubstr("0 to " + std::to_string(kFaultCount - 1))));
  }
}

TEST(ReadRun, NamesADuplicateColumn) {
  EXPECT_THAT(message_for(kNumberedLine + ",1\n", kHeader + ",fx"),
              AllOf(HasSubstr("run.csv"), HasSubstr("line 1"), HasSubstr("'fx'")));
}

TEST(ReadRun, NamesTheLineThatIsCut) {
  EXPECT_THAT(message_for(kNumberedLine + "\n" + line_with("t", "2").substr(0, 20) + "\n"),
              AllOf(HasSubstr("run.csv"), HasSubstr("line 3"), HasSubstr("truncated")));
}

TEST(ReadRun, NamesLineAndColumnOfWhatIsNoNumber) {
  EXPECT_THAT(message_for(kNumberedLine + "\n" + line_with("fy", "nan")),
              AllOf(HasSubstr("run.csv"), HasSubstr("line 3"), HasSubstr("'fy'")));
}

TEST(ReadRun, NamesLineAndColumnOfWhatIsNoCount) {
  for (const std::string column : {"candidates", "filtered", "colliding"}) {
    for (const std::string cell : {"-1", "1.5", "4294967296", "1e300"}) {
      EXPECT_THAT(message_for(std::string("\n").append(line_with(column, cell))),
                  AllOf(HasSubstr("run.csv"), HasSubstr("line 3"), HasSubstr(quoted(column))));
    }
  }
}

TEST(ReadRun, NamesLineAndColumnWhereTimeDoesNotIncrease) {
  for (const std::string t : {"1.5", "1.25", "-3"}) {
    EXPECT_THAT(message_for(kNumberedLine + "\n\n" + line_with("t", t)),
                AllOf(HasSubstr("run.csv"), HasSubstr("line 4"), HasSubstr("'t'"), HasSubstr(t)));
  }
}

TEST(ReadRun, RefusesARunWithoutRows) {
  EXPECT_THAT(message_for(""), AllOf(HasSubstr("run.csv"), HasSubstr("no rows")));
}

/// Rows at these times, whose other numbers differ.
std::vector<RunRow> rows_at(const std::vector<double>& times, bool live) {
  std::mt19937_64 engine(112);
  std::uniform_real_distribution<double> any(-1.0, 1.0);
  std::vector<RunRow> rows;
  for (const double t : times) {
    RunRow row = numbered_row();
    row.t = t;
    row.wrench.force << any(engine), any(engine), any(engine);
    row.compute_us = 100.0 * any(engine);
    if (live) row.live.emplace().age_us = any(engine);
    rows.push_back(row);
  }
  return rows;
}

/// What write_run() makes of them.
std::string text_of(const std::vector<RunRow>& rows) {
  const auto columns = run_columns(RunGroups::of(rows.front()));
  std::string text = run_header(columns);
  for (const RunRow& row : rows) append_run_row(text, row, columns);
  return text;
}

TEST(ReadRun, APartOfARunWithAComment) {
  const TemporaryFile file("# one\n# two\n" + text_of(rows_at({1.0, 2.0, 3.0}, true)), "run.csv");
  const palpate::Run run = read_run(file.path(), {.from = 1.5, .to = 2.5});
  ASSERT_EQ(run.rows.size(), 1U);
  EXPECT_EQ(run.rows[0].t, 2.0);
  EXPECT_EQ(run.made, "one\ntwo\n");
}

TEST(ReadRun, OfARecordingCutAnywhereTakesTheWholeLines) {
  const std::string text = text_of(rows_at({0.001, 0.002, 0.003}, true));
  const std::size_t header = text.find('\n') + 1;
  for (std::size_t length = text.find('\n', header) + 1; length <= text.size(); ++length) {
    const std::string left = text.substr(0, length);
    const TemporaryFile file(left, "run.csv");
    const palpate::Run run = read_run(file.path());
    EXPECT_EQ(run.cut, left.back() != '\n') << length;
    EXPECT_EQ(text_of(run.rows), left.substr(0, left.rfind('\n') + 1)) << length;
  }
}

TEST(ReadRun, OfACutReplayTakesTheLinesWithAllNumbers) {
  const std::string text = text_of(rows_at({0.001, 0.002}, false));
  const std::size_t second = text.find("\n0.002") + 1, last_number = text.rfind(',') + 1;
  for (std::size_t length = second; length < last_number; ++length) {
    const TemporaryFile file(text.substr(0, length), "run.csv");
    const palpate::Run run = read_run(file.path());
    EXPECT_EQ(run.cut, length != second) << length;
    EXPECT_EQ(run.rows.size(), 1U) << length;
  }
  const TemporaryFile unended(text.substr(0, text.size() - 1), "run.csv");  // as some editors leave it
  EXPECT_EQ(read_run(unended.path()).rows.size(), 2U);
  EXPECT_FALSE(read_run(unended.path()).cut);
}

TEST(ReadRun, OfACutLineAloneHasNoRows) {
  EXPECT_THAT(message_for("1.5,2"), AllOf(HasSubstr("run.csv"), HasSubstr("no rows")));
  EXPECT_THAT(message_for(kNumberedLine + kLiveLine, kHeader + kLiveHeader), HasSubstr("no rows"));
}

/// A file of two megabytes, more than is read through at once.
struct LongRun {
  LongRun() {
    std::mt19937_64 engine(113);
    std::uniform_real_distribution<double> step(0.0005, 0.0015);
    std::vector<double> times{-3.0};
    while (times.size() < 12000) times.push_back(times.back() + step(engine));
    rows = rows_at(times, false);
    write_run(rows, file.path());
  }

  TemporaryFile file{"", "run.csv"};
  std::vector<RunRow> rows;
};

TEST(ReadRun, OfAWindowReadsItsRowsAndNoOthers) {
  const LongRun run;
  ASSERT_GT(run.file.bytes().size(), 1'500'000U);
  const double first = run.rows.front().t, last = run.rows.back().t;
  std::mt19937_64 engine(114);
  std::uniform_real_distribution<double> anywhere(first - 0.5, last + 0.5);
  for (int i = 0; i < 150; ++i) {
    double from = anywhere(engine), to = anywhere(engine);
    if (from > to) std::swap(from, to);
    if (i % 3 == 0) from = run.rows[engine() % run.rows.size()].t;  // both ends belong to it
    if (i % 4 == 0) to = std::max(from, run.rows[engine() % run.rows.size()].t);
    std::vector<double> expected, found;
    for (const RunRow& row : run.rows) {
      if (row.t >= from && row.t <= to) expected.insert(expected.end(), {row.t, row.wrench.force.z()});
    }
    if (expected.empty()) {
      EXPECT_THAT(message_of<Error>([&] { read_run(run.file.path(), {.from = from, .to = to}); }),
                  HasSubstr("no rows"));
      continue;
    }
    for (const RunRow& row : read_run(run.file.path(), {.from = from, .to = to}).rows)
      found.insert(found.end(), {row.t, row.wrench.force.z()});
    EXPECT_EQ(found, expected) << i;
  }
  EXPECT_EQ(read_run(run.file.path(), RunWindow{.from = last}).rows.size(), 1U);
  EXPECT_EQ(read_run(run.file.path(), RunWindow{.to = first}).rows.size(), 1U);
}

TEST(ReadRun, OfAWindowWithoutRowsNamesTheNearest) {
  const TemporaryFile file(text_of(rows_at({1, 2, 8}, false)), "run.csv");
  const auto message = [&](const RunWindow& window) {
    return message_of<Error>([&] { read_run(file.path(), window); });
  };
  EXPECT_THAT(message({.from = 3, .to = 7}),
              AllOf(HasSubstr("run.csv"), HasSubstr("from 3 s to 7 s"), HasSubstr("2 s and 8 s")));
  EXPECT_THAT(message({.from = 9}), AllOf(HasSubstr("from 9 s on"), HasSubstr("last is at 8 s")));
  EXPECT_THAT(message({.to = 0.5}), AllOf(HasSubstr("up to 0.5 s"), HasSubstr("first is at 1 s")));
}

TEST(ReadRun, OfAWindowWithTooManyRowsSaysWhatThereIs) {
  const LongRun run;
  const auto message = [&](const RunWindow& window) {
    return message_of<Error>([&] { read_run(run.file.path(), window); });
  };
  EXPECT_EQ(read_run(run.file.path(), {.most_rows = 12000}).rows.size(), 12000U);
  EXPECT_THAT(message({.most_rows = 11999}),
              AllOf(HasSubstr("run.csv"), HasSubstr("11999 rows"), HasSubstr("from -3 s"),
                    HasSubstr(fmt::format("to {} s", run.rows.back().t)), HasSubstr("--from")));
  EXPECT_THAT(message({.from = 0, .to = 2.5, .most_rows = 100}), HasSubstr("to 2.5 s"));
}

TEST(ReadRun, OfAWindowInTheMiddleNamesTheByte) {
  const LongRun run;
  std::string text = run.file.bytes();
  const std::size_t line = text.find(fmt::format("\n{},", run.rows[6000].t)) + 1;
  const std::size_t comma = text.find(',', line);
  text[comma + 1] = 'x';
  const TemporaryFile broken(text, "run.csv");
  EXPECT_THAT(message_of<Error>([&] { read_run(broken.path(), RunWindow{.from = run.rows[5990].t}); }),
              AllOf(HasSubstr("run.csv"), HasSubstr(fmt::format("byte {}:", line)), HasSubstr("'x'")));
  EXPECT_THAT(message_of<Error>([&] { read_run(broken.path()); }), HasSubstr("line 6002:"));
  EXPECT_EQ(read_run(broken.path(), RunWindow{.to = run.rows[5990].t}).rows.size(), 5991U);
}

TEST(ReadRun, OfAWindowOfTimesInDisorderEnds) {
  LongRun run;
  std::mt19937_64 engine(115);
  std::shuffle(run.rows.begin(), run.rows.end(), engine);
  write_run(run.rows, run.file.path());
  for (int i = 0; i < 20; ++i) {
    const double from = -3.0 + 0.6 * i;
    try {
      for (const RunRow& row : read_run(run.file.path(), {.from = from, .to = from + 1.0}).rows)
        EXPECT_TRUE(row.t >= from && row.t <= from + 1.0);
    } catch (const Error& error) {
      EXPECT_THAT(error.what(), AnyOf(HasSubstr("order of time"), HasSubstr("no rows")));
    }
  }
}

/// Bytes that this process has asked files for; nothing where the system does not tell.
std::optional<std::uint64_t> bytes_read() {
  std::ifstream io("/proc/self/io");
  std::string name;
  std::uint64_t count = 0;
  if (io >> name >> count && name == "rchar:") return count;
  return std::nullopt;
}

TEST(ReadRun, OfAWindowLeavesMostOfTheFileAlone) {
  std::string text = kHeader + "\n";
  const std::string rest = kNumberedLine.substr(kNumberedLine.find(',')) + "\n";
  for (int i = 0; i < 500'000; ++i) text.append(std::to_string(i)).append(rest);
  const TemporaryFile file(text, "run.csv");
  const auto before = bytes_read();
  if (!before) GTEST_SKIP() << "no /proc/self/io";
  EXPECT_EQ(read_run(file.path(), {.from = 300'000, .to = 300'009}).rows.size(), 10U);
  EXPECT_LT(*bytes_read() - *before, text.size() / 2);
}

/// Rows 10 ms apart with these numbers of contacts and forces.
std::vector<RunRow> rows_of(const std::vector<std::pair<std::size_t, double>>& ticks) {
  std::vector<RunRow> rows(ticks.size());
  for (std::size_t i = 0; i < ticks.size(); ++i) {
    rows[i].t = 0.01 * static_cast<double>(i);
    rows[i].colliding = ticks[i].first;
    rows[i].wrench.force << 0, 0.6 * ticks[i].second, 0.8 * ticks[i].second;
  }
  return rows;
}

TEST(ContactEpisodes, AreTheStretchesOfContact) {
  const auto episodes =
      contact_episodes(rows_of({{0, 0}, {2, 1}, {5, 3}, {4, 2}, {0, 0}, {0, 0}, {0, 0}, {1, 7}}), 0.02);
  ASSERT_EQ(episodes.size(), 2U);
  EXPECT_EQ(episodes[0].first, 1U);
  EXPECT_EQ(episodes[0].last, 3U);
  EXPECT_EQ(episodes[0].peak, 2U);
  EXPECT_EQ(episodes[0].most_colliding, 5U);
  EXPECT_NEAR(episodes[0].peak_force, 3.0, 1e-15);
  EXPECT_EQ(episodes[1].first, 7U);
  EXPECT_EQ(episodes[1].last, 7U);
  EXPECT_EQ(episodes[1].peak, 7U);
  EXPECT_EQ(episodes[1].most_colliding, 1U);
  EXPECT_NEAR(episodes[1].peak_force, 7.0, 1e-15);
}

TEST(ContactEpisodes, ThePeakIsTheFirstOfEqualForces) {
  const auto episodes = contact_episodes(rows_of({{1, 4}, {9, 4}, {1, 2}}));
  ASSERT_EQ(episodes.size(), 1U);
  EXPECT_EQ(episodes[0].peak, 0U);
  EXPECT_EQ(episodes[0].most_colliding, 9U);
}

TEST(ContactEpisodes, AGapShorterThanTheMergeGapIsABounce) {
  // Contact at 0 and at 30 ms.
  const auto rows = rows_of({{1, 1}, {0, 0}, {0, 0}, {1, 5}});
  EXPECT_EQ(contact_episodes(rows, 0.031).size(), 1U);
  EXPECT_EQ(contact_episodes(rows, 0.029).size(), 2U);
  EXPECT_EQ(contact_episodes(rows, 0.0).size(), 2U);
  const auto merged = contact_episodes(rows);  // 50 ms
  ASSERT_EQ(merged.size(), 1U);
  EXPECT_EQ(merged[0].first, 0U);
  EXPECT_EQ(merged[0].last, 3U);
  EXPECT_EQ(merged[0].peak, 3U);
}

TEST(ContactEpisodes, AMergedEpisodeKeepsThePeakOfItsFirstPart) {
  const auto merged = contact_episodes(rows_of({{3, 8}, {0, 0}, {1, 5}}));
  ASSERT_EQ(merged.size(), 1U);
  EXPECT_EQ(merged[0].peak, 0U);
  EXPECT_EQ(merged[0].last, 2U);
  EXPECT_EQ(merged[0].most_colliding, 3U);
}

TEST(ContactEpisodes, RowsFarApartInTimeAreOneEpisodeWhileInContact) {
  auto rows = rows_of({{1, 1}, {1, 2}, {1, 3}});
  for (std::size_t i = 0; i < rows.size(); ++i) rows[i].t = 10.0 * static_cast<double>(i);
  const auto episodes = contact_episodes(rows);
  ASSERT_EQ(episodes.size(), 1U);
  EXPECT_EQ(episodes[0].last, 2U);
}

TEST(ContactEpisodes, OfNoContactAreNone) {
  EXPECT_TRUE(contact_episodes({}).empty());
  EXPECT_TRUE(contact_episodes(rows_of({{0, 0}, {0, 3}})).empty());
}

TEST(ContactEpisodes, ContactWithoutForceIsAnEpisode) {
  const auto episodes = contact_episodes(rows_of({{1, 0}, {2, 0}}));
  ASSERT_EQ(episodes.size(), 1U);
  EXPECT_EQ(episodes[0].peak, 0U);
  EXPECT_EQ(episodes[0].peak_force, 0.0);
}

}  // namespace
}  // namespace palpate
