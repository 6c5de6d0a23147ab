#include <palpate/live/provenance.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <palpate/base/error.h>
#include <palpate/base/toml_file.h>
#include <palpate/base/version.h>
#include <palpate/haptics/tool_file.h>
#include <support/temporary_file.h>

namespace palpate {
namespace {

using test::TemporaryFile;
using testing::StartsWith;
using enum ConfigGroup;

std::string value_of(const std::vector<SettingText>& all, std::string_view name) {
  for (const SettingText& item : all)
    if (item.name == name) return item.value;
  return "";
}

TEST(Provenance, SaysVersionCommandSceneAndMachine) {
  LiveConfig config;
  const Provenance known =
      provenance("replay", {"garden.ply", "xxh3-16MiB:0123456789abcdef"}, config, {kScene});
  EXPECT_EQ(value_of(known.made, "version"), toml_quoted(version()));
  EXPECT_EQ(value_of(known.made, "command"), "\"replay\"");
  EXPECT_EQ(value_of(known.made, "scene"), "\"garden.ply\"");
  EXPECT_EQ(value_of(known.made, "scene-checksum"), "\"xxh3-16MiB:0123456789abcdef\"");
  EXPECT_EQ(value_of(known.made, "materials-checksum"), "");
  EXPECT_NE(value_of(known.made, "machine"), "");
  EXPECT_EQ(value_of(known.settings, "opacity-min"), "0.1");
}

TEST(Provenance, IsTomlThatIsReadAsTheSameSettings) {
  LiveConfig config;
  config.force.proxy.stiffness = 0.1 + 0.2;
  config.tool =
      Tool(std::vector<ToolPart>{{"tip", {0.01, 0.02, 0.03}, {}}, {"rod", {0.005, 0.005, 0.1}, {}}});
  const std::string text = to_toml(provenance("run", {}, config, {kTool, kForce, kDevice}));
  const TomlFile file("head", text);
  TomlTable root = file.root();
  root.at("made");
  TomlTable settings = root.at("settings").table();
  EXPECT_EQ(settings.at("stiffness").number(), 0.1 + 0.2);
  EXPECT_EQ(parse_tool("tool", settings.at("tool").text()), config.tool);
  EXPECT_EQ(settings.at("profile").text(), config.device.profile);
  root.refuse_others();
}

TEST(Provenance, NeverTellsATokenOrAKey) {
  LiveConfig config;
  config.gateway.token = "0123456789abcdef";
  const std::string text = to_toml(provenance("run", {}, config, {kScene, kTool, kForce, kDevice, kLoop}));
  EXPECT_THAT(text, testing::Not(testing::HasSubstr(config.gateway.token)));
}

TEST(Provenance, AChecksumIsOfWhatIsInAFile) {
  const TemporaryFile a("same"), b("same"), c("other");
  EXPECT_THAT(file_checksum(a.path()), StartsWith("xxh3-16MiB:"));
  EXPECT_EQ(file_checksum(a.path()), file_checksum(b.path()));
  EXPECT_NE(file_checksum(a.path()), file_checksum(c.path()));
  EXPECT_THROW(file_checksum(a.path() + ".no"), Error);
}

}  // namespace
}  // namespace palpate
