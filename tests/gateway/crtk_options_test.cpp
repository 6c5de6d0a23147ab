// Options of a CRTK device as text.
#include <palpate/gateway/crtk_options.h>

#include <gmock/gmock.h>

#include <palpate/base/error.h>
#include <support/temporary_file.h>

namespace palpate::test {
namespace {

using testing::HasSubstr;

TEST(CrtkOptions, AreReadOneByOne) {
  const CrtkArguments all =
      parse_crtk_arguments("ros1",
                           "/arm/"
                           "left,force_max=12,force_sustained=4,torque_max=0.1,stiffness_max=5000,damping=2,"
                           "angular_damping=0.001,damping_max=3,workspace=0.08,"
                           "rate=500,delay=0.002,one_way=0.001,frame=base,extrapolation=0.003");
  EXPECT_EQ(all.prefix, "/arm/left");
  const DeviceCapabilities& can = all.options.capabilities;
  EXPECT_EQ(can.name, "ros1:/arm/left");
  EXPECT_EQ(can.force_max, 12.0);
  EXPECT_EQ(can.force_sustained, 4.0);
  EXPECT_EQ(can.torque_max, 0.1);
  EXPECT_EQ(can.actuated.rotation, 3);
  EXPECT_EQ(can.stiffness_max, 5000.0);
  EXPECT_EQ(can.damping, 2.0);
  EXPECT_EQ(can.angular_damping, 0.001);
  EXPECT_EQ(can.damping_max, 3.0);
  EXPECT_EQ(can.damping_source, DampingSource::kMeasured);
  EXPECT_EQ(can.workspace, 0.08);
  EXPECT_EQ(can.rate, 500.0);
  EXPECT_EQ(can.delay, 0.002);
  EXPECT_EQ(all.options.one_way, 0.001);
  EXPECT_EQ(all.options.frame, "base");
  EXPECT_EQ(all.options.extrapolation, 0.003);
}

TEST(CrtkOptions, ThatAreMissingAreCautious) {
  const CrtkOptions options = parse_crtk_arguments("ros2", "/omni").options;
  EXPECT_EQ(options.capabilities.force_max, 3.3);
  EXPECT_EQ(options.capabilities.damping, 0.0);
  EXPECT_EQ(options.capabilities.watchdog, 0.0);
  EXPECT_EQ(options.extrapolation, 0.0);
}

TEST(CrtkOptions, ThatAreWrongAreNamed) {
  for (const auto& [text, words] : std::vector<std::pair<std::string, std::string>>{
           {"", "needs the prefix"},
           {"omni", "needs the prefix"},
           {"/omni/", "needs the prefix"},
           {"/o mni", "needs the prefix"},
           {"/omni,rate", "'rate' is not NAME=VALUE"},
           {"/omni,weight=1", "there is no option 'weight'"},
           {"/omni,rate=fast", "'fast' is not a number"},
           {"/omni,rate=500Hz", "'500Hz' is not a number"},
           {"/omni,rate=1e999", "'1e999' is not a number"},
           {"/omni,rate=nan", "'nan' is not a number"},
           {"/omni,rate=-5", "'-5' is not a number"},
           {"/omni,rate=0", "rate must be positive"},
           {"/omni,rate=0.001", "rate must be at least 20 Hz"},
           {"/omni,rate=1", "rate must be at least 20 Hz"},
           {"/omni,rate=19.9", "ros1:/omni,rate=19.9: rate must be at least 20 Hz"},
           {"/omni,force_max=1e9", "force_max must be at most 1000 N"},
           {"/omni,force_max=2,force_sustained=3", "force_sustained must be 0 to force_max"}})
    EXPECT_THAT(message_of<Error>([&] { parse_crtk_arguments("ros1", text); }), HasSubstr(words)) << text;
}

TEST(CrtkOptions, MayBeWhatADeviceCanJustBe) {
  const DeviceCapabilities can =
      parse_crtk_arguments("ros2", "/omni,rate=20,force_max=1000").options.capabilities;
  EXPECT_EQ(can.rate, 20.0);
  EXPECT_EQ(can.force_max, 1000.0);
}

TEST(CrtkOptions, ThePrefixIsANameOfRos) {
  const auto is_accepted = [](const char* kind, const char* prefix) {
    try {
      return parse_crtk_arguments(kind, prefix).prefix == prefix;
    } catch (const Error& error) {
      EXPECT_THAT(error.what(), HasSubstr("needs the prefix"));
      return false;
    }
  };
  for (const char* kind : {"ros1", "ros2"}) {
    for (const char* good : {"/omni", "/_a/B2/c_", "/a"}) EXPECT_TRUE(is_accepted(kind, good)) << good;
    for (const char* bad : {"/", "//omni", "/a//b", "/a/", "a/b", "/~omni", "/a~b", "/a/~", "/1bad~x//y",
                            "/a-b", "/h\xc3\xa4nd"})
      EXPECT_FALSE(is_accepted(kind, bad)) << kind << ' ' << bad;
  }
  for (const char* number : {"/1", "/arm/1", "/2nd/arm"}) {
    EXPECT_TRUE(is_accepted("ros1", number)) << number;
    EXPECT_FALSE(is_accepted("ros2", number)) << number;
  }
}

}  // namespace
}  // namespace palpate::test
