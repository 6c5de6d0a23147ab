// The table of fields: what it says agrees with the defaults and with itself.
#include <palpate/live/config_fields.h>

#include <functional>
#include <limits>
#include <set>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <palpate/base/error.h>
#include <palpate/live/value_text.h>

namespace palpate::test {
namespace {

using testing::HasSubstr;

TEST(ConfigFields, HaveNamesOfTheirOwn) {
  std::set<std::string_view> names, parameters;
  for (const ConfigField& field : config_fields()) {
    EXPECT_TRUE(field.name.empty() || names.insert(field.name).second) << field.name;
    EXPECT_TRUE(field.parameter.empty() || parameters.insert(field.parameter).second) << field.parameter;
    EXPECT_FALSE(field.name.empty() && field.parameter.empty());
    EXPECT_FALSE(field.help.empty());
    if (!field.traits.excludes.empty()) {
      EXPECT_NO_THROW(config_field(field.traits.excludes));
    }
  }
  EXPECT_THROW(config_field(""), Error);
}

TEST(ConfigFields, TakeTheirOwnDefaults) {
  const LiveConfig defaults;
  for (const ConfigField& field : config_fields()) {
    if (field.name.empty() || !field.traits.shown_default.empty()) continue;
    const std::string text = default_text(field, defaults);
    if (text.empty()) continue;
    LiveConfig config;
    set_from_text(field, config, text);
    EXPECT_EQ(config, defaults) << field.name << " = " << text;
  }
}

/// Sets one field of a configuration. \returns the refusal, empty if there is none
std::string set(LiveConfig& config, std::string_view name, const std::string& text) {
  try {
    set_from_text(config_field(name), config, text);
    return {};
  } catch (const BadValue& error) {
    return error.what();
  }
}

TEST(ConfigFields, AreSetFromText) {
  LiveConfig config;
  EXPECT_EQ(set(config, "opacity-min", "0.3"), "");
  EXPECT_EQ(config.scene.filter.opacity_min, 0.3);
  EXPECT_EQ(set(config, "frame", "y-down"), "");
  EXPECT_EQ(config.scene.frame, UpAxis::kYDown);
  EXPECT_EQ(set(config, "rotate", "0,0,0,2"), "");
  EXPECT_EQ(config.scene.registration.rotation.z(), 1.0);
  EXPECT_EQ(set(config, "crop-sphere", "1,2,3,4"), "");
  EXPECT_EQ(config.scene.filter.crop_sphere->center, Eigen::Vector3d(1, 2, 3));
  EXPECT_EQ(set(config, "hand", "0.2,4,500"), "");
  EXPECT_EQ(config.device.hand.stiffness, 500.0);
  EXPECT_EQ(set(config, "profile", "falcon"), "");
  EXPECT_EQ(config.device.profile, "falcon");
  EXPECT_EQ(set(config, "contacts", "hold"), "");
  EXPECT_EQ(config.loop.contacts, ContactSearch::kHold);
  EXPECT_EQ(set(config, "cpu", "3"), "");
  EXPECT_EQ(config.loop.cpu, 3);
  EXPECT_EQ(set(config, "tool", "0.01,0.02,0.03"), "");
  EXPECT_EQ(config.tool.parts()[0].semi_axes, Eigen::Vector3d(0.01, 0.02, 0.03));
  EXPECT_EQ(set(config, "no-gateway", "true"), "");
  EXPECT_TRUE(config.gateway.off);
}

TEST(ConfigFields, RefuseWhatTheyCannotTake) {
  LiveConfig config;
  const LiveConfig before = config;
  EXPECT_THAT(set(config, "opacity-min", "1.5"), "1.5 is not in 0 to 1");
  EXPECT_THAT(set(config, "stiffness", "nan"), "'nan' is not a finite number");
  EXPECT_THAT(set(config, "iso", "1"), "1 is not between 0 and 1");
  EXPECT_THAT(set(config, "detail", "0"), "0 is not positive");
  EXPECT_THAT(set(config, "frame", "w-up"), HasSubstr("is not one of as-is, x-down"));
  EXPECT_THAT(set(config, "rotate", "0,0,0,0"), HasSubstr("norm between 1e-6 and 1e6"));
  EXPECT_THAT(set(config, "translate", "1,2"), HasSubstr("3 are needed"));
  EXPECT_THAT(set(config, "crop-box", "0,0,0,-1,1,1"), HasSubstr("below the second"));
  EXPECT_THAT(set(config, "hand", "-1,0,0"), HasSubstr("must not be negative"));
  EXPECT_THAT(set(config, "cpu", "1.5"), HasSubstr("not a whole number"));
  EXPECT_THAT(set(config, "token", "short"), HasSubstr("16"));
  EXPECT_THAT(set(config, "tool", "0,1,1"), HasSubstr("semi-axis 0"));
  EXPECT_THAT(set(config, "mirror", "yes"), "must be true or false");
  EXPECT_EQ(config, before);
}

/// \returns the refusal of a configuration with an edit; empty if there is none
std::string refusal(const std::function<void(LiveConfig&)>& edit) {
  LiveConfig config;
  edit(config);
  try {
    check_config(config);
    return {};
  } catch (const Error& error) {
    return error.what();
  }
}

TEST(ConfigFields, AreCheckedWhereNoTextIs) {
  using C = LiveConfig;
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(refusal([](C&) {}), "");
  EXPECT_EQ(refusal([](C& c) { c.force.proxy.stiffness = -500.0; }),
            "LiveConfig: stiffness: -500 is not in 0 to 1000000; correct it");
  EXPECT_THAT(refusal([](C& c) { c.force.proxy.stiffness = kNan; }), HasSubstr("stiffness: nan is not in"));
  for (const double bad : {0.0, kNan, std::numeric_limits<double>::infinity()}) {
    EXPECT_THAT(refusal([=](C& c) { c.force.proxy.detail = bad; }), HasSubstr("detail: ")) << bad;
    EXPECT_THAT(refusal([=](C& c) { c.loop.rate = bad; }), HasSubstr("rate: ")) << bad;
    EXPECT_THAT(refusal([=](C& c) { c.device.map.scale = bad; }), HasSubstr("workspace-scale: ")) << bad;
    EXPECT_THAT(refusal([=](C& c) { c.scene.registration.scale = bad; }), HasSubstr("LiveConfig: scale: "));
    EXPECT_THAT(refusal([=](C& c) { c.room.scale = bad; }), HasSubstr("room.scale: ")) << bad;
    EXPECT_THAT(refusal([=](C& c) { c.tool = Tool(Eigen::Vector3d(0.01, bad, 0.01)); }),
                HasSubstr("tool: semi-axis"))
        << bad;
    EXPECT_THAT(refusal([=](C& c) { c.device.map.rotation.w() = bad; }),
                HasSubstr(bad == 0.0 ? "must have unit norm" : "is not a finite number"));
    EXPECT_THAT(refusal([=](C& c) { c.device.map.tool.w() = bad; }), HasSubstr("must have unit norm"));
  }
  EXPECT_THAT(refusal([](C& c) { c.scene.registration.translation.x() = kNan; }),
              HasSubstr("translate: nan"));
  EXPECT_THAT(refusal([](C& c) { c.device.hand.mass = -1.0; }), HasSubstr("hand: mass"));
  EXPECT_THAT(refusal([](C& c) { c.scene.filter.crop_box.emplace(); }), HasSubstr("crop-box: "));
  EXPECT_THAT(refusal([](C& c) { c.tool = Tool(std::vector<ToolPart>{}); }), HasSubstr("has 0 ellipsoids"));
  EXPECT_THAT(refusal([](C& c) { c.force.model = static_cast<ForceModelKind>(7); }),
              HasSubstr("model: is not one of proxy"));
  EXPECT_THAT(refusal([](C& c) { c.device.profile = "spoon"; }), HasSubstr("profile: is not one of touch"));
  EXPECT_THAT(refusal([](C& c) { c.loop.cpu = -2; }), HasSubstr("cpu: -2"));
  EXPECT_THAT(refusal([](C& c) { c.gateway.token = "short"; }), HasSubstr("token: "));
}

}  // namespace
}  // namespace palpate::test
