#include <algorithm>
#include <set>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <palpate/base/error.h>
#include <palpate/collision/k_function.h>
#include <palpate/haptics/tool_file.h>
#include <support/example_tools.h>
#include <support/file_mistake.h>
#include <support/temporary_file.h>

namespace palpate {
namespace {

using Eigen::Vector3d;
using test::FileMistake;
using test::message_of;
using test::TemporaryFile;
using testing::AllOf;
using testing::HasSubstr;

Tool tool_of(const std::string& text) { return read_tool(TemporaryFile(text, "t.toml").path()); }

TEST(ToolFile, ReadsEveryKey) {
  const Tool tool = tool_of(
      "[[ellipsoid]]\nname = 'tip'\nsemi_axes = [0.01, 0.02, 3e-3]\n"
      "position = [0.1, -0.2, 0]\norientation = [0, 3, 0, 4]\n"
      "[[ellipsoid]]\nsemi_axes = [1, 1, 1]\nname = 'ball'\n");
  ASSERT_EQ(tool.parts().size(), 2U);
  const ToolPart &tip = tool.parts()[0], &ball = tool.parts()[1];
  EXPECT_EQ(tip.name, "tip");
  EXPECT_EQ(tip.semi_axes, Vector3d(0.01, 0.02, 0.003));
  EXPECT_EQ(tip.pose.position, Vector3d(0.1, -0.2, 0));
  EXPECT_LE((tip.pose.orientation.coeffs() - Eigen::Vector4d(0.6, 0, 0.8, 0)).norm(), 1e-15);  // x, y, z, w
  EXPECT_EQ(ball.name, "ball");
  EXPECT_EQ(ball.pose.position, Vector3d(0, 0, 0));
  EXPECT_TRUE(ball.pose.orientation.isApprox(Eigen::Quaterniond::Identity(), 0.0));
}

TEST(ToolFile, IsReadAsTheToolItWasWrittenFrom) {
  ToolPart tip, ball;
  tip.name = "it's \"odd\" \\ '''\n\t\x7f \xc3\xbc";
  tip.semi_axes = {0.1, 1.0 / 3.0, 2e-6};
  tip.pose = {{-0.1, 1e-17, 1.0 / 7.0}, Eigen::Quaterniond(1, 2, 3, 4).normalized()};
  ball.semi_axes = {1, 1, 1};
  const Tool tool(std::vector<ToolPart>{tip, ball});
  const std::string text = tool_text(tool);
  EXPECT_EQ(text.find('\''), std::string::npos);
  EXPECT_THAT(tool_text(Tool({{"little finger", {1, 1, 1}}})), HasSubstr("\"little finger\""))
      << "as people read it";
  const Tool read = tool_of(text);
  ASSERT_EQ(read.parts().size(), 2U);
  for (std::size_t k = 0; k < 2; ++k) {
    const ToolPart &a = tool.parts()[k], &b = read.parts()[k];
    EXPECT_EQ(a.name, b.name);
    EXPECT_EQ(a.semi_axes, b.semi_axes);
    EXPECT_EQ(a.pose.position, b.pose.position);
    EXPECT_EQ(a.pose.orientation.coeffs(), b.pose.orientation.coeffs());
  }
}

TEST(ToolFile, NamesEveryMistake) {
  const std::string named = "[[ellipsoid]]\nname = 'a'\n", sound = named + "semi_axes = [1, 1, 1]\n";
  for (const auto& [text, line, words] : std::vector<FileMistake>{
           {"# nothing\n", 1, "'ellipsoid' is missing"},
           {"ellipsoid = 3", 1, "[[ellipsoid]]"},
           {"ellipsoid = [1, 2]", 1, "'ellipsoid' must be a table, not 1"},
           {"[ellipsoid]\nname = 'a'\nsemi_axes = [1, 1, 1]", 1, "[[ellipsoid]]"},
           {sound + "[tool]\n", 4, "unknown key 'tool'; the known keys are ellipsoid"},
           {"\n[[ellipsoid]]\nsemi_axes = [1, 1, 1]", 2, "'name' is missing"},
           {"[[ellipsoid]]\nname = 7\nsemi_axes = [1, 1, 1]", 2, "'name' must be text"},
           {named, 1, "'semi_axes' is missing"},
           {named + "semi_axes = [0.01, 0, 0.01]", 3, "'semi_axes' must be a number from 1e-06 to 1000000"},
           {named + "semi_axes = [0.01, -0.01, 0.01]", 3, "not -0.01"},
           {named + "semi_axes = [nan, 1, 1]", 3, "'semi_axes'"},
           {named + "semi_axes = [inf, 1, 1]", 3, "'semi_axes'"},
           {named + "semi_axes = [1e7, 1, 1]", 3, "'semi_axes'"},
           {named + "semi_axes = [1, 1]", 3, "'semi_axes' must be an array of 3 numbers"},
           {named + "semi_axes = [1, 1, 1, 1]", 3, "'semi_axes' must be an array of 3 numbers"},
           {named + "semi_axes = ['1', '1', '1']", 3, "'semi_axes' must be a number"},
           {named + "semi_axes = 'small'", 3, "'semi_axes' must be an array of 3 numbers"},
           {sound + "position = [0, 0]", 4, "'position' must be an array of 3 numbers"},
           {sound + "position = [0, 0, 1e7]", 4, "'position' must be a number from -1000000 to 1000000"},
           {sound + "orientation = [1, 0, 0]", 4, "'orientation' must be an array of 4 numbers"},
           {sound + "orientation = [0, 0, 0, 0.0]", 4,
            "a quaternion qw, qx, qy, qz with a norm between 1e-6 and 1e6"},
           {sound + "orientation = [1e200, 0, 0, 0]", 4, "'orientation'"},
           {sound + "semi_axis = [1, 1, 1]", 4,
            "unknown key 'semi_axis'; the known keys are name, semi_axes, position, orientation"},
           {sound + "[[ellipsoid]\n", 4, ""},
       }) {
    EXPECT_THAT(message_of<Error>([&text = text] { tool_of(text); }),
                AllOf(HasSubstr("t.toml: line " + std::to_string(line) + ": "), HasSubstr(words),
                      testing::Not(HasSubstr("\n"))))
        << text;
  }
}

TEST(ToolFile, RefusesTooFewAndTooManyEllipsoids) {
  EXPECT_THAT(message_of<Error>([] { tool_of("ellipsoid = []\n"); }),
              AllOf(HasSubstr("t.toml: "), HasSubstr("0 ellipsoids; a tool has 1 to 256")));
  std::string text;
  for (std::size_t k = 0; k < kMaxToolParts; ++k)
    text += "[[ellipsoid]]\nname = 'a'\nsemi_axes = [1, 1, 1]\n";
  EXPECT_EQ(tool_of(text).parts().size(), kMaxToolParts);
  EXPECT_THAT(
      message_of<Error>([&] { tool_of(text + "[[ellipsoid]]\nname = 'a'\nsemi_axes = [1, 1, 1]\n"); }),
      HasSubstr("257 ellipsoids; a tool has 1 to 256"));
}

TEST(ToolFile, RefusesWhatIsNoFileAndWhatIsHuge) {
  EXPECT_THAT(message_of<Error>([] { read_tool("/nowhere/t.toml"); }), HasSubstr("/nowhere/t.toml"));
  EXPECT_THAT(message_of<Error>([] { tool_of(std::string(1 << 20, '#')); }), HasSubstr("bytes"));
}

bool overlap(const ToolPart& a, const ToolPart& b) {
  return minimize(KFunction(WhitenedTool(a.at({})), b.at({}))).k_min > 0.0;
}

/// How many parts hang together with the first, by parts that overlap.
std::size_t parts_in_one_piece(const Tool& tool) {
  const auto parts = tool.parts();
  std::vector<std::size_t> reached{0}, rest;
  for (std::size_t k = 1; k < parts.size(); ++k) rest.push_back(k);
  for (std::size_t i = 0; i < reached.size(); ++i) {
    const auto hangs = [&](std::size_t k) { return overlap(parts[reached[i]], parts[k]); };
    std::copy_if(rest.begin(), rest.end(), std::back_inserter(reached), hangs);
    std::erase_if(rest, hangs);
  }
  return reached.size();
}

struct Example {
  const char* name;
  std::size_t parts;
  double length;  ///< the longest that such a thing is. Unit: [m].
};

TEST(ExampleTools, AreInOnePieceAndOfTheirSize) {
  for (const Example& example :
       {Example{"sphere-tip", 1, 0.01}, Example{"stylus", 4, 0.18}, Example{"fingertip", 3, 0.06},
        Example{"gripper", 6, 0.25}, Example{"open-hand", 21, 0.26}}) {
    SCOPED_TRACE(example.name);
    const Tool tool = read_tool(test::example_tool(example.name));
    EXPECT_EQ(tool.parts().size(), example.parts);
    EXPECT_EQ(parts_in_one_piece(tool), tool.parts().size());
    std::set<std::string> names;
    for (const ToolPart& part : tool.parts()) names.insert(part.name);
    EXPECT_EQ(names.size(), tool.parts().size()) << "a name is there twice";
    double longest = 0.0;
    for (int k = 0; k < 3; ++k)
      longest = std::max(longest, tool.support(Vector3d::Unit(k)) + tool.support(-Vector3d::Unit(k)));
    EXPECT_LE(longest, example.length * (1.0 + 1e-12));
    EXPECT_GE(longest, 0.8 * example.length);
  }
}

TEST(ExampleTools, TheHandHasFiveFingersThatTouchInTheOrderOfTheirJoints) {
  const Tool tool = read_tool(test::example_tool("open-hand"));
  const auto part = [&](const std::string& name) {
    const auto parts = tool.parts();
    const auto found =
        std::find_if(parts.begin(), parts.end(), [&](const ToolPart& p) { return p.name == name; });
    if (found == parts.end()) throw Error("no {}", name);
    return *found;
  };
  std::vector<ToolPart> tips{part("thumb, distal phalanx")};
  EXPECT_TRUE(overlap(part("thumb, metacarpal"), part("thumb, proximal phalanx")));
  EXPECT_TRUE(overlap(part("thumb, proximal phalanx"), tips[0]));
  for (const std::string finger : {"index finger", "middle finger", "ring finger", "little finger"}) {
    tips.push_back(part(finger + ", distal phalanx"));
    EXPECT_TRUE(overlap(part(finger + ", proximal phalanx"), part(finger + ", middle phalanx")));
    EXPECT_TRUE(overlap(part(finger + ", middle phalanx"), tips.back()));
  }
  // Of a right hand that points along x, palm down: from the thumb on, each finger is further to -y.
  for (std::size_t k = 1; k < tips.size(); ++k) {
    EXPECT_LT(tips[k].pose.position.y(), tips[k - 1].pose.position.y());
    EXPECT_FALSE(overlap(tips[k], tips[k - 1])) << "an open hand";
  }
  const auto x = [&](std::size_t k) { return tips[k].pose.position.x(); };
  EXPECT_GT(x(2), std::max({x(0), x(1), x(3), x(4)})) << "the middle finger is the longest";
}

}  // namespace
}  // namespace palpate
