// Settings as clients of the gateway see and change them.
#include <palpate/live/config_json.h>

#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <support/temporary_file.h>

namespace palpate::test {
namespace {

using testing::HasSubstr;

std::string refusal_of_change(const std::string& wanted) {
  LiveConfig config;
  return message_of<Refusal>([&] { change_settings(config, decode_json(wanted)); });
}

TEST(ConfigJson, ShowsTheDefaults) {
  EXPECT_EQ(settings_json({}), decode_json(R"({
    "registration": {"frame": "as-is", "mirrored": false, "scale": 1.0, "rotation": [1.0, 0.0, 0.0, 0.0],
                     "translation": [0.0, 0.0, 0.0],
                     "matrix": [1.0,0.0,0.0,0.0, 0.0,1.0,0.0,0.0, 0.0,0.0,1.0,0.0, 0.0,0.0,0.0,1.0]},
    "filter": {"opacity_min": 0.1, "sigma": 1.0, "iso": 0.0, "max_scale": 0.0, "crop_box": [], "crop_sphere": []},
    "model": "proxy", "stiffness": 500.0, "friction": 0.0, "detail": 0.0,
    "tool": [{"name": "tool", "semi_axes": [0.02, 0.02, 0.04], "position": [0.0, 0.0, 0.0],
              "orientation": [1.0, 0.0, 0.0, 0.0]}],
    "room": {"scale": 1.0, "rotation": [1.0, 0.0, 0.0, 0.0], "translation": [0.0, 0.0, 0.0]}})"));
}

TEST(ConfigJson, ChangesWhatIsNamed) {
  LiveConfig config;
  config.scene.filter.iso = 0.5;
  change_settings(config, decode_json(R"({"model": "density", "stiffness": 800, "detail": 0.004,
    "filter": {"sigma": 2}, "registration": {"frame": "y-up", "mirrored": true, "scale": 3},
    "room": {"translation": [1, 2, 3]}, "tool": [{"semi_axes": [0.01, 0.02, 0.03], "position": [0, 0, 1]}]})"));
  LiveConfig expected;
  expected.force.model = ForceModelKind::kDensity;
  expected.force.proxy.stiffness = 800.0;
  expected.force.proxy.detail = 0.004;
  expected.scene.filter.sigma = 2.0;  // which ends iso
  expected.scene.frame = UpAxis::kYUp;
  expected.scene.registration.mirrored = true;
  expected.scene.registration.scale = 3.0;
  expected.room.translation = {1, 2, 3};
  expected.tool = Tool(std::vector<ToolPart>{{"", {0.01, 0.02, 0.03}, {{0, 0, 1}, {1, 0, 0, 0}}}});
  EXPECT_EQ(config, expected);
  change_settings(config, {{"detail", 0}});
  EXPECT_FALSE(config.force.proxy.detail);
}

TEST(ConfigJson, SetsAndUnsetsWhatTheFilterDrops) {
  LiveConfig config;
  change_settings(config, decode_json(R"({"filter": {"max_scale": 0.5, "crop_box": [-1, -2, -3, 1, 2, 3],
    "crop_sphere": [1, 2, 3, 4]}})"));
  const SceneFilter& filter = config.scene.filter;
  EXPECT_EQ(filter.max_scale, 0.5);
  EXPECT_TRUE(filter.crop_box &&
              filter.crop_box->isApprox({Eigen::Vector3d(-1, -2, -3), Eigen::Vector3d(1, 2, 3)}));
  EXPECT_TRUE(filter.crop_sphere && filter.crop_sphere->radius == 4.0);
  change_settings(config, decode_json(R"({"filter": {"max_scale": 0, "crop_box": [], "crop_sphere": []}})"));
  EXPECT_EQ(config, LiveConfig());
}

TEST(ConfigJson, RefusesWhatIsUnknownOrOutOfRange) {
  EXPECT_EQ(refusal_of_change(R"({"stifness": 1})"),
            "parameters has no 'stifness'; it has detail, filter, friction, model, registration, room, "
            "stiffness, tool");
  EXPECT_EQ(refusal_of_change(R"({"filter": {"iso": 0.5}})"),
            "filter has no 'iso'; it has crop_box, crop_sphere, max_scale, opacity_min, sigma");
  EXPECT_THAT(refusal_of_change(R"({"filter.sigma": 2})"), HasSubstr("has no 'filter.sigma'"));
  EXPECT_EQ(refusal_of_change(R"({"filter": 1})"), "'filter' must be an object");
  EXPECT_EQ(refusal_of_change(R"({"filter": {"crop_box": [1, 0, 0, 0, 1, 1]}})"),
            "'crop_box': the first corner must be below the second");
  EXPECT_EQ(refusal_of_change(R"({"filter": {"crop_box": [1]}})"), "'crop_box' must be 6 numbers");
  EXPECT_EQ(refusal_of_change(R"({"model": "mesh"})"), "'model' must be one of proxy, field, density");
  EXPECT_EQ(refusal_of_change(R"({"detail": 11})"), "'detail' must be a number from 0 to 10");
  EXPECT_EQ(refusal_of_change(R"({"registration": {"mirrored": 1}})"), "'mirrored' must be true or false");
  EXPECT_EQ(refusal_of_change(R"({"room": {"rotation": [0, 0, 0, 0]}})"),
            "'rotation': the quaternion qw,qx,qy,qz must have a norm between 1e-6 and 1e6");
  EXPECT_EQ(refusal_of_change(R"({"room": {"translation": [0, 0]}})"), "'translation' must be 3 numbers");
  EXPECT_THAT(refusal_of_change(R"({"tool": [{"semi_axes": [0, 1, 1]}]})"), HasSubstr("'semi_axes' must be"));
}

}  // namespace
}  // namespace palpate::test
