#include <palpate/rosbridge/ros_message.h>

#include <cmath>
#include <limits>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <palpate/geometry/rotation.h>
#include <support/random_pairs.h>
#include <support/temporary_file.h>

namespace palpate {
namespace {

using Eigen::Matrix3d;
using Eigen::Quaterniond;
using Eigen::Vector3d;
using test::message_of;
using test::Random;
using testing::HasSubstr;

constexpr Color kColor{0.1, 0.2, 0.3, 0.4};

double number(const Json& of, const char* name) { return of.at(name).get<double>(); }
Vector3d vector_of(const Json& v) { return {number(v, "x"), number(v, "y"), number(v, "z")}; }
Quaterniond quaternion_of(const Json& q) {
  return {number(q, "w"), number(q, "x"), number(q, "y"), number(q, "z")};
}

Json pose_message() {
  return {{"header", {{"seq", 4}, {"stamp", {{"secs", 12}, {"nsecs", 345}}}, {"frame_id", "world"}}},
          {"pose",
           {{"position", {{"x", 1}, {"y", -2.5}, {"z", 3e-3}}},
            {"orientation", {{"x", 0.6}, {"y", 0}, {"z", 0}, {"w", 0.8}}}}}};
}

TEST(PoseStamped, IsReadAsRos1HasIt) {
  const StampedPose said = pose_stamped(pose_message());
  EXPECT_EQ(said.pose.position, Vector3d(1, -2.5, 0.003));
  EXPECT_LE((said.pose.orientation.coeffs() - Eigen::Vector4d(0.6, 0, 0, 0.8)).norm(), 1e-15);  // x, y, z, w
  EXPECT_EQ(said.stamp.seconds, 12);
  EXPECT_EQ(said.stamp.nanoseconds, 345);
  EXPECT_EQ(said.frame, "world");
}

TEST(PoseStamped, IsReadAsRos2HasIt) {
  Json message = pose_message();
  message["header"] = {{"stamp", {{"sec", 12}, {"nanosec", 345}}}, {"frame_id", "device"}};
  const StampedPose said = pose_stamped(message);
  EXPECT_EQ(said.stamp.seconds, 12);
  EXPECT_EQ(said.stamp.nanoseconds, 345);
  EXPECT_EQ(said.frame, "device");
}

TEST(PoseStamped, NeedsNoHeader) {
  for (const Json& header :
       {Json(), Json(3), Json::object(), Json{{"stamp", 5}}, Json{{"stamp", {{"secs", "1"}}}},
        Json{{"stamp", {{"secs", 1.5}}}}, Json{{"frame_id", nullptr}}}) {
    Json message = pose_message();
    message["header"] = header;
    const StampedPose said = pose_stamped(message);
    EXPECT_EQ(said.frame, "") << header.dump();
    EXPECT_EQ(said.stamp.seconds, 0) << header.dump();
    EXPECT_EQ(said.stamp.nanoseconds, 0) << header.dump();
  }
  Json message = pose_message();
  message.erase("header");
  EXPECT_EQ(pose_stamped(message).frame, "");
}

TEST(PoseStamped, RefusesEveryNumberThatIsMissingOrNone) {
  for (const auto& [object, name] : std::vector<std::pair<std::string, std::string>>{{"position", "x"},
                                                                                     {"position", "y"},
                                                                                     {"position", "z"},
                                                                                     {"orientation", "x"},
                                                                                     {"orientation", "y"},
                                                                                     {"orientation", "z"},
                                                                                     {"orientation", "w"}}) {
    Json message = pose_message();
    message["pose"][object].erase(name);
    EXPECT_THAT(message_of<Refusal>([&] { pose_stamped(message); }), HasSubstr("'" + name + "' is missing"));
    for (const Json& value :
         {Json(), Json("1"), Json(true), Json::array({1}), Json(std::nan("")),
          Json(std::numeric_limits<double>::infinity()), Json(-std::numeric_limits<double>::infinity())}) {
      message["pose"][object][name] = value;
      EXPECT_THAT(message_of<Refusal>([&] { pose_stamped(message); }),
                  HasSubstr("'" + name + "' must be a finite number"))
          << value.dump();
    }
  }
}

TEST(PoseStamped, RefusesEveryObjectThatIsMissingOrNone) {
  const auto refusal = [](const Json& message) {
    return message_of<Refusal>([&] { pose_stamped(message); });
  };
  for (const Json& value : {Json(), Json(1), Json("x"), Json::array()}) {
    Json message = pose_message();
    message["pose"]["position"] = value;
    EXPECT_THAT(refusal(message), HasSubstr("'position' must be an object"));
    message = pose_message();
    message["pose"]["orientation"] = value;
    EXPECT_THAT(refusal(message), HasSubstr("'orientation' must be an object"));
    message["pose"] = value;
    EXPECT_THAT(refusal(message), HasSubstr("'pose' must be an object"));
  }
  EXPECT_THAT(refusal(Json::object()), HasSubstr("'pose' is missing"));
  EXPECT_THAT(refusal({{"pose", Json::object()}}), HasSubstr("'position' is missing"));
  Json message = pose_message();
  message["header"]["frame_id"] = 7;
  EXPECT_THAT(refusal(message), HasSubstr("'frame_id' must be text"));
}

TEST(PoseStamped, NormalisesWhatIsNearlyAUnitQuaternionAndRefusesTheRest) {
  const auto with_norm = [](double norm) {
    Json message = pose_message();
    message["pose"]["orientation"] = {{"x", 0.6 * norm}, {"y", 0}, {"z", 0}, {"w", 0.8 * norm}};
    return message;
  };
  for (const double norm : {0.991, 1.0, 1.009}) {
    const Quaterniond q = pose_stamped(with_norm(norm)).pose.orientation;
    EXPECT_NEAR(q.norm(), 1.0, 1e-15);
    EXPECT_NEAR(q.x(), 0.6, 1e-15);
  }
  for (const double norm : {0.0, 1e-200, 0.98, 1.02, -1.02, 1e200})
    EXPECT_THAT(message_of<Refusal>([&] { pose_stamped(with_norm(norm)); }), HasSubstr("unit quaternion"))
        << norm;
}

TEST(PoseStamped, RefusesWhatIsTooFarAway) {
  Json message = pose_message();
  message["pose"]["position"]["y"] = -0.99e6;
  EXPECT_EQ(pose_stamped(message).pose.position.y(), -0.99e6);
  for (const double y : {1.01e6, -1e200, 1e308}) {
    message["pose"]["position"]["y"] = y;
    EXPECT_THAT(message_of<Refusal>([&] { pose_stamped(message); }), HasSubstr("1000 km"));
  }
}

TEST(Header, IsThatOfRos1) {
  EXPECT_EQ(header({5, 6}, "world", 7),
            (Json{{"seq", 7}, {"stamp", {{"secs", 5}, {"nsecs", 6}}}, {"frame_id", "world"}}));
}

TEST(ToJson, NamesEveryPart) {
  const Json v{{"x", 1.0}, {"y", 2.0}, {"z", 3.0}}, w{{"x", 4.0}, {"y", 5.0}, {"z", 6.0}};
  EXPECT_EQ(to_json(Vector3d(1, 2, 3)), v);
  EXPECT_EQ(to_json(Quaterniond(4, 1, 2, 3)), (Json{{"x", 1.0}, {"y", 2.0}, {"z", 3.0}, {"w", 4.0}}));
  EXPECT_EQ(to_json(Twist{{1, 2, 3}, {4, 5, 6}}), (Json{{"linear", v}, {"angular", w}}));
  EXPECT_EQ(to_json(Wrench{{1, 2, 3}, {4, 5, 6}}), (Json{{"force", v}, {"torque", w}}));
  const Pose pose{{1, 2, 3}, Quaterniond(0.8, 0.6, 0, 0)};
  const StampedPose back = pose_stamped({{"pose", to_json(pose)}});
  EXPECT_EQ(back.pose.position, pose.position);
  EXPECT_TRUE(back.pose.orientation.isApprox(pose.orientation, 1e-15));
}

/// That a marker is the ellipsoid, and a rotation.
void expect_same(const Json& marker, const Ellipsoid& ellipsoid) {
  EXPECT_EQ(vector_of(marker.at("pose").at("position")), ellipsoid.center);
  const Quaterniond q = quaternion_of(marker.at("pose").at("orientation"));
  ASSERT_NEAR(q.norm(), 1.0, 1e-12);
  const Vector3d half = vector_of(marker.at("scale")) / 2.0;
  ASSERT_TRUE(half.allFinite());
  EXPECT_GE(half.minCoeff(), 0.0);
  const Matrix3d axes = q.toRotationMatrix() * half.asDiagonal(), wanted = ellipsoid.axes;
  EXPECT_LE((axes * axes.transpose() - wanted * wanted.transpose()).norm(), 1e-12 * wanted.squaredNorm())
      << "axes\n"
      << wanted << "\nof the marker\n"
      << axes;
}

// Of any lengths in any order, and of any handedness: a column's sign is free. What is flat is a disc, what
// is flat twice a needle, and three times a point.
TEST(EllipsoidMarker, IsTheEllipsoid) {
  Random random(3);
  for (int draw = 0; draw < 3000; ++draw) {
    Vector3d lengths = random.semi_axes(1e-6, 10.0);
    if (draw % 7 == 0) lengths[1] = lengths[0];
    if (draw % 14 == 0) lengths[2] = lengths[0];
    for (int flat = draw % 4; flat > 0; --flat) lengths[random.integer(0, 2)] = 0.0;
    const Pose pose{random.in_box(10.0), random.rotation()};
    Ellipsoid ellipsoid = Ellipsoid::from_semi_axes(pose, lengths);
    if (draw % 2 == 0) ellipsoid.axes.col(random.integer(0, 2)) *= -1.0;
    expect_same(to_json(header({}, "world", 0), ellipsoid_marker("ns", 0, ellipsoid, kColor)), ellipsoid);
    if (testing::Test::HasFailure()) FAIL() << "draw " << draw;
  }
}

TEST(EllipsoidMarker, OfAxesAlongTheFramesIsThem) {
  for (int zero = 0; zero < 8; ++zero) {  // every choice of axes that are none
    const Vector3d lengths((zero & 1) != 0 ? 0.0 : 0.01, (zero & 2) != 0 ? 0.0 : 0.02,
                           (zero & 4) != 0 ? 0.0 : 0.03);
    const Ellipsoid ellipsoid = Ellipsoid::from_semi_axes({}, lengths);
    const Json marker = to_json(header({}, "world", 0), ellipsoid_marker("ns", 0, ellipsoid, kColor));
    expect_same(marker, ellipsoid);
    EXPECT_EQ(vector_of(marker.at("scale")), 2.0 * lengths) << "each length stays with its axis";
  }
}

TEST(EllipsoidMarker, HasTheFieldsOfAMarker) {
  const Json head = header({1, 2}, "world", 3);
  const Json marker = to_json(head, ellipsoid_marker("contacts", 42, {}, kColor));
  EXPECT_EQ(marker["header"], head);
  EXPECT_EQ(marker["ns"], "contacts");
  EXPECT_EQ(marker["id"], 42);
  EXPECT_EQ(marker["type"], 2);    // SPHERE
  EXPECT_EQ(marker["action"], 0);  // ADD
  EXPECT_EQ(marker["color"], (Json{{"r", 0.1}, {"g", 0.2}, {"b", 0.3}, {"a", 0.4}}));
  // int32 in ROS: ids from 2^31 on wrap, and stay apart.
  EXPECT_EQ(to_json(head, ellipsoid_marker("contacts", 4'000'000'000U, {}, kColor))["id"], -294'967'296);
}

TEST(ArrowMarker, GoesFromPointToPoint) {
  const Json head = header({1, 2}, "world", 3);
  const Json marker = to_json(head, arrow_marker("normals", 42, {1, 2, 3}, {4, 5, 6}, 0.01, kColor));
  EXPECT_EQ(marker["header"], head);
  EXPECT_EQ(marker["ns"], "normals");
  EXPECT_EQ(marker["id"], 42);
  EXPECT_EQ(marker["type"], 0);    // ARROW
  EXPECT_EQ(marker["action"], 0);  // ADD
  ASSERT_EQ(marker["points"].size(), 2U);
  EXPECT_EQ(vector_of(marker["points"][0]), Vector3d(1, 2, 3));
  EXPECT_EQ(vector_of(marker["points"][1]), Vector3d(4, 5, 6));
  EXPECT_EQ(marker["scale"]["x"], 0.01);  // of the shaft; of the head; its length, 0: as RViz likes it
  EXPECT_EQ(marker["scale"]["y"], 0.02);
  EXPECT_EQ(marker["scale"]["z"], 0.0);
  EXPECT_EQ(quaternion_of(marker["pose"]["orientation"]).w(), 1.0);
}

TEST(DeletedMarkers, SayWhatIsDeleted) {
  const Json one = to_json(header({}, "world", 0), deleted_marker("contacts", 42));
  EXPECT_EQ(one["action"], 2);
  EXPECT_EQ(one["ns"], "contacts");
  EXPECT_EQ(one["id"], 42);
  EXPECT_EQ(to_json(header({}, "world", 0), all_deleted_marker())["action"], 3);
}

}  // namespace
}  // namespace palpate
