// Configurations as TOML files, there and back.
#include <palpate/live/config_toml.h>

#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <palpate/base/error.h>

#include <support/temporary_file.h>

namespace palpate::test {
namespace {

using testing::HasSubstr;

/// Another value than the default in every field.
LiveConfig other_config() {
  LiveConfig c;
  c.scene.path = "a \"quoted\" \\ name.ply";
  c.scene.filter = {0.25,
                    2.0,
                    1.0 / 3.0,
                    0.5,
                    Eigen::AlignedBox3d(Eigen::Vector3d(-1, -2, -3), Eigen::Vector3d(1, 2, 3)),
                    SceneFilter::Sphere{{0.1, 0.2, 0.3}, 4.0}};
  c.scene.frame = UpAxis::kYDown;
  c.scene.registration = {2.5, Eigen::Quaterniond(0.6, 0, 0.8, 0), {1, 2, 3}, true};
  c.scene.no_index_file = true;
  c.tool = Tool(std::vector<ToolPart>{{"tip", {0.01, 0.02, 0.03}, {}},
                                      {"rod", {0.005, 0.005, 0.1}, {{0, 0, 0.1}, {1, 0, 0, 0}}}});
  c.force.model = ForceModelKind::kField;
  c.force.proxy.stiffness = 0.1 + 0.2;
  c.force.proxy.friction = 0.4;
  c.force.proxy.detail = 0.003;
  c.force.density = {0.2, 6.0, 11.0, 0.02, 0.03, 0.04};
  c.force.materials = "wood.toml";
  c.device = {DeviceKind::kPlayback, "", "falcon", "path.csv", 120.0, {0.2, 4.0, 500.0}, {}};
  c.device.map.scale = 3.0;
  c.device.map.rotation = Eigen::Quaterniond(0.8, 0.6, 0, 0);
  c.device.map.offset = {4, 5, 6};
  c.loop = {2000.0, ContactSearch::kWorker, 0.01, 1};
  c.gateway = {true, 0, "0.0.0.0", "0123456789abcdef"};
  return c;
}

LiveConfig read(const std::string& text) {
  return read_live_config(TemporaryFile(text, "config.toml").path());
}

std::string refusal(const std::string& text) {
  return message_of<Error>([&] { read(text); });
}

TEST(ConfigToml, ADriverTakesThePlaceOfAKindOfDevice) {
  const LiveConfig config = read("device = \"plugin:./arm.so:0.1\"\n");
  EXPECT_EQ(config.device.driver, "plugin:./arm.so:0.1");
  EXPECT_EQ(read(to_toml(config, TomlFields::kAll)), config);
  EXPECT_THAT(refusal("device = \"arm.so\"\n"), ::testing::HasSubstr("'arm.so' is not one of"));
}

TEST(ConfigToml, ReadsBackWhatItWrites) {
  EXPECT_EQ(read(to_toml({}, TomlFields::kAll)), LiveConfig());
  LiveConfig config = other_config();
  config.scene.filter.sigma = SceneFilter().sigma;  // which iso replaces
  EXPECT_EQ(read(to_toml(config, TomlFields::kAll)), config);
}

TEST(ConfigToml, AGroupIsWrittenAsTheWholeIs) {
  const LiveConfig config = other_config();
  std::string text;
  for (const SettingText& setting : settings_text(config, ConfigGroup::kScene)) {
    EXPECT_THAT(to_toml(config, TomlFields::kAll),
                HasSubstr("\n" + setting.name + " = " + setting.value + "\n"));
    text += setting.name + " = " + setting.value + "\n";
  }
  EXPECT_EQ(read(text).scene.path, config.scene.path);
  EXPECT_THAT(text, testing::Not(HasSubstr("token")));
}

TEST(ConfigToml, QuotesWhateverANameIs) {
  for (const std::string name : {"plain.ply", "a \"b\" \\c", "two\nlines\t", "\x7f\x01", "\xc3\xbc"})
    EXPECT_EQ(read("scene = " + toml_quoted(name)).scene.path, name);
  EXPECT_EQ(read("scene = " + toml_quoted("bad\xff.ply")).scene.path, "bad?.ply");
}

TEST(ConfigToml, SavesTheSettingsThatAPersonWorksOut) {
  EXPECT_EQ(
      to_toml({}, TomlFields::kSaved),
      "# For palpate --config.\n"
      "# Left out: the scene's file, --no-index-file, the options of the gateway, --hands, --hands-touch,\n"
      "# --record, --scenes and --seconds, and the place of a headset's room.\n"
      "opacity-min = 0.1\nsigma = 1\nframe = \"as-is\"\nscale = 1\nrotate = [1, 0, 0, 0]\n"
      "translate = [0, 0, 0]\nmodel = \"proxy\"\nstiffness = 500\nfriction = 0\ntool = [0.02, 0.02, 0.04]\n");
  const std::string text = to_toml(other_config(), TomlFields::kSaved);
  EXPECT_THAT(text, HasSubstr("\niso = 0.3333333333333333\n"));
  EXPECT_THAT(text, HasSubstr("\nmirror = true\n"));
  EXPECT_THAT(text, HasSubstr("\ntool = '''\n[[ellipsoid]]\n"));
  EXPECT_THAT(text, testing::Not(HasSubstr("sigma")));
  EXPECT_THAT(text, testing::Not(HasSubstr("token")));
}

TEST(ConfigToml, SavesAllThatTheNextRunNeedsToBeTheSame) {
  LiveConfig config = other_config();
  config.scene.filter.sigma = SceneFilter().sigma;  // which iso replaces
  config.device.virtual_damping = 20.0;
  LiveConfig expected = config;
  expected.scene.path.clear();
  expected.scene.no_index_file = false;
  expected.gateway = {};
  EXPECT_EQ(read(to_toml(config, TomlFields::kSaved)), expected);
  expected.scene = {};
  EXPECT_EQ(read(to_toml(config, TomlFields::kSavedOfHand)), expected);
}

TEST(ConfigToml, KeepsWhatAFileDoesNotSay) {
  const TemporaryFile file("stiffness = 900\n", "config.toml");
  LiveConfig expected = other_config();
  expected.force.proxy.stiffness = 900.0;
  EXPECT_EQ(read_live_config(file.path(), other_config()), expected);
}

TEST(ConfigToml, RefusesWhatIsNoConfiguration) {
  EXPECT_THAT(refusal("stifness = 1\n"), HasSubstr("stifness"));
  EXPECT_THAT(refusal("\nstiffness = -1\n"), HasSubstr("line 2: 'stiffness': -1 is not in 0 to"));
  EXPECT_THAT(refusal("stiffness = \"much\"\n"), HasSubstr("is not a finite number"));
  EXPECT_THAT(refusal("iso = 0.5\nsigma = 2\n"), HasSubstr("'iso' cannot go with 'sigma'"));
  EXPECT_THAT(refusal("tool = {}\n"), HasSubstr("must be a number, text"));
}

}  // namespace
}  // namespace palpate::test
