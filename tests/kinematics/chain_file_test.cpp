// Chains from files, good and bad.
#include <palpate/kinematics/chain_file.h>

#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <palpate/base/error.h>
#include <palpate/kinematics/chain_kinematics.h>
#include <support/temporary_file.h>

namespace palpate {
namespace {

using testing::HasSubstr;

std::string replaced(std::string text, const std::string& what, const std::string& by) {
  const std::size_t at = text.find(what);
  EXPECT_NE(at, std::string::npos) << what;
  return text.replace(at, what.size(), by);
}

std::string repeated(std::string_view text, int times) {
  std::string all;
  for (int k = 0; k < times; ++k) all += text;
  return all;
}

constexpr const char* kUrdf = R"(<?xml version="1.0"?>
<robot name="two">
  <link name="base"/>
  <link name="plate"><inertial><mass value="9"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <link name="slide"><inertial><origin xyz="0 0 0.1"/><mass value="2"/><inertia ixx="0.1" iyy="0.1" izz="0.1" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <link name="arm"><inertial><mass value="1"/><inertia ixx="0.01" iyy="0.01" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <link name="weight"><inertial><mass value="3"/><inertia ixx="0" iyy="0" izz="0" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <joint name="foot" type="fixed"><parent link="base"/><child link="plate"/><origin xyz="0 0 1"/></joint>
  <joint name="rail" type="prismatic"><parent link="plate"/><child link="slide"/><origin xyz="0.5 0 0"/><axis xyz="2 0 0"/>
    <limit lower="-1" upper="2" velocity="0.5" effort="100"/></joint>
  <joint name="hinge" type="revolute"><parent link="slide"/><child link="arm"/><origin xyz="0 0 0.2" rpy="1.5707963267948966 0 0"/><axis xyz="0 0 1"/>
    <limit lower="-1" upper="1" velocity="2" effort="10"/></joint>
  <joint name="end" type="fixed"><parent link="arm"/><child link="weight"/><origin xyz="0.4 0 0"/></joint>
</robot>)";

TEST(ChainFile, ReadsUrdfAndJoinsWhatIsFixed) {
  const SerialChain chain = parse_chain("two.urdf", kUrdf);
  ASSERT_EQ(chain.size(), 2);
  EXPECT_EQ(chain.joints[0].type, JointType::kPrismatic);
  EXPECT_TRUE(chain.joints[0].origin.position.isApprox(Eigen::Vector3d(0.5, 0, 1)));
  EXPECT_EQ(chain.joints[0].axis, Eigen::Vector3d::UnitX());
  EXPECT_EQ(chain.joints[0].limits.acceleration, 0.5 / kUrdfRampTime);
  EXPECT_EQ(chain.joints[0].rest, 0.5);
  // 1 kg at the hinge and 3 kg 0.4 m away, together: 4 kg at 0.3 m, with m1 m2 / (m1 + m2) r^2 = 0.12 kg m^2
  // across.
  const LinkInertia& arm = chain.joints[1].link;
  EXPECT_DOUBLE_EQ(arm.mass, 4.0);
  EXPECT_TRUE(arm.center.isApprox(Eigen::Vector3d(0.3, 0, 0)));
  EXPECT_TRUE(arm.inertia.isApprox(Eigen::Vector3d(0.01, 0.13, 0.13).asDiagonal().toDenseMatrix(), 1e-12))
      << arm.inertia;
  ChainKinematics at(chain);
  JointVector q(2);
  q << 1.0, 0.5;
  at.set(q);
  // About y of the base, turned the other way: the hinge's z is -y there.
  EXPECT_TRUE(at.tip().position.isApprox(
      Eigen::Vector3d(1.5 + 0.4 * std::cos(0.5), 0, 1.2 + 0.4 * std::sin(0.5)), 1e-12))
      << at.tip().position.transpose();
}

TEST(ChainFile, CommentsInUrdfDoNotNest) {
  const std::string comment = "<!--" + repeated("<a>", 1000) + "-->";
  EXPECT_EQ(parse_chain("two.urdf", replaced(kUrdf, "</robot>", comment + "</robot>")).size(), 2);
}

TEST(ChainFile, TomlAndFileOnDiskAreTheSame) {
  const test::TemporaryFile file{std::string(giant_chain_text())};
  const SerialChain chain = read_chain(file.path()), built_in = giant_chain();
  ASSERT_EQ(chain.size(), 8);
  ChainKinematics a(chain), b(built_in);
  EXPECT_EQ(difference(a.tip(), b.tip()).norm(), 0.0);
  EXPECT_EQ(chain.joints[1].limits.upper, 2.75);
  EXPECT_TRUE(chain.tip.position.isApprox(Eigen::Vector3d(0, 0, -0.15)));
}

struct Bad {
  const char* what;
  std::string text;
  std::vector<std::string> says;
};

std::vector<Bad> bad_chains() {
  const std::string toml(giant_chain_text()), urdf(kUrdf);
  const std::string joint = "\n[[joint]]\nname = \"more\"\ntype = \"fixed\"\n";
  return {
      {"loop", toml + joint + "parent = \"handle\"\nchild = \"column\"\n", {"'column'", "'more'", "loop"}},
      {"no root", toml + joint + "parent = \"handle\"\nchild = \"room\"\n", {"loop"}},
      {"branch",
       toml + "\n[[link]]\nname = \"other\"\n" + joint + "parent = \"forearm\"\nchild = \"other\"\n",
       {"'forearm'", "'more'", "branches"}},
      {"two roots",
       toml + "\n[[link]]\nname = \"other\"\n" + joint + "parent = \"other\"\nchild = \"column\"\n",
       {"'column'"}},
      {"missing link",
       replaced(toml, "child = \"column\"", "child = \"colum\""),
       {"'y'", "'colum'", "does not exist"}},
      {"missing tip", replaced(toml, "tip = \"handle\"", "tip = \"hand\""), {"the tip", "'hand'"}},
      {"link twice", toml + "\n[[link]]\nname = \"room\"\n", {"two links are named 'room'"}},
      {"joint twice", replaced(toml, "name = \"elbow\"", "name = \"yaw\""), {"'yaw'", "two"}},
      {"negative mass", replaced(toml, "mass = 60.0", "mass = -60.0"), {"'x'", "mass", "-60"}},
      {"negative inertia",
       replaced(toml, "[3.0, 3.0, 0.5", "[3.0, -3.0, 0.5"),
       {"'y'", "inertia", "negative"}},
      {"inertia of no body", replaced(toml, "[3.0, 3.0, 0.5", "[9.0, 3.0, 0.5"), {"'y'", "inertia"}},
      {"limits crossed", replaced(toml, "lower = -2.35", "lower = 2.36"), {"'x'", "2.36", "below"}},
      {"negative velocity", replaced(toml, "velocity = 4.0", "velocity = -4.0"), {"'yaw'", "velocity", "-4"}},
      {"no acceleration",
       replaced(toml, "acceleration = 80.0", "acceleration = 0.0"),
       {"'wrist_yaw'", "acceleration"}},
      {"negative effort", replaced(toml, "effort = 1080.0", "effort = -1.0"), {"'yaw'", "effort", "-1"}},
      {"rest outside", replaced(toml, "rest = 0.8", "rest = 8.0"), {"'shoulder_pitch'", "rest", "8"}},
      {"no axis", replaced(toml, "axis = [1.0, 0.0, 0.0]", "axis = [0.0, 0.0, 0.0]"), {"axis", "line"}},
      {"not a number", replaced(toml, "upper = 2.35", "upper = nan"), {"upper", "line"}},
      {"unknown type",
       replaced(toml, "type = \"revolute\"", "type = \"ball\""),
       {"type", "revolute", "line"}},
      {"unknown key", replaced(toml, "effort = 1800.0", "efort = 1800.0"), {"efort", "line"}},
      {"no toml", "joints: 3", {"line 1"}},
      {"nothing", "", {"name"}},
      {"urdf cut off", urdf.substr(0, urdf.size() / 2), {"URDF"}},
      {"urdf that is not", "<html></html>", {"URDF"}},
      {"urdf missing link", replaced(urdf, "<child link=\"arm\"/>", "<child link=\"leg\"/>"), {"leg"}},
      {"urdf loop", replaced(urdf, "<parent link=\"base\"/>", "<parent link=\"weight\"/>"), {"loop"}},
      {"urdf negative mass",
       replaced(urdf, "<mass value=\"2\"/>", "<mass value=\"-2\"/>"),
       {"'rail'", "mass", "-2"}},
      {"urdf negative velocity",
       replaced(urdf, "velocity=\"0.5\"", "velocity=\"-0.5\""),
       {"'rail'", "velocity"}},
      {"urdf no limit",
       replaced(urdf, "<limit lower=\"-1\" upper=\"1\" velocity=\"2\" effort=\"10\"/>", ""),
       {"hinge", "limit"}},
      {"urdf floating", replaced(urdf, "type=\"revolute\"", "type=\"floating\""), {"'hinge'"}},
      {"urdf garbage", std::string(100, '<') + "a>", {"URDF"}},
      {"urdf nested", repeated("<a>", 1000), {"deep"}},
      {"urdf nested, ends in comments", repeated("<a><!--</a>-->", 1000), {"deep"}},
      {"urdf nested, ends in data", repeated("<a><![CDATA[</a>]]>", 1000), {"deep"}},
      {"urdf nested, ends in quotes", repeated("<a b='></a>'>", 1000), {"deep"}},
      {"urdf nested, after a quote in what is no tag", "<!x \">" + repeated("<a>", 1000) + "\">", {"deep"}},
      {"urdf without an end of any tag", repeated("<a ", 1 << 20), {"URDF"}},
  };
}

TEST(ChainFile, SaysInOneLineWhatIsWrong) {
  for (const Bad& bad : bad_chains()) {
    try {
      parse_chain("bad.chain", bad.text);
      ADD_FAILURE() << bad.what;
    } catch (const Error& error) {
      const std::string said = error.what();
      EXPECT_EQ(said.find('\n'), std::string::npos) << bad.what;
      EXPECT_EQ(said.rfind("bad.chain: ", 0), 0U) << bad.what << ": " << said;
      for (const std::string& part : bad.says) EXPECT_THAT(said, HasSubstr(part)) << bad.what;
    }
  }
}

TEST(ChainFile, ThatIsNotThere) { EXPECT_THROW(read_chain("/no/such.urdf"), Error); }

}  // namespace
}  // namespace palpate
