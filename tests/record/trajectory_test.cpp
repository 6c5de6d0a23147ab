// Trajectory files, sound and broken.
#include <array>
#include <cmath>
#include <random>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <palpate/base/csv.h>
#include <palpate/base/error.h>
#include <palpate/record/trajectory.h>

#include "support/temporary_file.h"

namespace palpate::test {
namespace {

using testing::ContainsRegex;
using testing::HasSubstr;

Trajectory read(const std::string& text) {
  const TemporaryFile file(text, "path.csv");
  return read_trajectory(file.path());
}

std::string refusal(const std::string& text) {
  const TemporaryFile file(text, "path.csv");
  const std::string message = message_of<Error>([&] { read_trajectory(file.path()); });
  EXPECT_THAT(message, HasSubstr(file.path()));
  return message;
}

TEST(Trajectory, ReadsPoses) {
  const Trajectory t = read("t,x,y,z,qw,qx,qy,qz\n0,1,2,3,1,0,0,0\n0.5,-1e-3,.25,4,0,0,-1,0\n");
  ASSERT_EQ(t.size(), 2U);
  EXPECT_EQ(t[1].t, 0.5);
  EXPECT_EQ(t[1].pose.position, Eigen::Vector3d(-1e-3, 0.25, 4));
  EXPECT_EQ(t[1].pose.orientation.coeffs(), Eigen::Vector4d(0, -1, 0, 0));  // x y z w
  EXPECT_FALSE(t[0].user_force.has_value());
}

TEST(Trajectory, WithoutAQuaternionTheToolIsUpright) {
  const Trajectory t = read("t,x,y,z\n0,1,2,3\n");
  EXPECT_EQ(t[0].pose.orientation.coeffs(), Eigen::Quaterniond::Identity().coeffs());
}

TEST(Trajectory, TakesColumnsInAnyOrderAndIgnoresOthers) {
  const Trajectory t = read("qz,note,z,y,x,t,qw,qx,qy\n1,99,3,2,1,-7,0,0,0\n\r\n1,99,3,2,1,-6,0,0,0\r\n");
  ASSERT_EQ(t.size(), 2U);
  EXPECT_EQ(t[0].t, -7.0);
  EXPECT_EQ(t[0].pose.position, Eigen::Vector3d(1, 2, 3));
  EXPECT_EQ(t[0].pose.orientation.z(), 1.0);
}

TEST(Trajectory, IgnoresWhatARecordingHasBesides) {
  const Trajectory t =
      read("# [made]\nt,x,y,z,state,fault\n0,1,2,3,active,none\n1,1,2,3,falling,over-speed\n");
  ASSERT_EQ(t.size(), 2U);
  EXPECT_EQ(t[1].t, 1.0);
}

TEST(Trajectory, IsTheSameToTheBitHoweverOftenItIsWritten) {
  const auto unit = [](const std::string& csv) {
    std::string out = "t,x,y,z,qw,qx,qy,qz\n";
    const TemporaryFile file(csv, "path.csv");
    for (const TimedPose& p : read_trajectory(file.path())) {
      const Eigen::Quaterniond& q = p.pose.orientation;
      append_csv_row(out, std::array{p.t, 0.0, 0.0, 0.0, q.w(), q.x(), q.y(), q.z()});
    }
    return out;
  };
  std::string rounded = "t,x,y,z,qw,qx,qy,qz\n";
  for (int k = 1; k < 200; ++k) {
    const Eigen::Quaterniond q = Eigen::Quaterniond(1.0, 0.02 * k, -0.007 * k, 0.01).normalized();
    append_csv_row(rounded, std::array{1.0 * k, 0.0, 0.0, 0.0, 1.001 * q.w(), 1.001 * q.x(), 1.001 * q.y(),
                                       1.001 * q.z()});
  }
  const std::string once = unit(rounded);
  EXPECT_EQ(unit(once), once);
}

TEST(Trajectory, ReadsTheUserForce) {
  const Trajectory t = read("t,x,y,z,ufx,ufy,ufz\n0,0,0,0,1,-2,0.5\n");
  ASSERT_TRUE(t[0].user_force.has_value());
  EXPECT_EQ(*t[0].user_force, Eigen::Vector3d(1, -2, 0.5));
}

TEST(Trajectory, NormalisesQuaternionsThatAreRounded) {
  const Trajectory t = read("t,x,y,z,qw,qx,qy,qz\n0,0,0,0,0.7071,0.7071,0,0\n");
  EXPECT_NEAR(t[0].pose.orientation.norm(), 1.0, 1e-15);
  EXPECT_DOUBLE_EQ(t[0].pose.orientation.w(), std::sqrt(0.5));
}

TEST(Trajectory, RefusesWhatIsNoOrientation) {
  for (const char* q : {"0,0,0,0", "0.5,0,0,0", "1,1,0,0", "1e300,0,0,0", "1e-300,0,0,0"}) {
    EXPECT_THAT(refusal("t,x,y,z,qw,qx,qy,qz\n0,0,0,0,1,0,0,0\n1,0,0,0," + std::string(q) + "\n"),
                HasSubstr("quaternion"));
  }
}

TEST(Trajectory, RefusesTimeThatDoesNotIncrease) {
  for (const char* times : {"0\n0\n", "1\n0.5\n", "-1\n-2\n"}) {
    std::string text = "t,x,y,z\n";
    for (const char* c = times; *c != '\0'; ++c)
      text += *c == '\n' ? std::string(",0,0,0\n") : std::string(1, *c);
    EXPECT_THAT(refusal(text), HasSubstr("order of time"));
  }
}

TEST(Trajectory, RefusesMissingColumns) {
  for (const char* header : {"t,x,y", "x,y,z", "time,x,y,z", "T,X,Y,Z"}) {
    std::string row;
    for (const char* c = header; *c != '\0'; ++c) row += *c == ',' ? ",1" : "";
    EXPECT_THAT(refusal(std::string(header) + "\n1" + row + "\n"), ContainsRegex("column.* missing"));
  }
  EXPECT_THAT(refusal("t,x,y,z,qw,qx,qy\n0,0,0,0,1,0,0\n"), HasSubstr("'qz'"));
  EXPECT_THAT(refusal("t,x,y,z,ufx,ufy\n0,0,0,0,1,0\n"), HasSubstr("'ufz'"));
}

TEST(Trajectory, RefusesNumbersThatAreNone) {
  for (const char* bad : {"nan", "inf", "-inf", "1e999", "", "one", "0x1", "1;2", "1 2", "1.0.0"}) {
    EXPECT_THAT(refusal("t,x,y,z\n0,0," + std::string(bad) + ",0\n"), HasSubstr("line 2"));
  }
}

TEST(Trajectory, RefusesRowsOfTheWrongLengthAndNoRows) {
  EXPECT_THAT(refusal("t,x,y,z\n0,0,0\n"), HasSubstr("line 2"));
  EXPECT_THAT(refusal("t,x,y,z\n0,0,0,0\n\n1,0,0,0,0\n"), HasSubstr("line 4"));
  EXPECT_THAT(refusal("t,x,y,z\n"), HasSubstr("no poses"));
  EXPECT_THAT(refusal(""), HasSubstr("empty"));
  EXPECT_THAT(refusal("t,x,x,z\n0,0,0,0\n"), HasSubstr("'x'"));
  EXPECT_THAT(refusal("t,x,,z\n0,0,0,0\n"), HasSubstr("column 3"));
}

TEST(Trajectory, WritesWhatItReadsBackExactly) {
  std::mt19937 random(3);
  std::normal_distribution<double> normal;
  Trajectory written;
  for (int k = 0; k < 200; ++k) {
    TimedPose p;
    p.t = k / 3.0;
    p.pose.position = {normal(random), 1e-17 * normal(random), 1e11 * normal(random)};
    p.pose.orientation =
        Eigen::Quaterniond{normal(random), normal(random), normal(random), normal(random)}.normalized();
    written.push_back(p);
  }
  const TemporaryFile file("old", "path.csv");
  write_trajectory(written, file.path(), "[made]\nversion = \"1, 2\"\n");
  EXPECT_EQ(CsvReader(file.path()).header().comment, "[made]\nversion = \"1, 2\"\n");
  const Trajectory read = read_trajectory(file.path());
  ASSERT_EQ(read.size(), written.size());
  for (std::size_t i = 0; i < read.size(); ++i) {
    ASSERT_EQ(read[i].t, written[i].t);
    ASSERT_EQ(read[i].pose.position, written[i].pose.position);
    ASSERT_LT((read[i].pose.orientation.coeffs() - written[i].pose.orientation.coeffs()).norm(), 1e-15);
  }
}

TEST(PoseAt, IsBetweenPosesAndStaysAtTheEnds) {
  using Eigen::Vector3d;
  Trajectory path(3);
  path[0].t = 5.0;
  path[1].t = 6.0;
  path[1].pose = {{0.1, 0, 0}, Eigen::Quaterniond(Eigen::AngleAxisd(1.0, Vector3d::UnitZ()))};
  path[2].t = 8.0;
  path[2].pose = {{0.1, 0.2, 0}, path[1].pose.orientation};
  EXPECT_EQ(pose_at(path, 0.0).position, Vector3d(0, 0, 0));
  EXPECT_TRUE(pose_at(path, 5.25).position.isApprox(Vector3d(0.025, 0, 0)));
  EXPECT_NEAR(Eigen::AngleAxisd(pose_at(path, 5.25).orientation).angle(), 0.25, 1e-12);
  EXPECT_TRUE(pose_at(path, 7.0).position.isApprox(Vector3d(0.1, 0.1, 0)));
  EXPECT_EQ(pose_at(path, 9.0).position, Vector3d(0.1, 0.2, 0));
}

}  // namespace
}  // namespace palpate::test
